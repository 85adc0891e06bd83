"""The player of the report: what the page carries, and how it works in a browser."""

import base64
import functools
import json
import re
from pathlib import Path

import numpy as np
import pytest

import browser
from beltrepro import ChainParameters, simulate
from beltrepro.base import store
from beltrepro.model.units import TIME_S
from beltrepro.replication.report import motion_player
from beltrepro.replication.report.contents import MOTION
from beltrepro.replication.report.material import Material
from beltrepro.replication.report.page import part

CHAINS = {
    "play_u1": ChainParameters(5, 1.0),
    "play_u17": ChainParameters(5, 17.6, 2.2),
    "play_u25": ChainParameters(4, 25.0),
    "play_n10": ChainParameters(10, 28.0),
}
INTERVAL, BEGIN, END = 0.5, 30.0, 130.0


@functools.cache
def run_of(name):
    span = {"duration": END, "sample_interval": INTERVAL, "sample_start": BEGIN}
    return simulate(CHAINS[name], method="event", **span)


@pytest.fixture(scope="module")
def section(tmp_path_factory):
    """The section as it stands in the page, of a run with no more than it needs."""
    folder = tmp_path_factory.mktemp("run")
    for name, chain in CHAINS.items():
        run = run_of(name)
        arrays = {key: getattr(run, key)[None] for key in ("positions", "velocities")}
        names = ("n_blocks", "belt_velocity", "noise", "rest_length")
        attributes = {key: getattr(chain, key) for key in names} | {"sample_interval": INTERVAL}
        store.write(folder / f"{name}.h5", arrays | {"time": run.time}, attributes)
    files = {"datasets": [folder / f"{name}.h5" for name in reversed(CHAINS)]}
    return part(MOTION, Material("smoke", {}, files))


def carried(section):
    (text,) = re.findall(
        r'<script type="application/json" id="player-data">(.*?)</script>', section
    )
    return json.loads(text)


def test_the_page_carries_the_runs(section):
    motions = carried(section)
    assert len(motions) == len(CHAINS)
    for name, motion in zip(CHAINS, motions, strict=True):
        run, chain = run_of(name), CHAINS[name]
        levels = np.frombuffer(base64.b64decode(motion["positions"]), "<u2")
        positions = motion["low"] + motion["step"] * levels.reshape(-1, chain.n_blocks)
        assert np.abs(positions - run.positions).max() <= 0.51 * motion["step"]
        assert motion["step"] < 0.05  # a fraction of a pixel
        slips = np.array(list(motion["signs"])).reshape(positions.shape)
        assert np.array_equal(slips == "s", run.velocities == chain.belt_velocity)
        assert np.array_equal(slips == ">", run.velocities > chain.belt_velocity)
        instants = motion["begin"] + motion["interval"] * np.arange(motion["samples"])
        assert np.allclose(instants, run.time)
        assert (motion["n_blocks"], motion["u"]) == (chain.n_blocks, chain.belt_velocity)
        assert 0 <= motion["still"] < motion["samples"]


def test_the_words_name_the_longest_slip_of_the_last_block():
    time = np.arange(8.0)
    assert motion_player._longest(np.array([0, 1, 0, -1, -1, 1, 0, 1]), time).endswith(
        "t = 3 to 5."
    )
    assert motion_player._longest(np.array([-1] * 8), time).endswith("t = 0 to 7.")
    assert motion_player._longest(np.zeros(8), time) == "Here the last block does not slip."


def test_slow_belts_are_shown_faster():
    assert [motion_player._speed(u) for u in (1.0, 4.0, 17.6, 40.0)] == [8.0, 4.0, 1.0, 1.0]


def test_the_section_names_no_address(section):
    assert not re.findall(
        r"(?:src|href)\s*=|fetch\(|XMLHttp|import\(|https?://(?!www.w3.org)", section
    )


# --- in a browser ---------------------------------------------------------------------------------


