"""Side by side with other software: `python -m benchmarks` (see docs/performance.md)."""
