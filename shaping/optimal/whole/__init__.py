"""Minimum time over the whole horizon: between any states, under any bounds, position's too."""
