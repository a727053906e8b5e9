"""Readers of robots' logs: one file a format, all giving the same `Recording`."""
