"""Figures, one module each: those of the paper, of the comparison of integrators, of own studies.

A module is a figure if it has `ENTRY = Entry(...)` (title, datasets, words, alternative text: see
`figures.registry`) and `draw(data, caption)`, which returns a matplotlib Figure. data maps the
names in `ENTRY.uses` to `store.Dataset`; caption is the small print below. Nothing here simulates;
estimates come from `beltrepro.analysis`, and where it finds too few data the panel says so.

A dataset NAME_check is drawn over the scan NAME, whose points another integrator computed.
"""
