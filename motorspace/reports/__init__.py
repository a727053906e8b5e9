"""Show: figures, tables and pages of anybody's arrays. Nothing is computed here."""
