"""What explains the windows of the scheme and the chaos of long chains, from published tables."""

from beltrepro.replication.studies.disturbance import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats.estimates import Estimate

# Noise is taken as the kicks that move slips as much.
_NAMES = {"kick": "kicks", "step": "steps", "noise as kick": "noise"}


@claim("orbit-loss")
def orbit_loss(evidence):
    """Power of the margin, and share of it, of each kind of disturbance."""
    lines = measure.loss_lines({"orbits_lost": measure.orbits_lost({})}).set_index("disturbance")
    return Measurement(
        {
            f"{number}, {name}": _estimate(lines.loc[kind], number, "orbits")
            for number in ("power", "share")
            for kind, name in _NAMES.items()
        }
    )


@claim("lifetime-growth")
def lifetime_growth(evidence):
    """Rate c at each belt velocity at which motion of three or more numbers of blocks ends."""
    rates = measure.lifetime_rates({"lifetime_growth": measure.lifetime_growth({})})
    return Measurement(
        {
            f"rate, u = {row['belt_velocity']:g}": _estimate(row, "rate", "sizes")
            for _, row in rates.iterrows()
        }
    )


def _estimate(row, name: str, counted: str) -> Estimate:
    """A number of a table with its interval."""
    return Estimate(row[name], row[f"{name}_low"], row[f"{name}_high"], int(row[counted]))
