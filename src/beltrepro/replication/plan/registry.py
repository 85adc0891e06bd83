"""Which figures and tables the studies have, and what each says of itself, without importing any.

A module that assigns `FIGURES = {"name": Figure(...)}` has a function of each name that draws the
figure; `TABLES = {"name": Table(...)}` stands for functions that make tables. The arguments are
literals, so they are read from its text: the workflow asks for them in every job and must not wait
for pandas and matplotlib. Those that are words may stand in `words.yaml` beside the module instead.
"""

import ast
import functools
from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, TypeVar

import yaml

from beltrepro.base.errors import InputError
from beltrepro.base.names import hint

E = TypeVar("E", bound="_Entry")
STUDIES = Path(__file__).parent.parent / "studies"
# PyYAML's own reader takes ten times as long; it is the one where libyaml is not to be had.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
CATEGORIES = ("Figures of the paper", "Integrators compared", "Further studies")


@dataclass(frozen=True, kw_only=True)
class _Entry:
    """What figures and tables have in common.

    title : one sentence.
    uses : names of the datasets and tables that it is made from.
    module : dotted name of its module.
    """

    title: str = ""
    uses: tuple[str, ...]
    module: str = field(default="", compare=False)

    def check(self) -> None:
        """Raise InputError for a value that no entry may have."""
        if not isinstance(self.title, str) or not self.title.endswith(".") or "\n" in self.title:
            raise InputError(f"title = {self.title!r}: must be one sentence with a full stop")
        if not isinstance(self.uses, tuple) or len(set(self.uses)) < len(self.uses):
            raise InputError(f"uses = {self.uses!r}: must be a tuple of different names")


@dataclass(frozen=True, kw_only=True)
class Table(_Entry):
    """What a table says of itself.

    columns : what single columns are, with their unit; quantities of a point explain themselves.
    on_top : whether the file lies at the top of the results, and not in tables/.
    """

    columns: dict[str, str] = field(default_factory=dict, hash=False)
    on_top: bool = False

    def file(self, name: str) -> str:
        """Path of the table of this name below the results, without suffix."""
        return name if self.on_top else f"tables/{name}"


@dataclass(frozen=True, kw_only=True)
class Figure(_Entry):
    """What a figure says of itself; its title is also that of the target in `snakemake --list`.

    words : what the figure of the paper shows, in our words; for another figure, how to read it.
    alt : what ours shows, for readers who cannot see it.
    number : number of the figure in the paper; empty for a figure that the paper does not have.
    category : one of CATEGORIES.
    shows : names of the estimates that it draws or prints, by claim: `"u-critical"`, or
        `"u-critical: exact dynamics"` for a variant. A star in a name stands for any text.
    """

    words: str = ""
    alt: str = ""
    number: str = ""
    category: str = CATEGORIES[0]
    shows: dict[str, tuple[str, ...]] = field(default_factory=dict, hash=False)

    def check(self) -> None:
        """Raise InputError for a value that no figure may have."""
        super().check()
        for name in ("words", "alt"):
            if not isinstance(getattr(self, name), str) or not getattr(self, name).strip():
                raise InputError(f"{name} must be text")
        names = self.shows.values() if isinstance(self.shows, dict) else [None]
        if not all(isinstance(shown, tuple) for shown in names):
            raise InputError(f"shows = {self.shows!r}: must be tuples of names by claim")
        if self.category not in CATEGORIES:
            raise InputError(f"category = {self.category!r}: allowed are {', '.join(CATEGORIES)}")
        if not isinstance(self.number, str):
            raise InputError(f"number = {self.number!r}: must be text")
        if bool(self.number) != (self.category == CATEGORIES[0]):
            raise InputError("number must be given for a figure of the paper, and only for one")


@functools.cache
def figures(folder: Path = STUDIES) -> dict[str, Figure]:
    """All figures by name, those of the paper first, in its order; InputError for a wrong entry."""
    entries = _entries(folder, "FIGURES", Figure)
    return dict(
        sorted(entries.items(), key=lambda item: (CATEGORIES.index(item[1].category), item[0]))
    )


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
    """The entries of the dicts that modules assign to a name at their top."""
    entries: dict[str, E] = {}
    for path in sorted(folder.rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8"), str(path)).body:
            if not isinstance(node, ast.Assign) or ast.unparse(node.targets[0]) != label:
                continue
            if not isinstance(node.value, ast.Dict):
                raise InputError(
                    f'{_place(path)}: {label} must be {{"name": {kind.__name__}(...)}}'
                )
            for key, call in zip(node.value.keys, node.value.values, strict=True):
                name = ast.literal_eval(key) if isinstance(key, ast.Constant) else None
                if not isinstance(name, str) or name in entries:
                    raise InputError(f"{_place(path)}: {label}: {name!r} must be a name of its own")
                entries[name] = _entry(path, f"{label}[{name!r}]", call, kind, name)
    return entries


def _entry(path: Path, label: str, call: ast.expr, kind: type[E], name: str) -> E:
    """The entry that a call stands for, whose arguments are literal, with the words beside it."""
    section = "figures" if kind is Figure else "tables"
    words = _words(path.with_name("words.yaml")).get(section, {}).get(name, {})
    try:
        if not isinstance(call, ast.Call) or call.args or ast.unparse(call.func) != kind.__name__:
            raise InputError(f"must be {kind.__name__}(uses=..., ...)")
        arguments = {str(word.arg): _literal(word.arg, word.value) for word in call.keywords}
        entry = kind(**words | arguments, module=_dotted(path))
        entry.check()
        return entry
    except TypeError as error:  # missing, or unknown
        allowed = ", ".join(entry.name for entry in fields(kind) if entry.name != "module")
        problem = f"{str(error).partition('() ')[2]}; allowed are {allowed}"
    except InputError as error:
        problem = str(error)
    raise InputError(f"{_place(path)}: {label}: {problem}")


@functools.cache
def _words(path: Path) -> dict[str, Any]:
    return yaml.load(path.read_text(encoding="utf-8"), _LOADER) if path.exists() else {}


def _place(path: Path) -> str:
    return f"{path.parent.name}/{path.name}"


def _dotted(path: Path) -> str:
    """Name by which a module is imported."""
    if not path.is_relative_to(STUDIES):
        return path.stem
    parts = path.relative_to(STUDIES).with_suffix("").parts
    return ".".join(["beltrepro.replication.studies", *parts])


def _literal(name: str | None, value: ast.expr) -> Any:
    try:
        return ast.literal_eval(value)
    except ValueError:
        text = ast.unparse(value)
        raise InputError(f"{name} = {text}: must be a literal, it is read without import") from None
