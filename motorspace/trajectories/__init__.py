"""What happened: transitions, sampled from a world or cut out of a recording."""
