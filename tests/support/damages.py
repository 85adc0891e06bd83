"""Damage every dataset, table and figure that a run has made in every way, and see it refused.

    python tests/damages.py results/smoke

Works on copies: the results stay as they are.
"""

import multiprocessing
import random
import shutil
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np

from beltrepro.base import store
from beltrepro.base.errors import InputError
from beltrepro.base.seal import metadata_path
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import inputs
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.workflow import Workflow

ROOT = Path(__file__).parents[2]
FLIPS = 8  # places in each file
LONGEST = 60  # seconds to look at a file


def expected_of(flow: Workflow) -> dict[str, dict]:
    """What each file must say of itself, by its path below the results without suffix."""
    names = (*flow.judged, *flow.tables)
    files = {flow.file_of(name): expected for name, expected in flow.expected(*names).items()}
    files |= dict.fromkeys(flow.claims()[:2], flow.made_from(*flow.judged))
    for name, figure in flow.figures.items():
        files[f"<results>/figures/{name}.png"] = flow.made_from(*figure.uses)
    return {path.removeprefix("<results>/"): expected for path, expected in files.items()}


def truncated(path: Path, other: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def without_end(path: Path, other: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


def empty(path: Path, other: Path) -> None:
    path.write_bytes(b"")


def missing(path: Path, other: Path) -> None:
    path.unlink()


def swapped(path: Path, other: Path) -> None:
    shutil.copy(other, path)
    if path.suffix == ".csv":
        shutil.copy(metadata_path(other), metadata_path(path))


def of_older_version(path: Path, other: Path) -> None:
    """Without what this version writes."""
    if path.suffix == ".h5":
        with h5py.File(path, "r+") as file:
            del file.attrs[store.CHECKSUM]
    elif path.suffix == ".csv":
        metadata_path(path).unlink()
    else:
        from PIL import Image

        with Image.open(path) as image:
            image.copy().save(path)


def flipped(place: float) -> Callable[[Path, Path], None]:
    """One bit is another one, at this share of the file."""

    def flip(path: Path, other: Path) -> None:
        content = bytearray(path.read_bytes())
        content[int(place * len(content))] ^= 1 << int(place * 1e6) % 8
        path.write_bytes(content)

    flip.__name__ = "flipped"
    return flip


def damages(seed: int) -> Iterator[Callable[[Path, Path], None]]:
    yield from (truncated, without_end, empty, missing, swapped, of_older_version)
    stream = random.Random(seed)
    yield from (flipped(stream.random()) for _ in range(FLIPS))


def same(first: Dataset, second: Dataset) -> bool:
    """Whether two datasets have the same content, to the bit."""
    arrays = [(first.arrays[name], second.arrays.get(name)) for name in first.arrays]
    return (
        first.attributes == second.attributes
        and set(first.arrays) == set(second.arrays)
        and all(one.tobytes() == np.asarray(two).tobytes() for one, two in arrays)
    )


def outcome(path: Path, expected: dict, whole: Path) -> str:
    """What becomes of a damaged file: "refused", "harmless" (no part of its content), or worse."""
    try:
        inputs.check(path, expected)
    except InputError as error:
        words = str(error)
        named = words.startswith(str(path)) and f"rm {path} && snakemake" in words
        return "refused" if named and "\n" not in words else f"refused in other words: {words}"
    if path.suffix == ".h5":
        return "harmless" if same(store.read(path), store.read(whole)) else "taken for whole"
    return "harmless" if path.suffix == ".png" else "taken for whole"


def by_itself(function: Callable[..., str], *arguments) -> str:
    """What a function says in a process of its own; "crashed" if that does not live to say it."""
    context = multiprocessing.get_context("fork")
    answers, answer = context.Pipe(duplex=False)

    def work() -> None:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(LONGEST)  # after some flipped bits libhdf5 reads on and on
        answer.send(function(*arguments))

    process = context.Process(target=work)
    process.start()
    answer.close()
    try:
        return answers.recv()
    except EOFError:
        return "crashed"
    finally:
        process.join()


def run(results: Path, flow: Workflow) -> tuple[Counter, list[str]]:
    """Damage all files; how often each kind had which outcome, and what went wrong."""
    counts: Counter = Counter()
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, expected) in enumerate(expected_of(flow).items()):
            whole = results / name
            if not whole.exists():  # of a run of some targets
                continue
            alike = sorted(whole.parent.glob(f"*{whole.suffix}"))
            other = next((path for path in alike if path != whole and path.stem != "timing"), None)
            path = Path(folder, whole.name)
            for damage in (None, *damages(number)):
                if damage is swapped and other is None:
                    continue
                shutil.copy(whole, path)
                if whole.suffix == ".csv":
                    shutil.copy(metadata_path(whole), metadata_path(path))
                if damage is None:
                    inputs.check(path, expected)
                    continue
                damage(path, other)
                result = by_itself(outcome, path, expected, whole)
                counts[whole.suffix, damage.__name__, result.partition(":")[0]] += 1
                good = ("refused", "harmless") if damage.__name__ == "flipped" else ("refused",)
                if result not in good:
                    wrong.append(f"{name}, {damage.__name__}: {result}")
    return counts, wrong


def main(results: str) -> int:
    folder = Path(results)
    config = load_config(ROOT / "config.yaml") | {"preset": "smoke", "run": folder.name}
    counts, wrong = run(folder, Workflow(config))
    for (suffix, damage, result), count in sorted(counts.items()):
        print(f"{suffix:5} {damage:17} {result:9} {count:4}")
    print("\n".join(wrong) or f"{counts.total()} damages: none was taken for whole")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
