"""What the exit status of a command says, besides 0 for what is done."""

CHECK_FAILED = 1
BAD_INPUT = 2
INTERRUPTED = 130
