"""`python -m motorspace`, as `motorspace`."""

from motorspace.cli.main import main

main()
