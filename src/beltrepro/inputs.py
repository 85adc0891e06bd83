"""What figures, tables, claims and the report are made from: files that are read and checked."""

import json
from pathlib import Path

import pandas as pd

from beltrepro import provenance
from beltrepro.datasets import files
from beltrepro.errors import InputError
from beltrepro.store import Dataset
from beltrepro.tables import files as tables


def load(paths: dict[str, str | Path], expected: dict[str, dict]) -> dict:
    """Read datasets (.h5) and tables (.csv).

    Parameters
    ----------
    paths : dict
        Files by name of the dataset or table.
    expected : dict
        For each dataset what its file must say of itself, see `datasets.files.expected`. For a
        table preset, run and what its `sources` were told; one without is not checked.

    Returns
    -------
    dict
        `store.Dataset` or DataFrame by name. A series of a single point is given as that run: its
        arrays without the axis of points (`datasets.files.single_run`).

    Raises
    ------
    InputError
        If a file cannot be read or holds something else.
    """
    return {
        name: _table(path, expected.get(name))
        if Path(path).suffix == ".csv"
        else _dataset(path, expected[name])
        for name, path in paths.items()
    }


def lineage(paths: dict[str, str | Path], data: dict) -> dict[str, dict]:
    """What made the datasets behind a figure or table, to be written into it.

    Parameters
    ----------
    paths : dict
        As for `load`.
    data : dict
        As `load` returns it.

    Returns
    -------
    dict
        For each dataset, those behind tables too: digest, and `config`, what it was told, with
        seeds, methods and every value; code version, libraries and processor.
    """
    found: dict[str, dict] = {}
    for name, each in data.items():
        if isinstance(each, Dataset):
            found[name] = _origin(each.attributes)
        else:
            found |= tables.lineage(Path(paths[name]))
    return dict(sorted(found.items()))


def check(path: str | Path, expected: dict) -> None:
    """Check that a dataset, a table or a PNG of a figure is whole and is what it should be.

    Parameters
    ----------
    path : path-like
        The file; its ending says what it is.
    expected : dict
        Of a dataset as for `load`; of a table or figure preset, run and `sources`.

    Raises
    ------
    InputError
        It is not; the line has the command that makes it again.
    """
    path = Path(path)
    if path.suffix == ".h5":
        files.read(path, expected)
    elif path.suffix == ".csv":
        tables.check(path, expected)
    else:
        _check_figure(path, expected)


def source(expected: dict) -> str:
    """What the PNG of a figure says that it is drawn from.

    Parameters
    ----------
    expected : dict
        Preset, run and `sources`.

    Returns
    -------
    str
        Differs for other presets, runs and settings of datasets.
    """
    return f"{expected['preset']}, {expected['run']}, {files.digest(expected)}"


def _origin(attributes: dict) -> dict:
    texts = ("config", "library_versions")  # JSON
    return {
        name: json.loads(attributes[name]) if name in texts else attributes[name]
        for name in ("digest", "config", *provenance.origin())
    }


def _table(path: str | Path, expected: dict | None) -> pd.DataFrame:
    if expected is not None:
        tables.check(Path(path), expected)
    return pd.read_csv(path)


def _dataset(path: str | Path, expected: dict) -> Dataset:
    found = files.read(path, expected)
    return files.single_run(found) if files.is_single_run(found) else found


def _check_figure(path: Path, expected: dict) -> None:
    from PIL import Image  # only the report looks at figures

    try:
        with Image.open(path) as image:
            said = image.info.get("Title"), image.info.get("Source")
            image.verify()
            reason = ""
    except (OSError, SyntaxError, ValueError) as error:
        reason = f"not a whole PNG ({error})"
    if not reason and said != (path.stem, source(expected)):
        reason = f"another figure, {said[0]} of {said[1]}"
    if reason:
        raise InputError(f"{path}: {reason}; {files.repair(path, expected)}")
