"""The command line: parse, call, print. One file per family of commands.

Nothing heavy is imported before a command has understood what it was given: help, a wrong flag
and a wrong file answer at once.
"""
