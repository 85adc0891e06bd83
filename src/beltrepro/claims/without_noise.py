"""Claims on the deterministic chain of five blocks (Sec. IV.A)."""

from functools import partial

import numpy as np
from scipy import stats

from beltrepro.analysis import avalanches, lifetimes, sections, spectra, states
from beltrepro.analysis.errors import require
from beltrepro.claims.criteria import Measurement
from beltrepro.claims.evidence import last_block_events
from beltrepro.claims.registry import claim

MINIMUM_SLIPS = 500
BINS_PER_DECADE = 10


# --- Fig. 8 ---------------------------------------------------------------------------------------


@claim("spectrum-exponent")
def spectrum_exponent(evidence):
    """Exponent of the spectrum of x_N in every reading of "power spectrum"."""
    series = evidence.dataset("u1")
    time, positions = series.arrays["time"], series.arrays["positions"][:, -1]
    settled = time >= series.attributes["transient"]
    values, interval = positions[settled], float(np.median(np.diff(time)))
    low, high = spectra.FIT_BAND
    needed = 10 / low
    require(
        values.size * interval >= needed,
        f"the series lasts {values.size * interval:.0f}, {needed:.0f} are needed for nu >= {low}",
    )

    def reading(window="hann", segment=None, band=(low, high), amplitude=False):
        frequency, spectrum = spectra.power_spectrum(
            values, interval, segment=segment, window=window
        )
        if amplitude:
            spectrum = spectra.amplitude_spectrum(frequency, spectrum)
        fit = spectra.fit_power_law(frequency, spectrum, low=band[0], high=band[1])
        return Measurement(
            fit.exponent, fit.exponent_error, values.size, note=f"prefactor {fit.prefactor:.2g}"
        )

    return {
        "power": reading,
        "amplitude": partial(reading, amplitude=True),
        "power, no window function": partial(reading, window="boxcar"),
        "amplitude, no window function": partial(reading, window="boxcar", amplitude=True),
        "power, averaged over 8 segments": partial(
            reading, segment=values.size // 8, band=(2 * low, high)
        ),
        "power, fit for 0.01 to 1": partial(reading, band=(0.01, 1.0)),
        "amplitude, fit for 0.01 to 1": partial(reading, band=(0.01, 1.0), amplitude=True),
        "power, fit for 0.001 to 0.1": partial(reading, band=(0.001, 0.1)),
        "amplitude, fit for 0.001 to 0.1": partial(reading, band=(0.001, 0.1), amplitude=True),
    }


@claim("slip-velocity")
def slip_velocity(evidence):
    """Relative velocity of the last block between and within its slips."""
    series = evidence.dataset("u1")
    belt_velocity = series.attributes["belt_velocity"]
    time = series.arrays["time"]
    relative = series.arrays["velocities"][:, -1] - belt_velocity
    slips, sticks = last_block_events(series)
    require(slips.size >= 20 and sticks.size >= 20, f"{slips.size} slips of the last block, not 20")
    count = min(slips.size, sticks.size)
    begin, end = slips["time"][:count], sticks["time"][:count]
    # Samples strictly inside, one sample away from the events, of each slip and each stick.
    margin = 1.5 * float(np.median(np.diff(time)))
    stuck = np.zeros(time.size, dtype=bool)
    peaks = []
    for index in range(count - 1):
        stuck |= _within(time, end[index] + margin, begin[index + 1] - margin)
        moving = _within(time, begin[index], end[index])
        if moving.any():
            peaks.append(np.abs(relative[moving]).max())
    require(stuck.any() and len(peaks) >= 10, "too few samples within sticks and slips")
    peaks = np.array(peaks)
    return Measurement(
        {
            "largest |v_r| while stuck": float(np.abs(relative[stuck]).max()),
            "largest |v_r| / u in slips": float(peaks.max() / belt_velocity),
            "smallest peak / u": float(peaks.min() / belt_velocity),
        },
        sample_size=len(peaks),
        checks={
            "zero while stuck": bool(np.abs(relative[stuck]).max() < 1e-9),
            "large excursions": bool(peaks.max() > 10 * belt_velocity),
            "peaks differ": bool(peaks.max() > 1.5 * peaks.min()),
        },
    )


# --- Figs. 9 and 10 -------------------------------------------------------------------------------


