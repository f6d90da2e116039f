"""Text tables for the screen and for logs."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import indent

from tabulate import tabulate

_ALIGNMENTS = {"l": "left", "r": "right"}


def text_table(head: Sequence[str], rows: Sequence[Sequence[str]], align: str = "") -> str:
    """A table with a line below its head. `align`: l or r for each column; empty: the first left, the others right."""
    align = align or "l" + "r" * (len(head) - 1)
    alignments = [_ALIGNMENTS[letter] for letter in align] if rows else None
    return indent(tabulate(rows, head, tablefmt="simple", disable_numparse=True, colalign=alignments), "  ")


def text_list(rows: Sequence[tuple[str, str]]) -> str:
    """Names and what is to be said about them, one a line."""
    return indent(tabulate(rows, tablefmt="plain", disable_numparse=True), "  ")
