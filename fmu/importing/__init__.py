"""Anybody's FMUs in: read safely, stepped quickly, as python-control systems, linearised."""
