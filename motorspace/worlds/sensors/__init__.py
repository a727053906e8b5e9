"""Senses: what an agent perceives from a pose in a world."""
