"""The picture of a run: what it shows is what the run has, and where it goes."""

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from beltrepro import ChainParameters, simulate
from beltrepro.base.errors import InputError
from beltrepro.simulation import picture

CHAIN = ChainParameters(3, 10.0, 1.0)


@pytest.fixture(scope="module")
def run():
    return simulate(CHAIN, duration=400.0, transient=100.0, method="event")


def test_a_slip_across_the_ends_of_a_run_is_cut():
    whole = simulate(CHAIN, duration=400.0, method="event")
    low, high = picture.slips_of(whole, 2)[3]
    middle = (low + high) / 2
    before = simulate(CHAIN, duration=middle, method="event")
    after = simulate(CHAIN, duration=50.0, method="event", initial_state=before.final_state)
    assert picture.slips_of(before, 2)[-1] == pytest.approx((low, middle))
    assert picture.slips_of(after, 2)[0] == pytest.approx((middle, high), abs=1e-6)


def test_panels_show_the_samples_r_and_the_last_slips(run):
    length, disorder, slips = picture.draw(run).axes
    curve, level = disorder.lines
    assert curve.get_ydata()[-1] == pytest.approx(run.disorder_parameter, rel=1e-3)
    assert level.get_ydata()[0] == run.disorder_parameter
    assert curve.get_xdata()[0] == pytest.approx(100.0)
    trace, mean = length.lines
    assert np.array_equal(trace.get_xdata(), run.time)
    assert np.array_equal(trace.get_ydata(), run.positions[:, -1])
    assert mean.get_ydata()[0] == run.mean_length
    assert length.get_xlim() == (0.0, 400.0)
    assert slips.get_xlim() == (200.0, 400.0)
    # one collection a block; a bar spans the slip, and the row of its block
    for block, bars in enumerate(slips.collections, start=1):
        pairs = np.array(picture.slips_of(run, block))
        inside = [np.any((pairs[:, 0] < t) & (t < pairs[:, 1])) for t in run.time]
        moves = run.velocities[:, block - 1] != CHAIN.belt_velocity
        assert np.mean(np.array(inside) == moves) > 0.999  # a sample may lie on an end
        shown = pairs[pairs[:, 1] > 200.0]
        boxes = [path.get_extents() for path in bars.get_paths()]
        np.testing.assert_allclose([(box.x0, box.x1) for box in boxes], shown)
        assert {round((box.y0 + box.y1) / 2, 9) for box in boxes} == {block}


def test_one_block_without_samples_and_with_another_constant():
    chain = ChainParameters(1, 5.0, friction_ratio=0.3)
    bare = simulate(chain, duration=50.0, sample_interval=None, method="event")
    length, disorder, _ = picture.draw(bare).axes
    assert not any(axes.lines[0].get_xdata().size for axes in (length, disorder))
    title = length.get_title()
    assert "N=1, u=5, σ=0, f_s=0.3" in title and "F_st0" not in title


def test_one_panel_shows_the_samples_and_slips_of_a_run(run):
    axes = Figure(figsize=(5, 4), dpi=60).subplots()
    run.plot_length(ax=axes)
    (shade,) = axes.collections
    points = shade.get_paths()[0].vertices
    length = run.positions[:, -1]
    assert len(points) < 700 and (points[:, 1].min(), points[:, 1].max()) == (
        length.min(), length.max())  # fmt: skip
    (line,) = run.plot_length(window=(200, 210)).lines
    inside = (run.time >= 200) & (run.time <= 210)
    assert np.array_equal(line.get_xydata(), np.transpose([run.time[inside], length[inside]]))
    late = run.time >= 100
    for block in (1, -1):
        (line,) = run.plot_phase(block=block).lines
        column = block - 1 if block > 0 else -1
        assert np.array_equal(line.get_xdata(), run.positions[late, column])
        assert np.array_equal(line.get_ydata(), run.velocities[late, column])
    (line,) = run.plot_phase(window=(200, 210)).lines
    assert np.array_equal(line.get_xdata(), length[inside])
    slips = run.plot_slips(color="red")
    assert slips.get_xlim() == (200.0, 400.0)
    bars = [len(bars.get_paths()) for bars in slips.collections]
    assert bars == [len(picture.slips_of(run, block)) for block in (1, 2, 3)]
    for wrong, words in (({"window": (9, 5)}, "window"), ({"window": (900, 950)}, "no samples")):
        with pytest.raises(InputError, match=words):
            run.plot_length(**wrong)
    with pytest.raises(InputError, match="allowed are 1 to 3, and -1 for the last"):
        run.plot_phase(block=0)


def test_a_picture_begins_where_samples_do():
    late = simulate(ChainParameters(2, 5.0), duration=60, sample_start=40)
    axes = picture.draw(late).axes
    assert axes[0].get_xlim() == late.plot_length().get_xlim() == (40, 60)
    # the run's r is that of all, the line in the title
    assert axes[1].get_ylabel() == "$r$ up to $t$\nfrom 40 on"
    left_out = simulate(ChainParameters(2, 5.0), duration=60, transient=40, sample_start=20)
    assert picture.draw(left_out).axes[1].get_ylabel() == "$r$ up to $t$"


@pytest.mark.thorough
@pytest.mark.parametrize("suffix", picture.SUFFIXES)
def test_files_of_each_kind(run, tmp_path, suffix):
    path = tmp_path / f"run{suffix}"
    figure = run.plot(path)
    assert figure.axes and path.stat().st_size > 5000
    assert list(tmp_path.iterdir()) == [path]


def test_without_a_display_a_file_is_asked_for(run):
    with matplotlib.rc_context():
        matplotlib.use("agg")
        with pytest.raises(InputError, match="no display to show the figure on: name a file"):
            run.plot()
