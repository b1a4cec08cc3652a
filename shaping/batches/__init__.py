"""Many moves and transfers at once, on arrays."""
