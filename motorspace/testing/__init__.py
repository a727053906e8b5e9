"""Checks that an agent, sensor, encoder or reader of one's own must pass; ours pass them too.

Each raises `AssertionError` with a sentence that says what is wrong.
"""

from motorspace.testing.agent import check_agent as check_agent
from motorspace.testing.encoder import check_encoder as check_encoder
from motorspace.testing.reader import check_reader as check_reader
from motorspace.testing.reader import check_recording as check_recording
from motorspace.testing.sensor import check_sensor as check_sensor
