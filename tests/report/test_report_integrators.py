"""The section on the integrators says what its tables say: every row, every count."""

import pandas as pd
import pytest

import pages
from beltrepro.replication.studies.integrators import measure as described
from pages import cells, words

DISORDER = "disorder parameter r"
STICKING = "share that still sticks at the end"
AT_THE_END = "disorder parameter r at the end"


def row(**changes):
    """A row of the comparisons: its numbers are all different."""
    usual = {
        "part": "disorder", "quantity": DISORDER, "n_blocks": 5, "belt_velocity": 8.0, "noise": 1.0,
        "initial_spread": None, "time_step": None, "n_tested": 31, "n_reference": 32,
        "mean_tested": 0.1234, "mean_reference": 0.4321, "error_tested": 0.01,
        "error_reference": 0.02, "z": -1.75, "p": 0.25, "corrected_p": 0.75, "distance": 0.034,
        "verdict": "agree", "tested": "verlet", "reference": "event",
    }  # fmt: skip
    return usual | changes


COMPARISONS = [
    row(),
    row(quantity="mean length"),
    row(belt_velocity=14.0, noise=2.2, z=None, p=1e-13, corrected_p=1e-13, verdict="differ"),
    row(part="attractors", quantity=STICKING, noise=0.0, initial_spread=1.0, time_step=0.001),
] + [
    row(part="attractors", quantity=AT_THE_END, noise=0.0, belt_velocity=u, initial_spread=spread,
        time_step=step, n_tested=64, verdict=verdict)
    for u, spread, step, verdict in (
        (7.0, 0.001, 0.001, "differ"), (13.0, 0.001, 0.001, "agree"),
        (16.0, 0.001, 0.001, "differ"), (7.0, 1.0, 0.001, "agree"),
        (13.0, 1.0, 0.001, "differ by less than 1 %"),
        (7.0, 0.001, 0.002, "agree"), (13.0, 0.001, 0.002, "agree"),
    )
]  # fmt: skip


def family(**changes):
    usual = {
        "part": "disorder", "quantity": DISORDER, "time_step": None, "initial_spread": None,
        "runs": 32, "points": 11, "agree": 6, "differ by less than 1 %": 3, "differ": 2,
        "not measured": 0, "test": "Kolmogorov-Smirnov", "smallest_p": 0.004,
    }  # fmt: skip
    return usual | changes


FAMILIES = [
    family(),
    family(part="slips", quantity="section points", agree=8, **{"differ by less than 1 %": 0},
           differ=0, **{"not measured": 3}),
    family(part="attractors", quantity="lifetime", time_step=0.002, initial_spread=1.0),
    family(part="attractors", quantity="lifetime", time_step=0.001, initial_spread=1.0, points=4,
           agree=4, **{"differ by less than 1 %": 0}, differ=0),
]  # fmt: skip


def written(folder, comparisons):
    """The section as HTML."""
    rows = dict(zip(described.TOLD_BY, (comparisons, FAMILIES), strict=True))
    files = {name: [folder / f"{name}.csv"] for name in rows}
    for name, (path,) in files.items():
        pd.DataFrame(rows[name]).to_csv(path, index=False)
    settings = pages.SETTINGS | {
        "defaults": pages.SETTINGS["defaults"] | {"time_step": 0.001},
        "datasets": {
            name: {"duration": 1000.0 + number, "transient": 400.0, "replicate": list(range(32))}
            for number, name in enumerate(name for _, name in described.PARTS.values())
        },
    }
    figures = ["agreement_disorder"]
    run = pages.material(folder, figures=figures, settings=settings, **files)
    return pages.part(pages.written(folder, run), "integrators")


@pytest.fixture(scope="module")
def section(tmp_path_factory):
    return written(tmp_path_factory.mktemp("integrators"), COMPARISONS)


def tables(section):
    """Rows of both tables, without their heads."""
    markup = section.split("<table>")[1:]
    assert len(markup) == 2
    return [cells(table)[1:] for table in markup]


def test_every_family_has_its_row(section):
    whole = "agree: 6 differ by less than 1 %: 3 differ: 2"
    ks = "Kolmogorov-Smirnov"
    assert tables(section)[0] == [
        ["With noise", f"{DISORDER} {ks}", "", "32", whole, "0.004"],
        ["Slips and section points", f"section points {ks}", "", "32",
         "agree: 8 not measured: 3", "0.004"],
        ["Attractors and lifetimes without noise", f"lifetime {ks}",
         "dt = 0.002, initial spread 1", "32", whole, "0.004"],
        ["Attractors and lifetimes without noise", f"lifetime {ks}",
         "dt = 0.001, initial spread 1", "32", "agree: 4", "0.004"],
    ]  # fmt: skip


def test_every_point_of_r_and_of_the_states_has_its_row(section):
    rows = tables(section)[1]
    shown = [one for one in COMPARISONS if one["quantity"] != "mean length"]
    assert f"point by point ({len(shown)} rows" in section
    values = ["0.1234 ± 0.01", "0.4321 ± 0.02"]
    assert rows[:3] == [
        [DISORDER, "5", "8", "1", "", "31, 32", *values, "-1.8", "0.25", "0.75", "3.4 %", "agree"],
        [DISORDER, "5", "14", "2.2", "", "31, 32", *values, "", "< 1e-12", "< 1e-12", "3.4 %",
         "differ"],
        [STICKING, "5", "8", "0", "dt = 0.001, initial spread 1", "31, 32", *values, "-1.8",
         "0.25", "0.75", "3.4 %", "agree"],
    ]  # fmt: skip
    results = [(one[0], one[2], one[4], one[12]) for one in rows[3:]]
    assert results == [
        (one["quantity"], f"{one['belt_velocity']:g}",
         f"dt = {one['time_step']:g}, initial spread {one['initial_spread']:g}", one["verdict"])
        for one in shown[3:]
    ]  # fmt: skip


def sentences(section):
    """Sentences by heading, with the words on lengths."""
    blocks = section.split("<h3>")[1:4]
    return {
        words(block.split("</h3>")[0]): (words(block.split("</h3>")[1].split("<ul>")[0]),
                                         [words(item) for item in block.split("<li>")[1:]])
        for block in blocks
    }  # fmt: skip


def test_sentences_stand_under_their_part_with_its_lengths(section):
    parts = sentences(section)
    assert list(parts) == [title for title, _ in described.PARTS.values()]
    for number, (lengths, _) in enumerate(parts.values()):
        assert lengths.startswith(f"t = {1000 + number}, of which 400 discarded, 32 runs at each")


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({}, "does not hold at 2 of 5 points: r at the end depends on the integrator, but not, wi"),
        (
            {5: "differ", 7: "differ"},
            "at 4 of 5 points: r at the end depends on the integrator, al",
        ),
        ({4: "agree", 6: "agree"}, "nothing speaks against the last sentence of the Appendix"),
    ],
)
def test_the_conclusion_is_that_of_the_points_at_the_step_of_the_run(tmp_path, changed, words):
    verdicts = {k: {"verdict": verdict} for k, verdict in changed.items()}
    comparisons = [one | verdicts.get(k, {}) for k, one in enumerate(COMPARISONS)]
    section = written(tmp_path, comparisons)
    (conclusion,) = sentences(section)["Attractors and lifetimes without noise"][1]
    assert words in conclusion


def test_without_comparisons_at_the_end_nothing_is_concluded(tmp_path):
    (conclusion,) = sentences(written(tmp_path, COMPARISONS[:4]))[
        "Attractors and lifetimes without noise"
    ][1]
    assert "is not measured" in conclusion
