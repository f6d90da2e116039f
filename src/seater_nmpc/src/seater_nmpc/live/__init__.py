"""Parameters that may be changed while the docking node runs: which ones, when, and with what they have to agree."""
