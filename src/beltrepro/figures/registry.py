"""Which figures there are, and what each says of itself, without importing any.

Every module of this package that assigns `ENTRY = Entry(...)` is a figure of that name. The
arguments of the call are literals, so they are read from the text of the module: the workflow asks
for them in every job and must not wait for matplotlib.
"""

import ast
import difflib
import functools
from collections.abc import Iterable
from dataclasses import MISSING, dataclass, fields
from pathlib import Path

from beltrepro.errors import InputError

FOLDER = Path(__file__).parent
CATEGORIES = ("Figures of the paper", "Integrators compared", "Further studies")


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What a figure says of itself.

    Parameters
    ----------
    title : str
        One sentence, also that of the target in `snakemake --list`.
    uses : tuple of str
        Names of the datasets and tables that it is drawn from; none for a drawing of the model.
    words : str
        What the figure of the paper shows, in our words; for another figure, how to read it.
    alt : str
        What ours shows, for readers who cannot see it.
    number : str
        Number of the figure in the paper; empty for a figure that the paper does not have.
    category : str
        One of CATEGORIES.

    Raises
    ------
    InputError
        If a text is missing or a value is none that is allowed.
    """

    title: str
    uses: tuple[str, ...]
    words: str
    alt: str
    number: str = ""
    category: str = CATEGORIES[0]

    def __post_init__(self):
        for name in ("title", "words", "alt"):
            if not isinstance(getattr(self, name), str) or not getattr(self, name).strip():
                raise InputError(f"{name} must be text")
        if not self.title.endswith(".") or "\n" in self.title:
            raise InputError(f"title = {self.title!r}: must be one sentence with a full stop")
        if not isinstance(self.uses, tuple) or len(set(self.uses)) < len(self.uses):
            raise InputError(f"uses = {self.uses!r}: must be a tuple of different names")
        if self.category not in CATEGORIES:
            raise InputError(f"category = {self.category!r}: allowed are {', '.join(CATEGORIES)}")
        if not isinstance(self.number, str):
            raise InputError(f"number = {self.number!r}: must be text")
        if bool(self.number) != (self.category == CATEGORIES[0]):
            raise InputError("number must be given for a figure of the paper, and only for one")


@functools.cache
def entries(folder: Path = FOLDER) -> dict[str, Entry]:
    """All figures: their entries by name, those of the paper first, in its order.

    Parameters
    ----------
    folder : Path
        Folder of the modules.

    Raises
    ------
    InputError
        If an entry lacks a field, has an unknown one, or one that is not a literal.
    """
    found = {path.stem: _read(path) for path in sorted(folder.glob("*.py"))}
    known = [(name, entry) for name, entry in found.items() if entry is not None]
    return dict(sorted(known, key=lambda item: CATEGORIES.index(item[1].category)))


def check_uses(known: Iterable[str], where: str) -> None:
    """Raise InputError for the first figure that uses what is not among `known`.

    Parameters
    ----------
    known : iterable of str
        Names of all datasets and tables.
    where : str
        What has them, for the message: "presets.smoke".
    """
    known = list(known)
    for name, entry in entries().items():
        for used in entry.uses:
            if used not in known:
                nearest = difflib.get_close_matches(used, known, n=1, cutoff=0.6)
                hint = f"; did you mean {nearest[0]!r}?" if nearest else ""
                raise InputError(f"figures/{name}.py uses {used!r}, which {where} lacks{hint}")


def _read(path: Path) -> Entry | None:
    """The entry of a module, None if it has none."""
    tree = ast.parse(path.read_text(encoding="utf-8"), str(path))
    calls = [
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "ENTRY"
    ]
    if not calls:
        return None
    try:
        return Entry(**_arguments(calls[0]))
    except InputError as error:
        raise InputError(f"figures/{path.name}: ENTRY: {error}") from None


def _arguments(call: ast.expr) -> dict:
    """Keyword arguments of `Entry(...)`, complete and literal."""
    if not isinstance(call, ast.Call) or call.args or ast.unparse(call.func) != "Entry":
        raise InputError("must be Entry(title=..., ...)")
    given = {keyword.arg: keyword.value for keyword in call.keywords}
    names = [each.name for each in fields(Entry)]
    for each in fields(Entry):
        if each.name not in given and each.default is MISSING:
            raise InputError(f"{each.name} is missing")
    for name in given:
        if name not in names:
            raise InputError(f"unknown field {name!r}: allowed are {', '.join(names)}")
    return {name: _literal(name, value) for name, value in given.items()}


def _literal(name: str, value: ast.expr):
    try:
        return ast.literal_eval(value)
    except ValueError:
        text = ast.unparse(value)
        raise InputError(f"{name} = {text}: must be a literal, it is read without import") from None
