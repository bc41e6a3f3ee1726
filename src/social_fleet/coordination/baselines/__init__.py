"""The field's planners for fleets on a grid, to compare with: conflict-based search and prioritized planning."""
