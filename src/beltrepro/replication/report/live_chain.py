"""The chain, live: the paper's scheme runs in the page itself, with the model's constants."""

from importlib import resources

import yaml

from beltrepro.model import ChainParameters
from beltrepro.model.spring import SECTION_POSITION
from beltrepro.model.units import TIME_S
from beltrepro.replication.report.material import Material

STYLES = ("live/live.css",)
_CHAIN = ChainParameters(5, 17.0)  # the paper's; its velocity plays no part
_LAW = ("rest_length", "linear_limit", "compression_rate", "extension_rate", "static_friction")
_BLOCK = 28.6  # length of a block, 4 cm


def gather(_: Material) -> dict:
    """Controls, constants and beginnings; the same for every run."""
    folder = resources.files("beltrepro.replication.report") / "live"
    choices = yaml.safe_load((folder / "presets.yaml").read_text(encoding="utf-8"))
    for preset in choices["presets"]:
        preset["settings"]["f"] = _CHAIN.friction_ratio
    law = {name: getattr(_CHAIN, name) for name in _LAW} | {"section": SECTION_POSITION}
    law["section_chain"] = {"blocks": _CHAIN.n_blocks, "ratio": _CHAIN.friction_ratio}
    settings = {"law": law, "second": TIME_S, "block": _BLOCK, "presets": choices["presets"]}
    return choices | {"second": f"{TIME_S:.4f}", "settings": settings}
