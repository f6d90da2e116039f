"""A program of this package as a person types it."""

from __future__ import annotations

import contextlib
import io
import runpy
import sys
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import pytest

NODES = Path(__file__).resolve().parents[1] / "nodes"


@dataclass(frozen=True)
class Done:
    returncode: object
    stdout: str
    stderr: str


def run(program: str, *words: str | Path) -> Done:
    """The program itself, in this process: a new one takes a second to start."""
    line = [str(NODES / program), *map(str, words)]
    out, err = io.StringIO(), io.StringIO()
    with (
        mock.patch.object(sys, "argv", line),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        pytest.raises(SystemExit) as end,
    ):
        runpy.run_path(line[0], run_name="__main__")
    return Done(end.value.code, out.getvalue(), err.getvalue())
