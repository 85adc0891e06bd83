"""Estimators of Sec. IV and V: arrays in, numbers with errors out.

Nothing here reads files or draws. Every decision (what is a transition region, what is
intermittent) has its criterion in the docstring of the function that takes it.
"""
