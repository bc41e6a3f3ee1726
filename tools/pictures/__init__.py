"""The pictures of doc/planning.md, drawn by tools/draw_pictures."""
