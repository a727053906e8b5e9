"""Walks through time: simulated, or read from robots' logs."""
