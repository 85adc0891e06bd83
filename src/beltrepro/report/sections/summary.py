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
    """Number of findings with each verdict, how many there are, and how many can be tested.

    Claims that are true because the model is built so are no findings: `construction` counts them.
    """
    findings = [row for row in claims if row["kind"] != "construction"]
    counts = {verdict: sum(row["verdict"] == verdict for row in findings) for verdict in VERDICTS}
    return {
        "by_verdict": counts,
        "total": len(findings),
        "testable": len(findings) - counts[NOT_TESTABLE],
        "construction": len(claims) - len(findings),
    }
