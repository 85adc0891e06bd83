"""Which figures there are, and what each says of itself, without importing any."""

import functools
from dataclasses import dataclass
from pathlib import Path

from beltrepro.entries import read_entries
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
        As `entries.read_entries`.
    """
    found = read_entries(folder, Entry)
    return dict(sorted(found.items(), key=lambda item: CATEGORIES.index(item[1].category)))
