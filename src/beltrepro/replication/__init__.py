"""The replication of the paper: plan, studies, verdicts, report. The library does not import it."""
