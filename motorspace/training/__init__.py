"""Learning: configuration, the compiled loop, the folder of a run."""
