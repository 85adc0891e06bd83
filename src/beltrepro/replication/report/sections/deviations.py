"""What is done differently from the paper: by this run, and by every run."""

from beltrepro.replication.report.material import distinct, length

TITLE = "Deviations from the paper"
ANCHOR = "deviations"
NEEDS = ()

PAPER_DURATION = 2e6
PAPER_TRANSIENT = 1e6

ALWAYS = (
    {
        "what": "Criteria",
        "paper": "judged by eye",
        "ours": "computed, by criteria fixed before the runs that they judge",
        "where": "claims",
        "why": "so that anyone gets the same verdict",
    },
    {
        "what": "Initial states",
        "paper": "one declared state",
        "ours": "the declared state for scans and series; slightly shifted copies of it where "
        "statistics are needed",
        "where": "Figs. 9, 10 and the inset of Fig. 12",
        "why": "one chaotic trajectory is no sample; copies are independent ones",
    },
    {
        "what": "Lifetimes of transients",
        "paper": "method of a cited reference",
        "ours": "exponential law by maximum likelihood, runs that did not escape counted as "
        "censored",
        "where": "inset of Fig. 12",
        "why": "uses every run and gives an error",
    },
)


def gather(material) -> dict:
    """Rows of texts: in lengths and methods of this run, and the general ones."""
    return {"deviations": [*_of_run(material.datasets), *ALWAYS]}


def _of_run(datasets: list[dict]) -> list[dict]:
    scans = [each for each in datasets if each["kind"] == "scan"]
    lengths = {(each["duration"], each["transient"]) for each in scans}
    others = sorted(lengths - {(length(PAPER_DURATION), length(PAPER_TRANSIENT))})
    rows = [_of_lengths(scans, *pair) for pair in others]
    by_events = [each["name"] for each in datasets if "event" in each["method"]]
    return [*rows, _of_integrator(by_events)] if by_events else rows


def _of_lengths(scans, duration, transient) -> dict:
    names = [
        scan["name"]
        for scan in scans
        if (scan["duration"], scan["transient"]) == (duration, transient)
    ]
    return {
        "what": "Length of the runs",
        "paper": f"t = {length(PAPER_DURATION)}, of which {length(PAPER_TRANSIENT)} discarded",
        "ours": f"t = {duration}, of which {transient} discarded",
        "where": ", ".join(distinct(names)),
        "why": "this preset trades length for time; the preset named paper does not",
    }


def _of_integrator(names) -> dict:
    return {
        "what": "Integrator",
        "paper": "Verlet scheme, step 0.001, stick and slip at the ends of steps",
        "ours": "high order between events, instants of stick and slip located",
        "where": ", ".join(names),
        "why": "faster; see the section on the two integrators",
    }
