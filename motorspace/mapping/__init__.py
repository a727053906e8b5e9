"""Odometry from codes, where the rays point, and maps: learned without a pose."""
