"""What leaves: a run's arrays and networks for other programs, and runs side by side."""
