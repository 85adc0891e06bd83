"""The ledger of the paper's claims, and the code that turns datasets into verdicts.

The files in `ledger/` hold every claim with its criterion. Each claim that can be measured has one
function in the module of its section, registered under its id; `measuring.measure` calls them all.
"""

from beltrepro.claims.entries import Claim, load_ledger

__all__ = ["Claim", "load_ledger"]
