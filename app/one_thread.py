"""The BLAS in one thread: matrices here are small, and a second thread only waits for a core."""

import os

_LIBRARIES = ("OPENBLAS", "MKL", "OMP")


def calculate_in_one_thread() -> None:
    """Ask so by the environment, which is read when numpy is first imported; what is set stays."""
    for library in _LIBRARIES:
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
