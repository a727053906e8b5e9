"""Learning: configuration, the compiled loop, and the folder of a run."""
