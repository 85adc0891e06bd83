"""The sections of the report, in their order.

A section is a module here with TITLE, ANCHOR, NEEDS (names of the files without which it is left
out, as in `material.Material.files`) and `gather(material)`, which returns the values for the
template of the same name beside it, NAME.html.j2. `summary` stands above the list of contents.
"""

from types import ModuleType

from beltrepro.replication.report.sections import (
    chaos,
    claims,
    deviations,
    environment,
    experiment,
    figures,
    inference,
    integrators,
    open_points,
    player,
    presets,
    runs,
    sensitivity,
    summary,
    times,
)

SUMMARY = summary
SECTIONS: tuple[ModuleType, ...] = (
    claims,
    figures,
    sensitivity,
    open_points,
    presets,
    chaos,
    inference,
    player,
    experiment,
    integrators,
    deviations,
    runs,
    times,
    environment,
)
