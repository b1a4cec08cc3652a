"""FMUs and models run together."""
