"""Many rest-to-rest moves at once, on arrays."""
