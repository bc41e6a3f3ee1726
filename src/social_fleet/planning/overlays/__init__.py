"""Obstacles that the map does not hold: their shapes, the set of those that are there, and plans round them."""
