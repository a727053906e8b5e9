"""Where: places, bodies and sensors, as pure functions on arrays."""