# The virtual time of the browser has few frames: give it a frame every 16 ms.
STEADY = "requestAnimationFrame = (call) => setTimeout(() => call(performance.now()), 16);"


def worked(section, folder, width, *flags):
    """What the script of the test saw in a page of this width."""
    script = Path(__file__).with_name("player_script.js").read_text(encoding="utf-8")
    page = folder / f"page{width}.html"
    style = (Path(motion_player.__file__).parent / "report.css").read_text(encoding="utf-8")
    page.write_text(
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><style>{style}</style>'
        f'<script>{STEADY}</script></head><body style="width: {width}px">{section}'
        f"<script>{script}</script></body></html>",
        encoding="utf-8",
    )
    return browser.seen(page.as_uri(), folder, *flags)


@pytest.fixture(scope="module", params=[390, 1100])
def seen(request, section, tmp_path_factory):
    if not browser.BROWSER:
        pytest.skip("no chromium here: see README, Tests in a browser")
    return worked(section, tmp_path_factory.mktemp("browser"), request.param)


def test_no_errors_and_no_requests(seen):
    assert seen["errors"] == [] and seen["requests"] == [] and seen["hidden"] is False


def test_blocks_are_drawn_where_they_are(seen):
    for name, motion in zip(CHAINS, seen["motions"], strict=True):
        run = run_of(name)
        assert motion["last"] == len(run.time) - 1
        assert CHAINS[name].describe().partition(",")[0].replace("=", " = ") in motion["words"]
        scale = (motion["width"] - 16) / (motion_player._ROOM * run.positions.max())
        for picture in motion["pictures"]:
            row = picture["frame"]
            assert picture["time"] == pytest.approx(run.time[row], abs=0.06)
            assert picture["places"] == pytest.approx(8 + scale * run.positions[row], abs=0.1)
            stuck = run.velocities[row] == CHAINS[name].belt_velocity
            assert picture["slipping"] == (~stuck).tolist()
        dots = np.array([picture["dot"] for picture in motion["pictures"]])
        assert np.all(np.diff(dots[:, 0]) > 0)
        rows = [picture["frame"] for picture in motion["pictures"]]
        lengths = run.positions[:, -1]
        share = (lengths[rows] - lengths.min()) / np.ptp(lengths)
        assert dots[:, 1] == pytest.approx(108 - 98 * share, abs=0.2)


def test_keys_and_buttons(seen):
    assert (seen["right"], seen["left"], seen["home"]) == (21, 11, 0)
    assert seen["end"] == seen["motions"][-1]["last"]
    assert (seen["faster"], seen["slower"]) == (["1", "2"], "0.5")
    assert (seen["other"], seen["forward"], seen["back"]) == (0, 1, 0)
    width = seen["motions"][-1]["width"]  # the curve has 44 pixels beside it on the left, 12 right
    assert seen["touched"] == pytest.approx((width / 2 - 44) / (width - 56), abs=0.01)


def test_it_plays_at_its_speed_and_stops(seen):
    assert (seen["pressed"], seen["paused"]) == ("Pause", "Play")
    expected = 4 * seen["seconds"] / TIME_S / INTERVAL
    assert seen["played"] == pytest.approx(expected, rel=0.1)
    assert seen["stood"] and seen["again"]
    assert seen["stopped"] == ["Play", True]


def test_controls_have_names_and_room_for_a_finger(seen):
    assert all(seen["names"]) and len(seen["names"]) == 4 + 3 + 2 + 2
    assert min(seen["small"]) >= 38
    assert seen["overflow"] <= 0


@pytest.mark.thorough
def test_less_motion_is_a_picture_a_second(section, tmp_path):
    if not browser.BROWSER:
        pytest.skip("no chromium here: see README, Tests in a browser")
    seen = worked(section, tmp_path, 600, "--force-prefers-reduced-motion")
    assert seen["errors"] == []
    assert seen["played"] == 0  # after 0.7 s the first picture still stands
