"""The figures of Thompson's paper, each drawn by one function, and their numbers."""
