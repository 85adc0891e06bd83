"""Wrong values of the arguments of a function, from its signature alone."""

import inspect
import math
import re

import numpy as np

from beltrepro import ChainParameters

HUGE = 10**5000  # beyond a double, and beyond what Python writes as text
ANYWHERE = {
    "object": object(),
    "class": int,
    "set": {1.0},
    "mapping": {"a": 1},
    "nothing in it": [],
    "complex": 1j,
    "word": "much",
    "number as text": "1",
    "bytes": b"1",
}
NUMBER = {
    "nan": math.nan,
    "infinite": math.inf,
    "minus infinite": -math.inf,
    "negative": -1.0,
    "huge": HUGE,
    "true": True,
    "nested": [[1.0]],
    "table": np.ones((1, 2)),
    "array without axes": np.array(1.0),
    "duration of NumPy": np.timedelta64(1, "s"),
}
ARRAY = {
    "single number": 1.0,
    "array without axes": np.array(1.0),
    "nan in it": [50.0, math.nan],
    "infinite in it": [50.0, math.inf],
    "texts in it": ["50", "100"],
    "complex in it": np.array([50.0, 1j]),
    "wrong shape": [[[50.0, 100.0]]],
    "ragged": [[1.0, 2.0], [3.0]],
}
RISING = {"unsorted": [100.0, 50.0], "duplicate": [50.0, 50.0], "negative in it": [-50.0, 100.0]}
TOO_MANY = {"too many": [1.0, 2.0, 3.0]}
NOT_NONE = {"none": None}

# The kind of an argument is the first of these words in its annotation. An int is a valid float,
# and every number of the package is 0 or greater, but for velocities.
KINDS = {
    "Chains": {"number": 5, "none in it": [None], "class": ChainParameters},
    "ChainParameters": {"number": 5, "none in it": [None], "class": ChainParameters},
    "ChainState": {"number": 5, "number in it": [5]},
    "Run": {"number": 5, "class": ChainParameters},
    "Report": {"number": 5, "true": True},
    "ArrayLike": ARRAY,
    "Path": {"number": 5, "no name": "a\0.h5"},
    "str": {"empty": "", "number": 1, "nan": math.nan, "true": True},
    "int": NUMBER | {"fraction": 1.5},
    "float": NUMBER,
}
# By the kind, which of the values that are wrong anywhere are right.
ALLOWED = {"Path": ("word", "number as text", "bytes"), "Report": ("class",)}


def annotation(parameter: inspect.Parameter) -> str:
    """The annotation as text."""
    given = parameter.annotation
    return given if isinstance(given, str) else given.__name__


def kind_of(parameter: inspect.Parameter) -> str:
    """The kind of an argument, one of `KINDS`."""
    words = annotation(parameter)
    return next(kind for kind in KINDS if re.search(rf"\b{kind}\b", words))


def wrong_values(parameter: inspect.Parameter) -> dict[str, object]:
    """Values that the argument of a function about one chain cannot have, by what they are."""
    words, kind = annotation(parameter), kind_of(parameter)
    found = ANYWHERE | KINDS[kind]
    if kind == "ArrayLike" and not parameter.name.endswith("velocities"):
        found |= RISING
    if kind in ("int", "float", "str") and not re.search("PerChain|Sequence|Axis", words):
        found |= {"list": ["event" if kind == "str" else 1.0]}
    if parameter.name.endswith(("position", "positions", "velocities")):
        found |= TOO_MANY
    if "Sequence[float]" in words:
        found |= ARRAY
    if "None" not in words:
        found |= NOT_NONE
    return {name: value for name, value in found.items() if name not in ALLOWED.get(kind, ())}
