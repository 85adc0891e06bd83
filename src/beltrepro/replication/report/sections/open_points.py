"""What the paper leaves open: in the model, with the reading taken, and in single claims."""

from beltrepro.replication.report.findings.readings import printed, together

TITLE = "Open points and the readings tried"
ANCHOR = "ambiguities"
NEEDS = ("claims", "estimates")
# Points of the model that the text leaves open, and the reading taken.
MODEL = (
    (
        "When a stuck block gets a new threshold of static friction.",
        "It keeps the one drawn where it stuck: its place on the belt does not change. A slipping "
        "block draws anew at every step.",
    ),
    (
        "What happens when the relative velocity changes sign while the external force exceeds "
        "static friction.",
        "The block slips on towards the external force; both events, a stick and a slip, are "
        "recorded at that instant.",
    ),
    (
        "The first step of the position formula, which needs the position one step earlier.",
        "All blocks start stuck, so the step before follows from the velocity of the belt.",
    ),
    (
        "The section for other numbers of blocks than five.",
        "615 for 5 blocks, as in the paper. This is nearly the length at which the springs balance "
        "the kinetic friction of all blocks; for other N the same fraction of that length.",
    ),
    (
        "Which criterion makes a point intermittent, periodic or chaotic.",
        "Shares and numbers of laminar phases, recurrence of section velocities and the 0-1 test "
        "for chaos; the thresholds stand in the documentation of the functions and in the criteria "
        "of the claims.",
    ),
    (
        "How the transition region and its midpoint are read off r(u).",
        "From 90 % to 10 % of the fall between two plateaus, in a running median over 3 units of "
        "u; the error of the midpoint comes from resampled points and the grid.",
    ),
)


def gather(material) -> dict:
    """Printed numbers beside what the readings span; points of the model, and of claims."""
    results = material.claims.values()
    return {
        "printed": printed(results),
        "model": [{"open": point, "reading": reading} for point, reading in MODEL],
        "claims": [(result, together(result)) for result in results if result.claim.open],
    }
