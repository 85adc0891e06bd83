"""Modules that say what they are: figures and tables register themselves by an ENTRY.

Every module of a package that assigns `ENTRY = Entry(...)` stands for a figure or table of the
name of the module. The arguments of the call are literals, so they are read from its text: the
workflow asks for them in every job and must not wait for pandas and matplotlib.
"""

import ast
from collections.abc import Iterable
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, TypeVar

from beltrepro.errors import InputError
from beltrepro.names import hint

E = TypeVar("E")


def read_entries(folder: Path, kind: type[E]) -> dict[str, E]:
    """The entries of all modules of a folder, by name.

    Parameters
    ----------
    folder : Path
        Folder of the modules.
    kind : type
        Dataclass of the entries.

    Returns
    -------
    dict
        Entries by name of the module.

    Raises
    ------
    InputError
        If an entry lacks a field, has an unknown one, or one that is not a literal.
    """
    found = {path.stem: _read(path, kind) for path in sorted(folder.glob("*.py"))}
    return {name: entry for name, entry in found.items() if entry is not None}


def check_uses(folder: str, entries: dict, known: Iterable[str], where: str) -> None:
    """Check that all that entries use is there.

    Parameters
    ----------
    folder : str
        Folder of the modules, for the message.
    entries : dict
        Entries with `uses`, by name.
    known : iterable of str
        Names of all datasets and tables.
    where : str
        What has them, for the message: "preset smoke".

    Raises
    ------
    InputError
        For the first entry that uses what is not among `known`.
    """
    known = list(known)
    for name, entry in entries.items():
        for used in entry.uses:
            if used not in known:
                meant = hint(used, known)
                raise InputError(f"{folder}/{name}.py uses {used!r}, which {where} lacks{meant}")


def _read(path: Path, kind: type[E]) -> E | None:
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
        return kind(**_arguments(calls[0], kind))
    except InputError as error:
        raise InputError(f"{path.parent.name}/{path.name}: ENTRY: {error}") from None


def _arguments(call: ast.expr, kind: Any) -> dict:
    """Keyword arguments of `Entry(...)`, complete and literal."""
    if not isinstance(call, ast.Call) or call.args or ast.unparse(call.func) != "Entry":
        raise InputError("must be Entry(title=..., ...)")
    given = {keyword.arg: keyword.value for keyword in call.keywords}
    names = [each.name for each in fields(kind)]
    for each in fields(kind):
        required = each.default is MISSING and each.default_factory is MISSING
        if each.name not in given and required:
            raise InputError(f"{each.name} is missing")
    for name in given:
        if name not in names:
            raise InputError(f"unknown field {name!r}: allowed are {', '.join(names)}")
    return {name: _literal(name, value) for name, value in given.items()}


def _literal(name: str | None, value: ast.expr) -> object:
    try:
        return ast.literal_eval(value)
    except ValueError:
        text = ast.unparse(value)
        raise InputError(f"{name} = {text}: must be a literal, it is read without import") from None
