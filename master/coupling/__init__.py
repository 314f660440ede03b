"""The order of coupling, and what it does to every connection: schedule, delay ledger, algebraic loops."""
