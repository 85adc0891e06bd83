"""Which figures and tables the studies have, and what each says of itself, without importing any.

A module that assigns `FIGURES = {"name": Figure(...)}` has a function of each name that draws the
figure; `TABLES = {"name": Table(...)}` stands for functions that make tables. The arguments are
literals, so they are read from its text: the workflow asks for them in every job and must not wait
for pandas and matplotlib. Words may stand in `words.yaml` beside the module instead.
"""

import ast
import functools
from collections.abc import Iterable
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, TypeVar

import yaml

from beltrepro.base.errors import InputError
from beltrepro.base.names import hint

STUDIES = Path(__file__).parent.parent / "studies"
# PyYAML's own reader takes ten times as long; it is the one where libyaml is not to be had.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
CATEGORIES = ("Figures of the paper", "Integrators compared", "Further studies")


@dataclass(frozen=True, kw_only=True)
class Table:
    """What a table says of itself."""

    uses: tuple[str, ...]  # names of the datasets and tables that it is made from
    title: str = ""  # one sentence
    module: str = field(default="", compare=False)  # dotted name
    # what single columns are, with their unit; quantities of a point explain themselves
    columns: dict[str, str] = field(default_factory=dict, hash=False)
    on_top: bool = False  # whether the file lies at the top of the results, and not in tables/

    def file(self, name: str) -> str:
        """Path of the table of this name below the results, without suffix."""
        return name if self.on_top else f"tables/{name}"


@dataclass(frozen=True, kw_only=True)
class Figure:
    """What a figure says of itself; its title is also that of the target in `snakemake --list`."""

    uses: tuple[str, ...]  # names of the datasets and tables that it is made from
    title: str = ""  # one sentence
    module: str = field(default="", compare=False)  # dotted name
    words: str = ""  # what the figure of the paper shows, in our words; of another, how to read it
    alt: str = ""  # what ours shows, for readers who cannot see it
    number: str = ""  # of the figure in the paper; empty for a figure that the paper does not have
    category: str = CATEGORIES[0]
    # names of the estimates that it draws or prints, by claim: "u-critical", or "u-critical: exact
    # dynamics" for a variant. A star in a name stands for any text
    shows: dict[str, tuple[str, ...]] = field(default_factory=dict, hash=False)


E = TypeVar("E", Table, Figure)


@functools.cache
def figures(folder: Path = STUDIES) -> dict[str, Figure]:
    """All figures by name, those of the paper first, in its order; InputError for a wrong entry."""
    entries = _entries(folder, "FIGURES", Figure)
    for name, figure in entries.items():
        if figure.category not in CATEGORIES:
            raise InputError(
                f"figure {name}: category = {figure.category!r}: "
                f"allowed are {', '.join(CATEGORIES)}{hint(figure.category, CATEGORIES)}"
            )
    order = {category: place for place, category in enumerate(CATEGORIES)}
    return dict(sorted(entries.items(), key=lambda item: (order[item[1].category], item[0])))


@functools.cache
def tables(folder: Path = STUDIES) -> dict[str, Table]:
    """All tables by name; InputError for a wrong entry."""
    return dict(sorted(_entries(folder, "TABLES", Table).items()))


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


def check_uses(entries: dict, inputs: Iterable[str], where: str) -> None:
    """Raise InputError for an entry that uses what is not among the datasets and tables there.

    where : what has them, for the message: "preset smoke".
    """
    inputs = list(inputs)
    for name, entry in entries.items():
        for used in entry.uses:
            if used not in inputs:
                raise InputError(f"{name} uses {used!r}, which {where} lacks{hint(used, inputs)}")


def _entries(folder: Path, label: str, kind: type[E]) -> dict[str, E]:
    """What modules assign to a name at their top, with the words beside them."""
    entries: dict[str, E] = {}
    for path in sorted(folder.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        for node in ast.parse(text).body if f"\n{label} = " in text else ():
            if not isinstance(node, ast.Assign) or ast.unparse(node.targets[0]) != label:
                continue
            table: Any = node.value
            words = _words(path.with_name("words.yaml")).get(label.lower(), {})
            module = ".".join(
                [__package__.rpartition(".")[0], "studies", path.parent.name, path.stem]
            )
            try:
                for key, call in zip(table.keys, table.values, strict=True):
                    name = ast.literal_eval(key)
                    fields = {word.arg: ast.literal_eval(word.value) for word in call.keywords}
                    entry = kind(**words.get(name, {}) | fields, module=module)
                    if name in entries:
                        raise ValueError(f"{name!r} is an entry of {entries[name].module} as well")
                    entries[name] = entry
            except (AttributeError, TypeError, ValueError) as error:
                form = f'must be {{"name": {kind.__name__}(uses=..., ...)}} of literals'
                raise InputError(
                    f"{path.parent.name}/{path.name}: {label} {form}: {error}"
                ) from None
    return entries


@functools.cache
def _words(path: Path) -> dict[str, Any]:
    return yaml.load(path.read_text(encoding="utf-8"), _LOADER) if path.exists() else {}
