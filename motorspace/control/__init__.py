"""Motor commands that reach a goal, planned in the space of codes."""
