"""Datasets as values: quantities, kinds, the plan of a preset, and the files that hold the arrays.

A dataset is a named table of points. A point has a value of every quantity (`quantities`), so any
of them can be an axis. A kind says what is recorded of the points (`kinds`). `plan` makes the
datasets of a preset from config.yaml, `schema` the schema of config.yaml, `files` reads and writes.
Snakemake imports these for every job: none of them loads the simulation, pandas or matplotlib.
`running` simulates.
"""
