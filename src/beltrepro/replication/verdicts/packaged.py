"""Texts that are part of the package."""

from importlib import resources
from typing import Any

import yaml

# PyYAML's own reader takes ten times as long; it is the one where libyaml is not to be had.
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_yaml(room: str, name: str) -> Any:
    """Content of a YAML file that is part of the package."""
    text = resources.files(room).joinpath(name).read_text(encoding="utf-8")
    return yaml.load(text, Loader=_Loader)
