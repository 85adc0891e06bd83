"""Numbers of studies against single calls: audits, sections."""

from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro import ChainParameters, audit, simulate
from beltrepro.base.store import Dataset
from beltrepro.replication.plan.files import CHAIN
from beltrepro.replication.studies.laws import measure as laws
from beltrepro.replication.studies.sizes import measure as sizes


def test_a_dataset_is_audited_as_its_run():
    chain = ChainParameters(2, 5.0, noise=0.5)
    run = simulate(chain, method="event", duration=60, sample_interval=0.1)
    of_run = {name: getattr(run, name) for name in ("time", "positions", "velocities", "friction")}
    about = {name: getattr(chain, name) for name in CHAIN} | {"method": "event", "time_step": 1e-3}
    residual = np.array([run.energy_residual])
    data = Dataset(of_run | {"energy_residual": residual}, about)
    table = laws.audit(dict.fromkeys(laws.TABLES["audit"].uses, data))
    assert table["dataset"].tolist() == ["u20", "u17", "friction_event", "n10_u28"]
    for name, value in vars(audit(run)).items():
        assert table[name].to_numpy() == pytest.approx([value] * 4, nan_ok=True), name
    assert set(table["noise"]) == {0.5} and set(table["belt_velocity"]) == {5.0}


def test_distributions_at_the_section_are_compared_and_averaged_over_u(monkeypatch):
    monkeypatch.setattr(sizes, "RESAMPLES", 3)
    u, rng = np.array([1.0, 2.0, 4.0, 5.0, 9.0, 20.0]), np.random.default_rng(8)

    def row(shift, counts):
        samples = {p: shift * p + rng.normal(size=n) for p, n in zip(u, counts, strict=True)}
        place = np.repeat(u, counts)
        velocities = np.concatenate([samples[p] for p in u])
        velocities[place == 5.0] = np.where(rng.random(sum(place == 5.0)) < 0.9, np.nan, 1.0)
        return SimpleNamespace(
            belt_velocity=place, velocities=velocities, samples=samples,
            between=lambda low, high: (place >= low) & (place <= high),
        )  # fmt: skip

    quiet, noisy = row(0.0, [40, 50, 35, 60, 45, 80]), row(0.2, [45, 40, 55, 70, 36, 90])
    counted = [1.0, 2.0, 4.0, 9.0]  # at 5 there are few crossings, 20 is beyond the range
    far = []
    for place in counted:
        one, other = quiet.samples[place], noisy.samples[place]
        ends = np.concatenate([one, other])
        far.append(max(abs(np.mean(one <= end) - np.mean(other <= end)) for end in ends))
    value = sizes.effect_on_section(1.0, 9.0, quiet, noisy).value
    assert value == pytest.approx(np.trapezoid(far, counted) / 8)
