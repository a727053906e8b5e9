"""What is learned: networks that take one sequence, one element."""
