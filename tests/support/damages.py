"""Damage every file that a run has made in every way, and see it refused.

    python tests/support/damages.py results/smoke

First by the readers of datasets, tables and figures, which know what each must say of itself; then
by the list of the run, which publishing asks about files of all kinds. Works on
copies: the results stay as they are.
"""

import json
import multiprocessing
import os
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

from beltrepro.base import seal, store
from beltrepro.base.errors import InputError
from beltrepro.base.seal import metadata_path
from beltrepro.base.store import Dataset
from beltrepro.replication.plan import inputs, manifest
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


def by_hand(path: Path, other: Path) -> None:
    """A digit in the middle is another one: the length is right."""
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    place = next(n for n in (*range(middle, len(content)), *range(middle)) if content[n] in b"123")
    content[place] += 1
    path.write_bytes(content)


def with_more(path: Path, other: Path) -> None:
    path.write_bytes(path.read_bytes() + b"\n%%EOF\n")


def without_a_line(path: Path, other: Path) -> None:
    lines = path.read_bytes().splitlines(keepends=True)
    del lines[len(lines) // 2]
    path.write_bytes(b"".join(lines))


def with_other_line_ends(path: Path, other: Path) -> None:
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))


def link_to_another(path: Path, other: Path) -> None:
    path.unlink()
    path.symlink_to(other.resolve())


def link_to_itself(path: Path, other: Path) -> None:
    """A link to the same content elsewhere."""
    moved = path.rename(path.with_name(f"moved-{path.name}"))
    path.symlink_to(moved.resolve())


def with_other_times(path: Path, other: Path) -> None:
    os.utime(path, (1, 1))


def with_an_attribute_changed(path: Path, other: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["seed_of_all"] = 3


def of_another_run(path: Path, other: Path) -> None:
    """With a seal that agrees: what an earlier version, or a run of this name elsewhere, made."""
    match path.suffix:
        case ".h5":
            dataset = store.read(path)
            store.write(path, dataset.arrays, dataset.attributes | {"code_version": "0.0"})
        case ".png":
            _compressed_anew(path, with_words=True)
        case ".json":
            about = json.loads(path.read_text())
            about["dc:source"] = {"rows": {"preset": "other", "run": "other"}}
            path.write_text(json.dumps(about))
        case _:
            by_hand(path, other)
            if metadata_path(path).exists():
                about = json.loads(metadata_path(path).read_text())
                about[seal.KEY] = seal.digest_of(path)[:16]
                metadata_path(path).write_text(json.dumps(about))


def compressed_anew(path: Path, other: Path) -> None:
    """The same pixels in other bytes."""
    _compressed_anew(path, with_words=False)


def _compressed_anew(path: Path, *, with_words: bool) -> None:
    from PIL import Image, PngImagePlugin

    with Image.open(path) as image:
        words = PngImagePlugin.PngInfo()
        for name, text in image.info.items() if with_words else ():
            if isinstance(text, str):
                words.add_text(name, text)
        image.copy().save(path, compress_level=1, pnginfo=words)
    if with_words:
        seal.put(path)


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


HARMLESS = (link_to_itself, with_other_times)  # the bytes are those that the run wrote


def damages_in_run(name: str, seed: int) -> Iterator[Callable[[Path, Path], None]]:
    """Those of a file of any kind, by its name."""
    yield from (truncated, without_end, empty, missing, swapped, by_hand, with_more)
    yield from (link_to_another, of_another_run, *HARMLESS)
    suffix = Path(name).suffix
    if suffix in (".csv", ".json", ".html"):
        yield from (without_a_line, with_other_line_ends)
    if suffix == ".png":
        yield compressed_anew
    if suffix == ".h5":
        yield with_an_attribute_changed
    yield flipped(random.Random(seed).random())


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
        named = words.startswith(str(path)) and f"rm -f {path} && snakemake" in words
        return "refused" if named and "\n" not in words else f"refused in other words: {words}"
    if path.suffix == ".h5":
        return "harmless" if same(store.read(path), store.read(whole)) else "taken for whole"
    return "harmless" if path.suffix == ".png" else "taken for whole"


def outcome_in_run(results: Path, name: str, whole: Path) -> str:
    """What becomes of a damaged file of a run where somebody asks whether the run wrote it."""
    path = results / name
    try:
        manifest.check(results, [name], {"preset": "smoke", "run": results.name})
    except InputError as error:
        words = str(error)
        named = words.startswith(str(path)) and f"rm -f {path} && snakemake" in words
        return "refused" if named and "\n" not in words else f"refused in other words: {words}"
    return "harmless" if path.read_bytes() == whole.read_bytes() else "taken for whole"


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
            other = next((path for path in alike if path != whole), None)
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


def damage_in_run(results: Path, name: str, copy: Path, seed: int = 0) -> Iterator[tuple[str, str]]:
    """Each damage of a file and its outcome; `copy` is a copy of the run, and stays one."""
    whole, path = results / name, copy / name
    alike = (results / other for other in sorted(manifest.of_run(results)) if other != name)
    other = next((file for file in alike if file.suffix == whole.suffix), results / manifest.NAME)
    for damage in damages_in_run(name, seed):
        damage(path, other)
        result = outcome_in_run(copy, name, whole)
        good = "harmless" if damage in HARMLESS else "refused"
        yield damage.__name__, result if result == good else f"wrong: {result}"
        for file in path.parent.glob(f"*{whole.name}*"):
            file.unlink()
        for file in whole.parent.glob(f"*{whole.name}*"):
            shutil.copy2(file, path.parent)


def run_in_run(results: Path) -> tuple[Counter, list[str]]:
    """Damage all files that the run has listed."""
    counts: Counter = Counter()
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        left_out = shutil.ignore_patterns("batches", "logs", "benchmarks", "source")
        copy = Path(shutil.copytree(results, Path(folder, results.name), ignore=left_out))
        for seed, name in enumerate(sorted(manifest.of_run(results))):
            for damage, result in damage_in_run(results, name, copy, seed):
                counts[Path(name).suffix, damage, result.partition(":")[0]] += 1
                wrong += [f"{name}, {damage}: {result}"] * result.startswith("wrong")
    return counts, wrong


def main(results: str) -> int:
    folder = Path(results)
    config = load_config(ROOT / "config.yaml") | {"preset": "smoke", "run": folder.name}
    counts, wrong = run(folder, Workflow(config))
    of_run, wrong_of_run = run_in_run(folder)
    counts, wrong = counts + of_run, wrong + wrong_of_run
    for (suffix, damage, result), count in sorted(counts.items()):
        print(f"{suffix:5} {damage:17} {result:9} {count:4}")
    print("\n".join(wrong) or f"{counts.total()} damages: none was taken for whole")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
