"""Is it organised? Measures that work on anybody's codes and displacements."""
