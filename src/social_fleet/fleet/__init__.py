"""What robots say to each other, over any transport; knows no nodes. See doc/coordination.md, "Work sharing"."""