@claim("slip-size-exponent")
def slip_size_exponent(evidence):
    """Exponent of the density of slip sizes of the last block."""
    slips, n_blocks, belt_velocity = _slips(evidence)
    chain = avalanches.last_block_slips(slips, n_blocks)["point"]
    sizes = {
        frame: avalanches.last_block_slip_sizes(slips, n_blocks, belt_velocity, frame)
        for frame in avalanches.FRAMES
    }
    laboratory = sizes["laboratory"]
    return {
        "laboratory frame": partial(_density_exponent, laboratory, chain),
        "belt frame": partial(_density_exponent, sizes["belt"], chain),
        "5 bins per decade": partial(_density_exponent, laboratory, chain, bins_per_decade=5),
        "20 bins per decade": partial(_density_exponent, laboratory, chain, bins_per_decade=20),
        "all bins": partial(_density_exponent, laboratory, chain, whole_range=True),
        "maximum likelihood": partial(_likelihood_exponent, laboratory),
    }


@claim("slip-energy-exponent")
def slip_energy_exponent(evidence):
    """Exponent of the density of the energy dissipated in avalanches."""
    slips, n_blocks, _ = _slips(evidence)
    catalogue = evidence.dataset("slips_u1").arrays["avalanches"]
    own = avalanches.last_block_slips(slips, n_blocks)
    reaching = catalogue[avalanches.with_last_block(catalogue, slips, n_blocks)]
    until_stop = avalanches.dissipation_while_last_block_slips(slips, n_blocks)
    energy, chain = reaching["dissipated"], reaching["point"]
    drop = reaching["spring_energy_drop"]
    return {
        "chain, until all are stuck": partial(_density_exponent, energy, chain),
        "chain, until the last block stops": partial(_density_exponent, until_stop, own["point"]),
        "last block only": partial(_density_exponent, own["dissipated"], own["point"]),
        "all avalanches of the chain": partial(
            _density_exponent, catalogue["dissipated"], catalogue["point"]
        ),
        "drop in spring energy": partial(_density_exponent, drop, chain),
        "20 bins per decade": partial(_density_exponent, energy, chain, bins_per_decade=20),
        "maximum likelihood": partial(_likelihood_exponent, energy),
    }


# --- Figs. 11 and 12 ------------------------------------------------------------------------------


@claim("u7-periodic")
def u7_periodic(evidence):
    """Period of the section velocities at u = 7."""
    column = evidence.column("n5_u7", 5, 7.0)
    quiet = np.flatnonzero(column.noise == 0)
    require(quiet.size, "no point without noise in n5_u7")
    first = quiet[0]
    period = sections.find_period(column.velocities[first])
    last_stick = column.points["last_stick_time"][first]
    late = column.transient + 0.9 * (column.duration - column.transient)
    return Measurement(
        {"period in crossings": period, "r": float(column.disorder[first])},
        sample_size=int(np.isfinite(column.velocities[first]).sum()),
        checks={"periodic": period > 0, "keeps sticking": bool(last_stick > late)},
    )


@claim("u20-transient")
def u20_transient(evidence):
    """Lifetimes at u = 20: of many runs, and the run from the declared state."""
    return {
        "many runs": partial(_transient_of_many, evidence),
        "run from the declared state": partial(_single_transient, evidence),
    }


@claim("r-jump")
def r_jump(evidence):
    """Plateaus of r before and after its fall."""
    fall = evidence.row(5, 0.0).transition
    return Measurement(
        {"r_chaotic": fall.r_high, "r_periodic": fall.r_low},
        {"r_chaotic": fall.r_high_error, "r_periodic": fall.r_low_error},
        fall.n_points,
        checks={"ratio of at least 5": bool(fall.contrast >= 5)},
        note=f"ratio {fall.contrast:.2g}",
    )


@claim("u-critical")
def u_critical(evidence):
    """Midpoint of the transition region without noise."""
    fall = evidence.row(5, 0.0).transition
    return Measurement(
        fall.critical,
        fall.error,
        fall.n_points,
        note=f"region {fall.lower:.3g} to {fall.upper:.3g}",
    )


@claim("outliers")
def outliers(evidence):
    """Points of large r beyond the transition, and whether they are chaotic."""
    row = evidence.row(5, 0.0)
    inside = row.between(*evidence.claim.parameters["belt_velocity"])
    require(inside.sum() >= 4, f"{inside.sum()} points in 20 <= u <= 22, 4 are needed")
    fall = row.transition
    require(fall.found, "no transition found, so no plateau to stand out from")
    above = inside & (row.disorder > fall.r_high / 2)
    labels = row.states[above]
    regular = np.isin(labels, (states.PERIODIC, states.QUASI_PERIODIC, states.CONTINUOUS))
    return Measurement(
        {"outliers": int(above.sum()), "of them not chaotic": int(regular.sum())},
        sample_size=int(inside.sum()),
        checks={
            "outliers exist": bool(above.any()),
            "a regular one among them": bool(regular.any()),
            "none is chaotic": bool(regular.all()),
        },
        note=f"u = {', '.join(f'{u:g}' for u in row.belt_velocity[above])}" if above.any() else "",
    )


