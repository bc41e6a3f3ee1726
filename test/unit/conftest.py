"""For all unit tests: a run started in the background ignores SIGINT, and its children would ignore Ctrl-C, too."""

import signal

signal.signal(signal.SIGINT, signal.default_int_handler)
