"""Which figures and tables the studies have, and what each says of itself, without importing any.

The `figures.py` of a study assigns `FIGURES = {"name": Figure(...)}`, and has a function of each
name that draws the figure; `TABLES = {"name": Table(...)}` in its `measure.py` stands for functions
that make tables. They are read without the rest of the module: the workflow asks for them in every
job and must not wait for pandas and matplotlib. Words may stand in `words.yaml` beside it.
"""

import ast
import functools
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TypeVar

from beltrepro.base.errors import InputError
from beltrepro.base.names import hint, one_of
from beltrepro.replication.plan.points import read_yaml

STUDIES = Path(__file__).parent.parent / "studies"
CATEGORIES = ("Figures of the paper", "Integrators compared", "Further studies")


@dataclass(frozen=True, kw_only=True)
class _Entry:
    """What is made from datasets and tables, and what it says of itself."""

    uses: tuple[str, ...]  # names of the datasets and tables that it is made from
    title: str = ""  # one sentence
    module: str = field(default="", compare=False)  # dotted name


@dataclass(frozen=True, kw_only=True)
class Table(_Entry):
    """A table, as a study names it."""

    # what single columns are, with their unit; quantities of a point explain themselves
    columns: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Figure(_Entry):
    """A figure; its title is also that of the target in `snakemake --list`."""

    words: str = ""  # what the figure of the paper shows, in our words; of another, how to read it
    alt: str = ""  # what ours shows, for readers who cannot see it
    number: str = ""  # of the figure in the paper; empty for a figure that the paper does not have
    category: str = CATEGORIES[0]
    # names of the estimates that it draws or prints, by claim: "u-critical", or "u-critical: exact
    # dynamics" for a variant. A star in a name stands for any text
    shows: dict[str, tuple[str, ...]] = field(default_factory=dict)


E = TypeVar("E", Table, Figure)


@functools.cache
def figures(folder: Path = STUDIES) -> dict[str, Figure]:
    """All figures by name, those of the paper first, in its order; InputError for a wrong entry."""
    entries = _entries(folder, "figures.py", "FIGURES", Figure)
    for name, figure in entries.items():
        one_of(f"figure {name}: category", figure.category, CATEGORIES)
    places = {name: (CATEGORIES.index(entry.category), name) for name, entry in entries.items()}
    return {name: entries[name] for name in sorted(entries, key=places.__getitem__)}


@functools.cache
def tables(folder: Path = STUDIES) -> dict[str, Table]:
    """All tables by name; InputError for a wrong entry."""
    return dict(sorted(_entries(folder, "measure.py", "TABLES", Table).items()))


def figures_with(claim: str, variant: str, estimate: str) -> list[str]:
    """Names of the figures that show this estimate of a claim."""
    key = f"{claim}: {variant}" if variant else claim
    return [
        name
        for name, entry in figures().items()
        if any(fnmatchcase(estimate, pattern) for pattern in entry.shows.get(key, ()))
    ]


def check_names(datasets: Iterable[str]) -> None:
    """Raise InputError for a dataset whose name stands for something else."""
    for name in datasets:
        if name in tables():
            raise InputError(f"datasets.{name} has the name of a table")
        if name == "self" or hasattr(list, name) or hasattr(dict, name):
            raise InputError(f"datasets.{name}: Snakemake keeps this name for itself")


def check_uses(entries: dict, inputs: Collection[str], where: str) -> None:
    """Raise InputError for an entry that uses what is not among the datasets and tables there.

    where : what has them, for the message: "preset smoke".
    """
    for name, entry in entries.items():
        for used in entry.uses:
            if used not in inputs:
                raise InputError(f"{name} uses {used!r}, which {where} lacks{hint(used, inputs)}")


def _entries(folder: Path, file: str, label: str, kind: type[E]) -> dict[str, E]:
    """What the modules of this name assign to a label at their top, with the words beside them."""
    entries: dict[str, E] = {}
    for path in sorted(folder.rglob(file)):
        words = read_yaml(path.with_name("words.yaml")).get(label.lower(), {})
        module = f"{__package__.removesuffix('plan')}studies.{path.parent.name}.{path.stem}"
        for node in ast.parse(path.read_text("utf-8")).body:
            if not isinstance(node, ast.Assign) or ast.unparse(node.targets[0]) != label:
                continue
            try:
                assigned = eval(ast.unparse(node.value), {kind.__name__: kind})
                for name, entry in assigned.items():
                    if name in entries:
                        raise ValueError(f"{name!r} is an entry of {entries[name].module} as well")
                    entries[name] = replace(entry, module=module, **words.get(name, {}))
            except Exception as error:  # whatever a module can be wrong by
                form = f'must be {{"name": {kind.__name__}(uses=..., ...)}} of literals'
                place = f"{path.parent.name}/{path.name}"
                raise InputError(f"{place}: {label} {form}: {error}") from None
    return entries
