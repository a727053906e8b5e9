"""Checks that an agent, sensor, encoder or reader of one's own must pass; ours pass them too.

Each raises `AssertionError` with a sentence that says what is wrong.
"""
