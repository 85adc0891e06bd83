"""Figures of the paper, one module each.

Every module figNN has TITLE (one sentence), USES (names of the datasets it shows, with what is
taken from each), and `draw(data, caption)`, which returns a matplotlib Figure. data maps the names
in USES to `store.Dataset`; caption is the small print below. Nothing here simulates; estimates come
from `beltrepro.analysis`, and where it finds too few data the panel says so.

Figures that compare integrators also take NAME_check for a scan NAME in USES: it is drawn over it.
"""
