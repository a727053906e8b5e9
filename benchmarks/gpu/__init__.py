"""What one GPU does: `python -m benchmarks.gpu [PART ...] [--small] [--out FILE]`.

Each part is measured in one process, beside a peer or a bound on the same device. `--small` tries
all of it at tiny sizes on whatever device there is.
"""
