"""Tables that analyses derive from datasets, one module each.

Every module NAME with `ENTRY = Entry(...)` has `derive(data)`, which returns the DataFrame of
NAME.csv; data maps the names in ENTRY.uses to `store.Dataset` (or DataFrame, for another table).
"""
