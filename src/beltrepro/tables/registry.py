"""Which tables there are, and what each says of itself, without importing any."""

import functools
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from beltrepro.entries import read_entries
from beltrepro.errors import InputError

FOLDER = Path(__file__).parent


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What a table says of itself.

    Parameters
    ----------
    title : str
        One sentence.
    uses : tuple of str
        Names of the datasets and tables that it is derived from.
    columns : dict
        What single columns are, with their unit; quantities of a point explain themselves.
    on_top : bool
        Whether the file lies at the top of the results, and not in tables/.

    Raises
    ------
    InputError
        If the title is no sentence, or `uses` no tuple of different names.
    """

    title: str
    uses: tuple[str, ...]
    columns: dict[str, str] = field(default_factory=dict, hash=False)
    on_top: bool = False

    def __post_init__(self):
        if not isinstance(self.title, str) or not self.title.endswith(".") or "\n" in self.title:
            raise InputError(f"title = {self.title!r}: must be one sentence with a full stop")
        if not isinstance(self.uses, tuple) or len(set(self.uses)) < len(self.uses):
            raise InputError(f"uses = {self.uses!r}: must be a tuple of different names")

    def file(self, name: str) -> str:
        """Path of the table of this name below the results, without suffix."""
        return name if self.on_top else f"tables/{name}"


@functools.cache
def entries(folder: Path = FOLDER) -> dict[str, Entry]:
    """All tables: their entries by name. Raises InputError as `entries.read_entries`."""
    return read_entries(folder, Entry)


def check_names(datasets: Iterable[str]) -> None:
    """Raise InputError for a dataset that has the name of a table."""
    for name in datasets:
        if name in entries():
            raise InputError(f"datasets.{name} has the name of a table: tables/{name}.py")
