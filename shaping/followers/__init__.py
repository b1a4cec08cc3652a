"""Following any command within bounds, one sample at a time."""
