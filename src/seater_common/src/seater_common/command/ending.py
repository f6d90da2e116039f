"""How a command ends: with its exit status, or with one line that says what stopped it."""

from __future__ import annotations

import argparse
import contextlib
import errno
import io
import os
import sys
from collections.abc import Callable
from pathlib import Path

from seater_common.params import ParameterError, why

WRONG_INPUT = 2
INTERRUPTED = 130  # as in shells: 128 and the number of SIGINT
UNREAD = 141  # the same of SIGPIPE


def ended(
    program: str, work: Callable[[], int], wrong: tuple[type[Exception], ...] = (), unwritten: int = WRONG_INPUT
) -> int:
    """Exit status of `work`. Where it cannot go on, the cause on stderr, and 2 for wrong input (ParameterError and
    what is `wrong` for this command, too), `unwritten` for a file that cannot be read or written, 130 for Ctrl-C. 141
    and no word where nobody reads on, as behind `| head`."""
    wrong_input: tuple[type[Exception], ...] = (ParameterError, *wrong)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal that has no tick shows a question mark
    try:
        status = work()
        sys.stdout.flush()  # at Python's own end it would be too late to say anything
        return status
    except BrokenPipeError:
        _drop_output()
        return UNREAD
    except wrong_input as error:
        text, status = str(error), WRONG_INPUT
    except OSError as error:
        text, status = in_words(error), unwritten
        if error.errno == errno.ENOSPC:
            _drop_output()
    except KeyboardInterrupt:
        text, status = "interrupted", INTERRUPTED
        print(file=sys.stderr)  # what it has shown of its progress may have no end of line
    print(f"{program}: {text}", file=sys.stderr)
    return status


def _drop_output() -> None:
    """What is still to be written to stdout: Python would complain of it at its end."""
    with contextlib.suppress(OSError, ValueError):  # no file behind it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def in_words(error: OSError) -> str:
    """File and cause, without the number."""
    if error.filename is None or not error.strerror:
        return why(error)
    if isinstance(error, FileExistsError | NotADirectoryError):  # a folder was to be made
        return f"{error.filename}: is no folder, and none can be made there"
    return f"{error.filename}: {why(error)}"


def results_folder(text: str) -> Path:
    """For argparse: where a folder is, or can be made, before hours of work are done for it."""
    folder = Path(text)
    there = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        raise argparse.ArgumentTypeError(f"{text}: {there} is no folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise argparse.ArgumentTypeError(f"{text}: {there} must not be written to by this user")
    return folder
