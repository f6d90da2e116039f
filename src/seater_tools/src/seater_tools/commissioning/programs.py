"""The commands as a person types them."""

from __future__ import annotations

import contextlib
import io
import runpy
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from roslib.packages import find_node


@dataclass(frozen=True)
class Done:
    """`code`: exit status; `output`: what both streams said."""

    code: int
    output: str

    @property
    def last(self) -> str:
        """The last line."""
        return self.output.strip().rpartition("\n")[2]


def run_program(package: str, program: str, *words: str | Path) -> Done:
    """`rosrun package program words`, but in this process: a new one takes seconds to start.

    Raises FileNotFoundError: there is no such program; and what the program itself does not catch.
    """
    paths = find_node(package, program)
    if not paths:
        raise FileNotFoundError(f"package {package} has no program {program}")
    output = io.StringIO()
    with (
        _arguments([paths[0], *map(str, words)]),
        contextlib.redirect_stdout(output),
        contextlib.redirect_stderr(output),
    ):
        try:
            runpy.run_path(paths[0], run_name="__main__")
            code = 0
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else int(end.code is not None)
    return Done(code, output.getvalue())


@contextlib.contextmanager
def _arguments(line: list[str]) -> Iterator[None]:
    before = sys.argv
    sys.argv = line
    try:
        yield
    finally:
        sys.argv = before
