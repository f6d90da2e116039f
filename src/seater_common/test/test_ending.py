"""Whatever stops a command: an exit status, and one line that a person understands."""

import argparse
import os
import signal
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
