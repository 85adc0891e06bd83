"""Unpack the archive of a run elsewhere, delete figures and report, and have them made again.

    python tests/unpacking.py results/smoke/beltrepro-smoke.zip

There is no git there, and all files are as old as the unpacking. Nothing may be simulated, and the
figures must be the same.
"""

import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

TIMES = re.compile(r'<section id="time".*?</section>', re.S)  # of the jobs


@dataclass(frozen=True)
class Outcome:
    """What the workflow did in the unpacked archive."""

    jobs: dict[str, int]  # by rule
    same_bits: list[str]  # names of figures
    same_pixels: list[str]
    other: list[str]
    same_report: bool  # but for the times of the jobs


def unpack(archive: Path, place: Path) -> Path:
    """The folder of the project, with every file as its checksum says."""
    with zipfile.ZipFile(archive) as file:
        file.extractall(place)
    (top,) = place.iterdir()
    lines = (top / "manifest-sha256.txt").read_text().splitlines()
    listed = dict(reversed(line.split("  ", 1)) for line in lines)
    there = {path.relative_to(top).as_posix() for path in top.rglob("*") if path.is_file()}
    assert there == {*listed, "manifest-sha256.txt"}
    for name, checksum in listed.items():
        assert hashlib.sha256((top / name).read_bytes()).hexdigest() == checksum, name
    return top


def made_again(top: Path, run: str, place: Path) -> Outcome:
    """Delete figures and report and run the workflow."""
    results = top / "results" / run
    (preset,) = re.findall(r"preset (\w+)", (top / "ro-crate-metadata.json").read_text())[:1]
    before = {path.name: path.read_bytes() for path in (results / "figures").iterdir()}
    report = TIMES.sub("", (results / "report.html").read_text())
    shutil.rmtree(results / "figures")
    (results / "report.html").unlink()
    said = snakemake(top, place, "--config", f"preset={preset}", f"run={run}")
    after = {path.name: path.read_bytes() for path in (results / "figures").iterdir()}
    assert set(after) == set(before)
    bits = [name for name in before if before[name] == after[name]]
    pictures = [name for name in before if name.endswith(".png")]
    pixels = [n for n in pictures if np.array_equal(pixels_of(before[n]), pixels_of(after[n]))]
    words = {"simulate": "Simulating", "join": "Joining", "draw": "Drawing"}
    return Outcome(
        jobs={rule: said.count(f": {word} ") for rule, word in words.items()},
        same_bits=bits,
        same_pixels=pixels,
        other=sorted(set(before) - {*bits, *pixels}),
        same_report=report == TIMES.sub("", (results / "report.html").read_text()),
    )


def pixels_of(content: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(content)))


def snakemake(top: Path, place: Path, *arguments: str) -> str:
    """What Snakemake says, with every command of this machine but git."""
    commands = place / "commands"
    commands.mkdir()
    for folder in os.environ["PATH"].split(os.pathsep):
        for path in Path(folder).glob("*"):
            if path.name != "git" and not (commands / path.name).exists():
                (commands / path.name).symlink_to(path)
    environment = os.environ | {"PATH": str(commands), "PYTHONPATH": str(top / "src")}
    command = [sys.executable, "-m", "snakemake", "--cores", "2", *arguments]
    done = subprocess.run(command, cwd=top, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def main(archive: Path) -> Outcome:
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        top = unpack(archive, place / "unpacked")
        return made_again(top, archive.stem.removeprefix("beltrepro-"), place)


if __name__ == "__main__":
    unpacked = main(Path(sys.argv[1]))
    print(f"jobs: {unpacked.jobs}")
    alike = f"{len(unpacked.same_bits)} of the same bits, {len(unpacked.same_pixels)} PNG"
    print(f"figures: {alike} of the")
    print(f"same pixels, others: {', '.join(unpacked.other) or 'none'}")
    print(f"report the same but for times: {unpacked.same_report}")
    sys.exit(bool(unpacked.jobs["simulate"] or unpacked.other))
