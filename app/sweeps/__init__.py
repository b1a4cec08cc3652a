"""Sweeps: a scenario at many values of what is not known, and what becomes of its figures."""
