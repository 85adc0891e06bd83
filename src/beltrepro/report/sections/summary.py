"""Above everything: how many claims hold."""

from beltrepro.claims.criteria import NOT_TESTABLE, VERDICTS


def gather(material) -> dict:
    """Number of claims with each verdict, how many there are, and how many can be tested."""
    return {
        "preset": material.preset,
        "verdicts": VERDICTS,
        "counts": count_verdicts(material.claims),
    }


def count_verdicts(claims: list[dict]) -> dict:
    """Number of claims with each verdict, how many there are, and how many can be tested."""
    counts = {verdict: sum(row["verdict"] == verdict for row in claims) for verdict in VERDICTS}
    return {
        "by_verdict": counts,
        "total": len(claims),
        "testable": len(claims) - counts[NOT_TESTABLE],
    }
