"""The sections of the report, in their order.

A section is a module here with TITLE, ANCHOR, NEEDS (names of the files without which it is left
out, as in `material.Material.files`) and `gather(material)`, which returns the values for the
template of the same name beside it, NAME.html.j2. `summary` stands above the list of contents.
"""

from types import ModuleType

from beltrepro.report.sections import (
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
    runs,
    summary,
    times,
)

SUMMARY = summary
SECTIONS: tuple[ModuleType, ...] = (
    claims,
    chaos,
    inference,
    player,
    experiment,
    figures,
    integrators,
    open_points,
    deviations,
    runs,
    times,
    environment,
)
