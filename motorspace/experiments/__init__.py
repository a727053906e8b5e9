"""The paper's experiments, recorded robots, and the first look."""
