"""Checks that every agent, sensor, encoder or reader must pass, those of one's own too."""
