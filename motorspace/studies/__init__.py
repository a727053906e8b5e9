"""Studies: questions that many runs answer, one file for each.

`motorspace.studies.study` says what a study is; whatever module of this folder defines a `STUDY`
is found by itself.
"""
