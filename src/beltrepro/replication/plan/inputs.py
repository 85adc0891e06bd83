"""What figures, tables, claims and the report are made from: files that are read and checked."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from beltrepro.base import provenance
from beltrepro.base.errors import InputError
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import described, files
from beltrepro.replication.plan.films import FILM, TRACK


def load(paths: dict[str, str | Path], expected: dict[str, dict]) -> dict:
    """Read datasets (.h5), tables (.csv) and what the virtual experiment made.

    Parameters
    ----------
    paths : dict
        Files by name of the dataset or table; those of film F are "F_film" and "F_track".
    expected : dict
        For each dataset what its file must say of itself, see `datasets.files.expected`. For each
        other file preset, run and what its `sources` were told; one without is not checked.

    Returns
    -------
    dict
        `store.Dataset` or DataFrame by name. A series of a single point is given as that run: its
        arrays without the axis of points (`datasets.files.single_run`). A track is an
        `experiment.Track`. A film is a function without arguments that yields its frames
        (`experiment.video.read_video`).

    Raises
    ------
    InputError
        If a file cannot be read or holds something else.
    """
    return {name: _read(name, Path(path), expected) for name, path in paths.items()}


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
            found |= described.lineage(Path(paths[name]))
    return dict(sorted(found.items()))


def check(path: str | Path, expected: dict) -> None:
    """Check that a file of results is whole and is what it should be.

    Parameters
    ----------
    path : path-like
        The file; its ending says what it is.
    expected : dict
        As for `load`; of the PNG of a figure preset, run and `sources`.

    Raises
    ------
    InputError
        It is not; the line has the command that makes it again.
    """
    path = Path(path)
    if path.suffix == ".h5":
        files.read(path, expected)
    elif path.suffix == ".png":
        _check_figure(path, expected)
    else:
        described.check(path, expected)


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


def _read(name: str, path: Path, expected: dict[str, dict]) -> Any:
    if path.suffix == ".h5":
        found = files.read(path, expected[name])
        return files.single_run(found) if files.is_single_run(found) else found
    if name in expected:
        described.check(path, expected[name])
    if name.endswith(FILM):
        from beltrepro.replication.camera.video import read_video

        return partial(read_video, path)
    if name.endswith(TRACK):
        from beltrepro.replication.camera import Track

        return Track.load(path)
    return pd.read_csv(path)


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
