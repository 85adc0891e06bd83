"""Names for the motion of a chain, by recurrence and exponents, not by the look of a diagram."""

import numpy as np
import numpy.typing as npt

EQUILIBRIUM = "equilibrium slip"
PERIODIC = "periodic"
QUASI_PERIODIC = "quasi-periodic"
CHAOTIC = "chaotic"
TRANSIENT = "transient"
MOTIONS = (EQUILIBRIUM, PERIODIC, QUASI_PERIODIC, CHAOTIC, TRANSIENT)

# Standard errors by which an exponent must differ from zero, and e-foldings that it must bring
# about in the time of observation: less cannot be told from a change of the vector within a period.
ERRORS = 3.0
FOLDINGS = 5.0


def name_motion(
    *,
    turns: bool,
    closed: bool,
    exponents: npt.ArrayLike,
    standard_error: npt.ArrayLike,
    time: float,
    n_trivial: int = 1,
) -> str:
    """Name of a motion from what was observed of it for some time.

    Criteria, in this order:

    - "equilibrium slip": no block sticks or reverses any more;
    - "periodic": the state comes back (`recurrence.find_recurrence`);
    - "chaotic": the motion is irregular to the end and its largest exponent is above zero;
    - "quasi-periodic": irregular, no exponent above zero, and more of them are zero than the
      symmetries of the motion explain: it fills a torus;
    - "transient": irregular to the end, and no exponent above zero: it is on the way to one of the
      others, or too short a time was observed.

    An exponent is zero if it is less than 3 standard errors, or 5 e-foldings in the time, from it.

    Parameters
    ----------
    turns : bool
        Whether blocks still stick or reverse at the end.
    closed : bool
        Whether the orbit closes.
    exponents : array (K,)
        Lyapunov exponents per unit of time, the largest first.
    standard_error : array (K,)
        Their errors.
    time : float
        Of observation.
    n_trivial : int
        Exponents that are zero by symmetry: 1 for a flow, 0 for a map or under noise.

    Returns
    -------
    str
        One of MOTIONS.
    """
    if not turns:
        return EQUILIBRIUM
    if closed:
        return PERIODIC
    values = np.asarray(exponents, dtype=float)
    margin = np.maximum(ERRORS * np.asarray(standard_error, dtype=float), FOLDINGS / time)
    if np.any(values > margin):
        return CHAOTIC
    if np.sum(np.abs(values) <= margin) > n_trivial:
        return QUASI_PERIODIC
    return TRANSIENT
