"""What `tools/bench` measures, one module per subject; each has `run(say)`, which reports line by line."""
