"""Each number that a figure shows is the estimate of its name, as the claims have it."""

import re
from fnmatch import fnmatchcase

import numpy as np
import pytest
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

import figure_data as made
import made_up
from beltrepro.base.store import Dataset
from beltrepro.replication.drawing import panels
from beltrepro.replication.plan import registry
from beltrepro.replication.studies.noise import claims as noise
from beltrepro.replication.verdicts import evidence
from beltrepro.replication.verdicts.ledger import load_ledger
from beltrepro.stats import estimates, transition

SHOWING = {name: entry for name, entry in registry.figures().items() if entry.shows}
NOISY = ("noisy_motion", "noisy_motion_rest")


def noisy_motion():
    """Runs at u = 7 whose exponent has the sign of the noise less 0.9."""
    noise = np.repeat([0.1, 0.5, 1.0, 1.5, 2.0, 2.2], 4)
    exponent = 1e-4 * (noise - 0.9) + 1e-6 * np.arange(noise.size)
    alike = {"n_blocks": np.full(noise.size, 5), "belt_velocity": np.full(noise.size, 7.0)}
    arrays = alike | {"noise": noise, "largest_exponent": exponent}
    return Dataset(arrays, made.HOW | {"kind": "motion", "transient": 1e4})


@pytest.fixture(autouse=True)
def short_runs_and_few(monkeypatch):
    """The made-up scans have three runs at a point, and discard little."""
    monkeypatch.setattr(evidence, "SETTLED_TRANSIENT", 0.0)
    monkeypatch.setattr(noise, "SETTLED", 0.0)
    monkeypatch.setattr(transition, "LEAST_RUNS", 3)
    monkeypatch.setattr(estimates, "RESAMPLES", 40)


def data_for(name):
    """What a figure and the claims of its numbers use, tables made from the same datasets."""
    claims = {key.split(": ")[0] for key in SHOWING[name].shows}
    ledger = load_ledger()
    needs = [*SHOWING[name].uses, *(need for claim in claims for need in ledger[claim].needs)]
    tables = {need for need in needs if need in registry.tables()}
    needs += [used for table in tables for used in registry.tables()[table].uses]
    data = {need: made.dataset(need) for need in needs if need not in {*tables, *NOISY}}
    data |= {table: made.table(table, data) for table in tables}
    return data | dict.fromkeys(NOISY, noisy_motion())


def estimates_of(key, data):
    """Estimates by name of a claim, or of a variant of one."""
    claim, _, variant = key.partition(": ")
    readings = made_up.readings(claim, data)
    measurement = readings[variant or next(iter(readings))]()
    return measurement.judged | measurement.also


def marked(figure):
    """Artists of a figure that show estimates: artist, key of `Figure.shows`, names."""
    for artist in figure.findobj():
        key, *names = (artist.get_gid() or "").split(panels.SEPARATOR)
        if names:
            yield artist, key, names


def positions(artist):
    """Numbers that an artist shows, in every way they could be read, with their precision."""
    if isinstance(artist, Text):
        numbers = re.findall(r"-?\d+(?:\.\d+)?", artist.get_text())
        decimals = [len(number.partition(".")[2]) for number in numbers]
        halves = [0.5 * 10.0**-count for count in decimals]
        return [(list(map(float, numbers)), halves)]
    if isinstance(artist, Rectangle):
        ends = [artist.get_x(), artist.get_x() + artist.get_width()]
        return [(ends, [1e-9] * 2)]
    assert isinstance(artist, Line2D)
    both = [np.unique(values) if len(set(values)) == 1 else np.asarray(values, dtype=float)
            for values in artist.get_data()]  # fmt: skip
    return [(values, [1e-9] * len(values)) for values in both]


def shows(artist, values):
    """Whether an artist shows just these values, in this order; a text may show others too."""
    for numbers, halves in positions(artist):
        pairs = list(zip(numbers, halves, strict=True))
        if isinstance(artist, Text):
            near = [abs(n - v) <= half for v in values for n, half in pairs if abs(n - v) <= half]
            if len(near) >= len(values):
                return True
        elif len(pairs) == len(values) and all(
            abs(number - value) <= half for (number, half), value in zip(pairs, values, strict=True)
        ):
            return True
    return False


@pytest.mark.parametrize("name", SHOWING)
def test_what_a_figure_shows_is_what_the_claims_say(name):
    data = data_for(name)
    figure = made.draw(name, {used: data[used] for used in SHOWING[name].uses})
    drawn = {}
    for artist, key, names in marked(figure):
        numbers = estimates_of(key, data)
        values = [numbers[one].value for one in names]
        assert np.isfinite(values).all() and shows(artist, values), (key, names, values)
        drawn.setdefault(key, set()).update(names)
    declared = SHOWING[name].shows
    assert set(drawn) == set(declared)
    for key, patterns in declared.items():
        for one in drawn[key]:
            assert any(fnmatchcase(one, pattern) for pattern in patterns), (key, one)
        for pattern in patterns:
            assert any(fnmatchcase(one, pattern) for one in drawn[key]), (key, pattern)
