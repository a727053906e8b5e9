"""`python -m motorspace`, as `motorspace`."""

from motorspace.cli import main

main()
