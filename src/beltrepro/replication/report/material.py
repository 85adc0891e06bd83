"""What a run left for the page: files by name, and what several sections read."""

import base64
import functools
import io
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from beltrepro.base import store
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import registry
from beltrepro.replication.report.claim_results import Results, read
from beltrepro.replication.verdicts.ledger import read_yaml

SCREEN = 1000  # pixels, of a picture in the page
ROOM = "beltrepro.replication.report"
WORDS = read_yaml(ROOM, "page.yaml")


@dataclass(frozen=True)
class Material:
    """Files of a run, by the names under which the workflow hands them over."""

    preset: str
    settings: dict
    files: dict[str, list[Path]]
    benchmarks: Path = Path("none")

    @functools.cached_property
    def claims(self) -> Results:
        """The claims of the run by id."""
        return read(self.files["claims"][0].parent)

    @functools.cached_property
    def datasets(self) -> list[dict]:
        """What was simulated: plain values of each dataset."""
        return [_describe(store.read(path)) for path in self.files.get("datasets", [])]

    @functools.cached_property
    def pictures(self) -> list[dict]:
        """The figures that were drawn, at screen size, with their words and the claims on them."""
        drawn = {path.stem: path for path in self.files.get("figures", [])}
        numbered = [(str(result.claim.figure), result) for result in self.claims.values()]
        return [
            vars(entry)
            | _at_screen_size(drawn[name])
            | {
                "name": name,
                "claims": [result for number, result in numbered if number == entry.number],
            }
            for name, entry in registry.figures().items()
            if name in drawn
        ]


def _at_screen_size(path: Path) -> dict:
    """A picture as WebP, a quarter of the bytes of the file, which lies beside the page."""
    with Image.open(path) as picture:
        image = picture.convert("RGB")
    image.thumbnail((SCREEN, 9 * SCREEN), Image.Resampling.LANCZOS)
    content = io.BytesIO()
    image.save(content, "WEBP", quality=65)
    encoded = base64.b64encode(content.getvalue()).decode()
    return {"image": encoded, "width": image.width, "height": image.height}


def _describe(dataset: Dataset) -> dict:
    attributes, arrays = dataset.attributes, dataset.arrays
    libraries = json.loads(attributes.get("library_versions", "{}"))
    residual = arrays.get("energy_residual")
    return {name: _grid(arrays[name]) for name in ("time_step", "seed")} | {
        "energy_residual": 0.0 if residual is None else float(np.nanmax(np.abs(residual))),
        "code_version": attributes["code_version"],
        "processor": attributes.get("processor", ""),
        "libraries": ", ".join(f"{name} {number}" for name, number in libraries.items()),
    }


def _grid(values: np.ndarray) -> str:
    """A grid as short text: its few values, or its ends and number."""
    values = np.unique(values)
    if values.size <= 7:
        return ", ".join(f"{value:g}" for value in values)
    return f"{values[0]:g} to {values[-1]:g} ({values.size})"
