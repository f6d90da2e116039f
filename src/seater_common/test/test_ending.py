"""Whatever stops a command: an exit status, and one line that a person understands."""

import argparse
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from seater_common.command.ending import ended, results_folder
from seater_common.params import ParameterError


class MineError(ValueError):
    pass


def _raising(error: BaseException) -> object:
    def work() -> int:
        raise error

    return work


@pytest.mark.parametrize(
    ("error", "status"),
    [(ParameterError("x: is 1, must be 2"), 2), (MineError("x: is 1, must be 2"), 2), (OSError("x: is 1"), 1)],
)
def test_what_is_wrong_is_one_line_after_the_name_of_the_command(
    error: Exception, status: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended("seater x", _raising(error), (MineError,), unwritten=1) == status  # type: ignore[arg-type]
    assert capsys.readouterr().err == f"seater x: {error}\n"


def test_an_unexpected_error_is_not_hidden() -> None:
    with pytest.raises(ZeroDivisionError):
        ended("seater x", lambda: 1 // 0)


def test_ctrl_c_ends_with_130_and_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    def work() -> int:
        os.kill(os.getpid(), signal.SIGINT)
        return 0

    assert ended("seater x", work) == 130
    assert capsys.readouterr().err.endswith("seater x: interrupted\n")


@pytest.mark.parametrize(
    ("reader", "status", "words"),
    [("/dev/full", 2, b"x: no space left on device\n"), (None, 141, b"")],
    ids=["disk full", "nobody reads on"],
)
def test_output_that_cannot_be_written(reader: str | None, status: int, words: bytes) -> None:
    """Of a small output, which Python writes at its end."""
    line = "from seater_common.command.ending import ended; raise SystemExit(ended('x', lambda: print('text') or 0))"
    if reader:
        out = os.open(reader, os.O_WRONLY)
    else:
        read, out = os.pipe()
        os.close(read)
    done = subprocess.run([sys.executable, "-c", line], stdout=out, stderr=subprocess.PIPE)
    os.close(out)
    assert (done.returncode, done.stderr) == (status, words)


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_terminal_without_ticks_shows_the_rest(encoding: str) -> None:
    work = "print('\u2718 odom') or 0"
    line = f"from seater_common.command.ending import ended; raise SystemExit(ended('x', lambda: {work}))"
    words, environment = [sys.executable, "-c", line], os.environ | {"PYTHONIOENCODING": encoding}
    done = subprocess.run(words, env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "? odom\n", "")


def test_ctrl_c_while_a_program_imports_shows_no_line_of_python(tmp_path: Path) -> None:
    program = tmp_path / "program"
    begin = "import seater_common.command.interrupt\nimport os, signal\n"
    program.write_text(begin + "os.kill(os.getpid(), signal.SIGINT)\nimport numpy\n")
    done = subprocess.run([sys.executable, program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "\nprogram: interrupted\n")


def test_ctrl_c_in_casadi_which_drops_what_is_raised_waits_until_it_is_out(tmp_path: Path) -> None:
    library, program = tmp_path / "casadi" / "library.py", tmp_path / "program"
    library.parent.mkdir()
    (library.parent / "__init__.py").write_text("")
    library.write_text(
        "import os, signal\n"
        "def solve():\n"
        "    try:\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "    except BaseException:\n"
        "        pass\n"
    )
    begin = "import seater_common.command.interrupt\nimport time\nfrom casadi.library import solve\n"
    program.write_text(f"{begin}solve()\ntime.sleep(10.0)\n")
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=5.0)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "\nprogram: interrupted\n")


def test_any_other_error_of_an_import_is_shown_in_full() -> None:
    line = "import seater_common.command.interrupt; import no_such_module"
    done = subprocess.run([sys.executable, "-c", line], capture_output=True, text=True)
    assert done.returncode == 1 and "Traceback" in done.stderr and "no_such_module" in done.stderr


def test_the_system_s_errors_are_said_in_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    cases = {
        tmp_path / "missing": (lambda path: path.read_text(), "no such file or directory"),
        tmp_path: (lambda path: path.write_text(""), "is a directory"),
        tmp_path / "file": (lambda path: path.mkdir(), "is no folder, and none can be made there"),
        tmp_path / "file" / "below": (lambda path: path.mkdir(), "is no folder, and none can be made there"),
    }
    for path, (act, words) in cases.items():
        assert ended("seater x", lambda act=act, path=path: act(path)) == 2  # type: ignore[misc]
        assert capsys.readouterr().err == f"seater x: {path}: {words}\n"


def test_a_folder_for_results_is_refused_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    assert results_folder(str(tmp_path / "new" / "deep")) == tmp_path / "new" / "deep"
    assert not (tmp_path / "new").exists()
    for path in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(argparse.ArgumentTypeError, match="file is no folder"):
            results_folder(str(path))
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(argparse.ArgumentTypeError, match="must not be written to"):
        results_folder(str(tmp_path / "new"))