# --- shared ---------------------------------------------------------------------------------------


def _slips(evidence):
    catalogue = evidence.dataset("slips_u1")
    slips, n_blocks = catalogue.arrays["slips"], int(catalogue.attributes["n_blocks"])
    count = avalanches.last_block_slips(slips, n_blocks).size
    require(count >= MINIMUM_SLIPS, f"{count} slips of the last block, {MINIMUM_SLIPS} are needed")
    return slips, n_blocks, catalogue.attributes["belt_velocity"]


def _density_exponent(values, chain, *, bins_per_decade=BINS_PER_DECADE, whole_range=False):
    """Exponent of a density, with the spread over resampled chains as its error."""

    def fit(sample):
        histogram = avalanches.log_histogram(sample, bins_per_decade=bins_per_decade)
        low, high = avalanches.falling_range(*histogram)
        if whole_range:
            low, high = histogram[0][0], histogram[0][-1]
        return avalanches.fit_density(*histogram, low=low, high=high)

    best = fit(values)
    groups = [values[chain == number] for number in np.unique(chain)]
    error = best.exponent_error
    if len(groups) >= 8:
        resampled = stats.bootstrap(
            (np.arange(len(groups)),),
            lambda chosen: fit(np.concatenate([groups[k] for k in chosen])).exponent,
            vectorized=False,
            n_resamples=50,
            method="percentile",
            rng=np.random.default_rng(0),
        )
        error = max(error, float(resampled.standard_error))
    return Measurement(
        best.exponent,
        error,
        values.size,
        note=f"fit for {best.low:.3g} to {best.high:.3g}, {best.sample_size} bins",
    )


def _likelihood_exponent(values):
    low, high = avalanches.falling_range(
        *avalanches.log_histogram(values, bins_per_decade=BINS_PER_DECADE)
    )
    fit = avalanches.maximum_likelihood_exponent(values, low=low, high=high)
    ratio, chance = avalanches.compare_with_exponential(values, low=low, high=high)
    better = "a power law" if ratio > 0 else "an exponential"
    return Measurement(
        fit.exponent,
        fit.exponent_error,
        fit.sample_size,
        note=f"values {low:.3g} to {high:.3g}; {better} fits better (p = {chance:.1g})",
    )


def _transient_of_many(evidence):
    printed = evidence.claim.paper
    runs = evidence.dataset("lifetimes")
    duration = float(runs.attributes["duration"])
    require(duration >= 2 * printed, f"runs of {duration:g} cannot show lifetimes of {printed}")
    velocities = runs.arrays["belt_velocity"]
    nearest = velocities[np.argmin(np.abs(velocities - 20))]
    require(abs(nearest - 20) <= 0.5, "lifetimes has no belt velocity near 20")
    chosen = velocities == nearest
    require(chosen.sum() >= 10, f"{chosen.sum()} runs, 10 are needed")
    escaped = runs.arrays["escaped"][chosen].astype(bool)
    lived = np.where(escaped, runs.arrays["lifetime"][chosen], duration)
    low, high = np.quantile(lived, [0.025, 0.975])
    high = high if escaped.all() else np.inf
    labels = lifetimes.label_attractors(
        escaped,
        runs.arrays["final_disorder"][chosen],
        runs.arrays["final_stick_rate"][chosen],
    )
    slipping = float((labels != lifetimes.STICK_SLIP).mean())
    return Measurement(
        {"median lifetime": float(np.median(lived)), "share that escapes": slipping},
        {"median lifetime": _median_error(lived)},
        int(chosen.sum()),
        checks={
            "4000 within the central 95 %": bool(low <= printed <= high),
            "most end in continuous slip": slipping > 0.5,
        },
        note=f"central 95 %: {low:.0f} to {high:.0f}; runs of {duration:g}",
    )


def _single_transient(evidence):
    printed = evidence.claim.paper
    series = evidence.dataset("u20")
    duration = float(series.attributes["duration"])
    _, sticks = last_block_events(series)
    end = float(sticks["time"][-1]) if sticks.size else 0.0
    left = duration - end > max(evidence.laminar_time, 0.1 * duration)
    return Measurement(
        {"last stick": end},
        sample_size=1,
        checks={
            "ends in continuous slip": left,
            "within a factor of 2 of 4000": printed / 2 <= end <= printed * 2,
        },
        note=f"run of {duration:g}",
    )


def _within(time, begin, end):
    inside = np.zeros(time.size, dtype=bool)
    inside[np.searchsorted(time, begin) : np.searchsorted(time, end, side="right")] = True
    return inside


def _median_error(values):
    result = stats.bootstrap(
        (values,), np.median, n_resamples=500, method="percentile", rng=np.random.default_rng(0)
    )
    return float(result.standard_error)
