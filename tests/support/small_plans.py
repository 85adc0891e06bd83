"""Configurations and plans of one small dataset."""

from beltrepro.replication.plan.kinds import KINDS, SETTINGS
from beltrepro.replication.plan.plan import Plan, make_plan
from beltrepro.replication.plan.points import REQUIRED

LENGTHS = {"duration": 100, "transient": 50, "settle_time": 50}


def configuration(kind: str = "scan", *, name: str = "one", preset: str = "own", **keys) -> dict:
    """One dataset, of one point unless the keys say otherwise."""
    required = [name for name in KINDS[kind].settings if SETTINGS[name].default is REQUIRED]
    point = {"kind": kind, "n_blocks": 2, "belt_velocity": 10, "method": "event"}
    dataset = point | {name: LENGTHS[name] for name in required} | keys
    presets = {preset: {"defaults": {}, "datasets": {}}}
    return {"preset": preset, "seed": 3, "datasets": {name: dataset}, "presets": presets}


def planned(kind: str = "scan", **keys) -> Plan:
    """Its plan."""
    return make_plan(configuration(kind, **keys))
