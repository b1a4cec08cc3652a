"""The error of a loop that is unstable, apart from the survey that raises it."""


class UnstableLoopError(ValueError):
    """The closed loop is not asymptotically stable, so that it has no survey."""
