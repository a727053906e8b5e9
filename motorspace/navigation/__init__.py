"""Tasks in which an agent must get somewhere, and reinforcement learning that solves them."""
