"""From the ledger of claims to verdicts."""
