"""Blocks out as FMUs, and loops as SSPs: what a block is, its C sources, compilers, archives."""
