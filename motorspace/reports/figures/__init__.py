"""Pictures as functions: arrays or rows in, a matplotlib figure out."""
