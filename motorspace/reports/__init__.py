"""Show: figures, tables and pages. Numbers come in; nothing is computed here."""
