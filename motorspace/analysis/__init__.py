"""Measure: how the structure of codes follows that of displacements, on anybody's arrays."""
