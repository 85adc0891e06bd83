"""Configurations and plans of one small dataset."""

from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.plan.plan import Plan, make_plan

LENGTHS = {"duration": 100, "transient": 50, "settle_time": 50}


def configuration(kind: str = "scan", *, name: str = "one", preset: str = "own", **keys) -> dict:
    """One dataset, of one point unless the keys say otherwise."""
    point = {"kind": kind, "n_blocks": 2, "belt_velocity": 10, "method": "event"}
    lengths = {name: LENGTHS[name] for name in KINDS[kind].settings if name in LENGTHS}
    presets = {preset: {"defaults": {}, "datasets": {}}}
    datasets = {name: point | lengths | keys}
    return {"preset": preset, "seed": 3, "datasets": datasets, "presets": presets}


def planned(kind: str = "scan", **keys) -> Plan:
    """Its plan."""
    return make_plan(configuration(kind, **keys))
