"""A judge that knows the place: what an agent will sense after a sequence, where it is now."""
