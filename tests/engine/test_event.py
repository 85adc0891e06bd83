"""The event integrator: exact references, roots, energy, events, the noise."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import chi2, kstest

import exact
from advancing import at_rest, integrator, recorded
from beltrepro import ChainParameters, simulate
from beltrepro.engine import integrator as engine_integrator
from beltrepro.engine.candidates import first_roots
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.simd import LANES, select, spread, store
from beltrepro.engine.taylor import LEVELS, ORDER
from beltrepro.engine.vector import kernel
from beltrepro.model.spring import external_force

WITHOUT_SAMPLES = {"method": "event", "sample_interval": None}


def advanced(chains, until, starts=None, *, replicates=None, **settings):
    """Chains that have been advanced, from displacements, and the record of each."""
    if starts is not None:
        starts = chains[0].rest_positions + starts
    group = integrator(EventIntegrator, at_rest(chains, starts, replicates), **settings)
    return group, recorded(group, until)


def run_from(n_blocks, belt_velocity, displacements, duration):
    """Events of several starts: one list of (time, block, kind) for each."""
    chain = ChainParameters(n_blocks, belt_velocity)
    starts = [chain.rest_positions + start for start in displacements]
    runs = simulate(
        [chain] * len(starts), duration=duration, initial_positions=starts, **WITHOUT_SAMPLES
    )
    return [run.events[["time", "block", "kind"]].tolist() for run in runs]


def sequence(events):
    return [single[1:] for single in events]


def times(events):
    return np.array([single[0] for single in events])


# --- against the references ---


def follows_reference(n_blocks, belt_velocity, start, duration):
    """Errors of the instants and of the end of a run, whose events are those of 40 digits."""
    reference = exact.ExactChain.of(belt_velocity, start.tolist())
    reference.advance(until=exact.fixed(duration))
    chain = ChainParameters(n_blocks, belt_velocity)
    places = chain.rest_positions + start
    run = simulate(chain, duration=duration, initial_positions=places, **WITHOUT_SAMPLES)
    events, end = run.events[["time", "block", "kind"]].tolist(), run.final_state
    assert sequence(events) == sequence(reference.events), (n_blocks, belt_velocity, start)
    instants = [float(exact.real(time)) for time in times(reference.events)]
    rows = [[float(exact.real(units)) for units in row[1:]] for row in (reference.y, reference.v)]
    apart = np.abs(np.array(rows) - [end.displacements, end.velocities])
    return np.abs(times(events) - instants), apart.max()


@pytest.mark.parametrize(
    ("n_blocks", "belt_velocity", "until"), [(1, 1.0, 197.0), (5, 20.0, 67.0), (10, 30.0, 41.0)]
)
def test_a_run_from_rest_follows_the_reference(n_blocks, belt_velocity, until):
    errors, end = follows_reference(n_blocks, belt_velocity, np.zeros(n_blocks), until)
    assert len(errors) >= 6 and errors.max() < 1e-10 and end < 1e-9


def slow(first, parts, *arguments):
    return [pytest.param(first + part, *arguments, marks=pytest.mark.slow) for part in range(parts)]


@pytest.mark.parametrize(("seed", "count"), [(11, 12), *slow(100, 10, 200)])
def test_random_starts_follow_the_reference(seed, count):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        n_blocks, belt_velocity = int(rng.integers(2, 9)), rng.uniform(2, 30)
        start = rng.normal(0, 3, n_blocks)
        errors, end = follows_reference(n_blocks, belt_velocity, start, 20.0)
        assert np.all(errors < 1e-8) and end < 1e-6


def boundary(rng, duration, width):
    """Two starts, `width` apart on a line, with different events: by sections of a random line.

    Between them one contact is gained or lost, two events change places, or a block that stuck
    slips on.
    """
    while True:
        n_blocks = int(rng.integers(2, 7))
        belt_velocity = rng.uniform(2, 30)
        start = rng.normal(0, 3, n_blocks)
        way = rng.normal(0, 1, n_blocks)
        low, high = 0.0, 0.3
        while high - low > width:
            # events that only the end of the run cuts off count as no difference
            places = np.linspace(low, high, 32)
            runs = run_from(n_blocks, belt_velocity, [start + s * way for s in places], duration)
            length = min(map(len, runs))
            starts = [sequence(events)[: length - 2] for events in runs]
            change = next((i for i, (a, b) in enumerate(pairwise(starts)) if a != b), None)
            if change is None:
                break
            low, high = places[change], places[change + 1]
        else:
            return n_blocks, belt_velocity, (start + low * way, start + high * way)


@pytest.mark.parametrize(("seed", "count", "least"), [(5, 3, 2), *slow(50, 4, 60, 20)])
def test_boundaries_between_sequences_lie_where_the_reference_has_them(seed, count, least):
    """No grazing contact is lost or invented."""
    rng, grazing = np.random.default_rng(seed), 0
    for _ in range(count):
        n_blocks, belt_velocity, sides = boundary(rng, duration=20.0, width=1e-9)
        for side in sides:
            errors, _ = follows_reference(n_blocks, belt_velocity, side, 20.0)
            # an event at a small rate takes its time from a small difference
            assert np.median(errors) < 1e-7 and errors.max() < 1e-4
        one, other = map(sequence, run_from(n_blocks, belt_velocity, sides, 20.0))
        length = min(len(one), len(other)) - 2
        grazing += sorted(one[:length]) != sorted(other[:length])  # not only in another order
    assert grazing >= least


@pytest.mark.filterwarnings("ignore:.*loading is measured")
def test_the_error_falls_as_the_tolerance():
    """As the step to the power ORDER - 1, and the step as the tolerance to 1/17 to 1/16."""
    tolerances = 10.0 ** -np.arange(1, 8)

    def places(tolerance):
        how = {"tolerance": tolerance, "initial_spread": 1.0, "replicate": range(8)}
        runs = simulate([ChainParameters(5, 20.0)] * 8, duration=30, method="event", **how)
        return np.array([run.positions for run in runs])

    exact_places = places(1e-14)
    errors = [np.abs(places(tolerance) - exact_places).max(axis=(1, 2)) for tolerance in tolerances]
    means = np.sqrt(np.mean(np.square(errors), axis=1))
    assert np.polyfit(np.log(tolerances), np.log(means), 1)[0] == pytest.approx(1.06, abs=0.08)


# --- roots ---


@pytest.mark.parametrize("method", ["event", "verlet"])
def test_small_forces_are_followed_as_closely(method):
    """All lengths, and with them the forces, times a: the times stay."""
    one, small = (
        simulate(
            ChainParameters(
                2, 10 * a, static_friction=71.4 * a, rest_length=50 * a, linear_limit=np.inf
            ),
            duration=150,
            method=method,
        )
        for a in (1.0, 1e-11)
    )
    np.testing.assert_allclose(small.positions / 1e-11, one.positions, rtol=1e-9)


NO_ROOT = 2.0


@kernel
def all_first_roots(polynomials, roots):
    length = spread(1.0)
    for column in range(roots.size // LANES):
        place, result, _ = first_roots(ORDER, 1e-15, polynomials, column, length, length > 0.0)
        store(roots, (column * LANES,), select(result, place, NO_ROOT))


def roots_of(coefficients):
    """`first_roots` of polynomials in the rows of (P, K), K <= LEVELS."""
    count, terms = coefficients.shape
    padded = np.zeros((-(-count // LANES) * LANES, LEVELS))
    padded[:count, :terms] = coefficients
    padded[count:, 0] = 1.0
    roots = np.empty(len(padded))
    flat = padded.reshape(-1, LANES, LEVELS).transpose(0, 2, 1).ravel()
    all_first_roots(np.ascontiguousarray(flat), roots)
    return roots[:count]


def series_like(rng, count, decay):
    """Random coefficients that fall as those of a series at the end of its step; positive at 0."""
    coefficients = rng.normal(0, 1, (count, LEVELS)) * decay ** np.arange(LEVELS)
    coefficients[:, 0] = np.abs(coefficients[:, 0])
    return coefficients


def test_first_root_is_that_of_bernstein_subdivision():
    rng = np.random.default_rng(2)
    coefficients = series_like(rng, 240, 0.6)
    # the lowest point of every other one is put close to zero, above or below
    for row in coefficients[::2]:
        polynomial = np.polynomial.Polynomial(row)
        lowest = minimize_scalar(polynomial, bounds=(0, 1), method="bounded").fun
        row[0] -= lowest + rng.choice([-1, 1]) * 10.0 ** rng.uniform(-10, -2)
    coefficients = coefficients[coefficients[:, 0] > 0]
    for row, root in zip(coefficients, roots_of(coefficients), strict=True):
        place = float(exact.real(exact.first_root([exact.fixed(c) for c in row.tolist()])))
        if place > 1:
            assert root == NO_ROOT
            continue
        # what the rounding of the value means for the place of the root
        slope = abs(np.polynomial.Polynomial(row).deriv()(place))
        assert abs(root - place) < 1e-14 * np.abs(row).sum() / slope + 1e-14


@pytest.mark.parametrize("depth", [1e-4, 1e-8, 1e-12])
def test_two_close_roots_are_neither_lost_nor_invented(depth):
    rng = np.random.default_rng(3)
    place = rng.uniform(0.05, 0.95, 400)
    factor = series_like(rng, 400, 0.4)[:, : LEVELS - 2]
    factor[:, 0] = np.abs(factor[:, 1:]).sum(axis=1) + 0.1  # positive on [0, 1]

    def touching(gap):
        double = np.stack([place**2 + gap, -2 * place, np.ones(400)], axis=1)
        return roots_of(np.array(list(map(np.convolve, double, factor))))

    assert np.all(touching(depth) == NO_ROOT)
    # the value is rounded to about 1e-16, and d(root)/d(value) = 1/(2 sqrt(depth))
    size = np.sqrt(depth)
    np.testing.assert_allclose(touching(-depth), place - size, rtol=0, atol=1e-14 / size + 1e-14)


def test_roots_at_the_ends_and_none():
    # zero at the start, just passed, beyond the end, double at 1/2
    coefficients = [[0, 1, 0], [-1e-30, 1, 0], [0, 0, 0], [1, 0, 0], [1, -0.999, 0], [1, 5, -3],
                    [1, -4, 4], [1e-16, -1, 0], [2, -4, 0]]  # fmt: skip
    expected = [0, 0, 0, NO_ROOT, NO_ROOT, NO_ROOT, 0.5, 1e-16, 0.5]
    roots = roots_of(np.array(coefficients))
    np.testing.assert_allclose(roots, expected, rtol=0, atol=1e-7)
    assert np.all(roots[:3] == 0)


@pytest.mark.parametrize("n_blocks", [1, 5, 10])
def test_energy_audit_closes_to_rounding(n_blocks):
    chains = [ChainParameters(n_blocks, u, s) for u in (1.0, 12.0, 30.0) for s in (0.0, 1.0)]
    for run in simulate(chains, duration=600, **WITHOUT_SAMPLES):
        noise = run.parameters.noise
        assert len(run.events) > 6
        # the steps of chains with noise may leave more
        assert abs(run.energy_residual) < (1e-7 if noise else 1e-12)
        if noise:
            strict = advanced([run.parameters], 600.0, noise_share=0.0)[0]
            assert abs(strict.energy_residual()) < 1e-12


# --- events that need care ---


def test_a_block_that_reverses_slips_straight_on():
    events = simulate(ChainParameters(20, 80.0), duration=1000, **WITHOUT_SAMPLES).events
    before, after = events[:-1], events[1:]
    again = (before["kind"] == "stick") & (after["kind"] == "slip")
    again &= (before["block"] == after["block"]) & (before["time"] == after["time"])
    assert again.sum() >= 3
    for field in ("force", "position", "dissipated"):
        np.testing.assert_array_equal(before[field][again], after[field][again])
    # any other stick holds; any other slip starts at the threshold
    force, slips = np.abs(events["force"]), events["kind"] == "slip"
    sticks, begun = np.append(again, False), np.append(False, again)
    assert np.all(force[sticks] >= 71.4) and np.all(force[~slips & ~sticks] <= 71.4)
    np.testing.assert_allclose(force[slips & ~begun], 71.4, rtol=0, atol=1e-11)
    for block in range(1, 21):
        turns = slips[events["block"] == block]
        assert np.all(turns[::2]) and not np.any(turns[1::2])


def test_two_blocks_that_slip_at_one_time():
    # linear springs: the second block stands exactly at its threshold from the start, the first
    # reaches its own at t = 28 exactly; from then on both move, which pulls neither back
    law = {"static_friction": 64.0, "friction_ratio": 0.5, "linear_limit": 1e6}
    chain = ChainParameters(2, 1.0, **law)
    options = {"method": "event", "sample_interval": 0.5}
    start = [150.0, 264.0]
    run = simulate(chain, duration=29.5, initial_positions=start, **options)
    slips = [(28.0, 1, "slip"), (28.0, 2, "slip")]
    assert run.events[["time", "block", "kind"]].tolist() == slips
    # x'' = -K (x - x_k) with friction +32 on both, from x = (128, 192), v = (1, 1)
    stiffness = np.array([[2.0, -1.0], [-1.0, 1.0]])
    square, modes = np.linalg.eigh(stiffness)
    rest = np.linalg.solve(stiffness, [32.0, 32.0])
    frequency, elapsed = np.sqrt(square), 1.5
    a, b = modes.T @ ([128.0, 192.0] - rest), modes.T @ [1.0, 1.0] / frequency
    motion = modes @ (a * np.cos(frequency * elapsed) + b * np.sin(frequency * elapsed)) + rest
    np.testing.assert_allclose(run.positions[-1] - chain.rest_positions, motion, rtol=0, atol=1e-10)


@pytest.mark.parametrize("method", ["event", "verlet"])
@pytest.mark.parametrize("positions", [[50, 120], [50, 80], [70, 140], [30, 50], [30, 100]])
def test_a_stuck_spring_may_stand_at_the_end_of_its_branch(positions, method):
    """Deformed by exactly 20, a run goes on as from a start 1e-9 beside it on both sides."""
    setting = {"duration": 30.0, "method": method}
    chain = ChainParameters(2, 5.0)
    exact = simulate(chain, initial_positions=positions, **setting)
    for side in (-1e-9, 1e-9):
        beside = simulate(chain, initial_positions=np.add(positions, [0, side]), **setting)
        assert exact.events["block"].tolist() == beside.events["block"].tolist()
        assert np.abs(exact.events["time"] - beside.events["time"]).max() < 1e-6 + 1e-3 * (
            method == "verlet"
        )
        assert np.abs(exact.final_state.positions - beside.final_state.positions).max() < 1e-2


@pytest.mark.parametrize("method", ["event", "verlet"])
def test_a_block_exactly_at_its_threshold_is_let_go(method):
    chain = ChainParameters(1, 1.0, static_friction=64.0, linear_limit=np.inf)
    run = simulate(chain, duration=2.0, initial_positions=[114.0], method=method)
    assert run.events["time"][0] <= 0.001 and run.events["force"][0] == pytest.approx(-64, abs=2e-3)


# --- samples and section ---


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_samples_are_the_states_of_shorter_runs(noise):
    chain = ChainParameters(4, 15.0, noise)
    (record,) = advanced([chain], 30.0, stride=700, noise_share=0.0)[1]
    assert len(record.samples) == 42
    for number, (displacement, relative_velocity, _) in enumerate(record.samples, start=1):
        (end,) = advanced([chain], number * 0.7, noise_share=0.0)[1]
        positions = displacement + chain.rest_positions
        np.testing.assert_allclose(positions, end.positions, rtol=0, atol=1e-10)
        np.testing.assert_allclose(relative_velocity + 15.0, end.velocities, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("method", "late"), [("event", 1e-11), ("verlet", 0.01)])
def test_friction_samples_balance_stuck_blocks(method, late):
    chain = ChainParameters(3, 2.0)
    run = simulate(chain, duration=150, method=method, sample_interval=0.1)
    force = external_force(run.positions, chain)
    stuck = run.velocities == 2.0
    assert 0 < stuck.mean() < 1
    np.testing.assert_allclose(run.friction[stuck], -force[stuck], rtol=0, atol=1e-11)
    np.testing.assert_allclose(np.abs(run.friction[~stuck]), 0.45 * 71.4, rtol=1e-14)
    assert np.abs(force[stuck]).max() <= 71.4 + late


# --- noise ---


@pytest.mark.parametrize(
    ("method", "duration", "least"), [("event", 10_000, 5000), ("verlet", 1500, 600)]
)
def test_thresholds_are_drawn_once_for_each_stick(method, duration, least):
    # One slow block sticks far from its threshold, so |F_ex| where it starts to slip is the draw.
    # Drawn anew while it is stuck, the smallest of many would win. Error rate of each bound 1e-6.
    chains = [ChainParameters(1, u, 5.0) for u in np.linspace(1, 2, 32)]
    runs = simulate(chains, duration=duration, method=method, sample_interval=None, seed=3)
    forces, before = [], []
    for run in runs:
        slips = run.events[run.events["kind"] == "slip"]
        stretch = slips["position"] - 50.0
        tension = np.where(stretch > 20, 20 + 100 * np.expm1(0.01 * (stretch - 20)), stretch)
        np.testing.assert_allclose(slips["force"], -tension, rtol=1e-12)
        forces.append(-slips["force"])
        before.append(run.events["force"][run.events["kind"] == "stick"])
    assert np.abs(np.concatenate(before)).max() < 71.4 - 7 * 5
    thresholds = np.concatenate(forces)
    assert len(thresholds) > least
    assert kstest(thresholds, "norm", (71.4, 5.0)).pvalue > 1e-6
    following = np.concatenate([values[1:] - 71.4 for values in forces])
    preceding = np.concatenate([values[:-1] - 71.4 for values in forces])
    correlation = (following * preceding).mean() / 25
    assert abs(correlation) < 5 / np.sqrt(len(following))


@pytest.mark.parametrize(
    ("until", "count"),
    [
        (1.5, 800),
        pytest.param(0.5, 12_000, marks=pytest.mark.slow),
        pytest.param(1.5, 12_000, marks=pytest.mark.thorough),
        pytest.param(2.5, 12_000, marks=pytest.mark.slow),
    ],
)
def test_kinetic_noise_has_the_law_of_an_oscillator_in_white_noise(until, count, monkeypatch):
    """One block with a linear spring that slips from t = 0; intensity q = f_s^2 sigma^2 dt.

    At the end of a cell the variances are 1e-4 too small, invisible here. Bounds at 5 standard
    errors: error rate 6e-7 each.
    """
    monkeypatch.setattr(engine_integrator, "_EVENTS", 16)
    belt_velocity, start, kinetic = 5.0, 80.0, 0.45 * 71.4  # 8 sigma beyond the mean threshold
    chain = ChainParameters(1, belt_velocity, 1.0, linear_limit=1e6)
    starts = np.full((count, 1), start)
    end, records = advanced([chain] * count, until, starts, replicates=range(count), stride=500)
    assert all(np.all(one.events[:, 0] == 0) for one in records)  # still in the first slip
    cosine, sine = np.cos(until), np.sin(until)
    position = kinetic + (start - kinetic) * cosine + belt_velocity * sine
    velocity = -(start - kinetic) * sine + belt_velocity * cosine
    ends = np.column_stack([end.positions()[:, 0] - 50.0, end.velocities()[:, 0]])
    deviations = ends - [position, velocity]
    mixed, wave = sine**2 / 2, np.sin(2 * until) / 4
    covariance = np.array([[until / 2 - wave, mixed], [mixed, until / 2 + wave]]) * 0.45**2 * 0.001
    assert np.all(np.abs(deviations.mean(axis=0)) < 5 * np.sqrt(np.diag(covariance) / count))
    # independent of each other after whitening
    white = np.linalg.solve(np.linalg.cholesky(covariance), deviations.T)
    assert abs((white[0] * white[1]).mean()) < 5 / np.sqrt(count)
    for values in (*white, white.ravel()):
        assert 3e-7 < chi2.cdf((values**2).sum(), values.size) < 1 - 3e-7
    assert kstest(white.ravel(), "norm").pvalue > 1e-6
