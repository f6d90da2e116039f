"""An interrupted run continues where it was, and never with results of other code or other inputs."""

import os
import signal
from pathlib import Path

import pytest

from seater_eval.run.long_run import run_long
from seater_eval.run.parallel import run_jobs
from seater_eval.run.partial import PartialResults, fingerprint

CALLS: list[int] = []


def square(number: int) -> int:
    CALLS.append(number)
    if number == 3 and CALLS.count(3) == 1:
        raise KeyboardInterrupt
    return number * number


def test_an_interrupted_run_continues(tmp_path: Path) -> None:
    path, jobs = tmp_path / "run.partial", [0, 1, 2, 3, 4]
    CALLS.clear()
    with pytest.raises(KeyboardInterrupt):
        run_jobs(square, jobs, workers=1, keep=PartialResults(path, "key"))
    assert path.exists()
    assert run_jobs(square, jobs, workers=1, keep=PartialResults(path, "key")) == [0, 1, 4, 9, 16]
    assert CALLS == [0, 1, 2, 3, 3, 4]
    assert not path.exists()


def test_another_key_begins_anew(tmp_path: Path) -> None:
    first = PartialResults(tmp_path / "p", "one")
    first.add(0, "old")
    first.close(finished=False)
    assert PartialResults(tmp_path / "p", "one").done == {0: "old"}
    assert PartialResults(tmp_path / "p", "two").done == {}
    assert PartialResults(tmp_path / "p", "one").done == {}


@pytest.mark.parametrize("cut", [1, 5])
def test_an_entry_cut_off_in_the_middle_is_dropped(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "p"
    first = PartialResults(path, "one")
    first.add(0, "whole")
    first.add(1, "cut off")
    first.close(finished=False)
    path.write_bytes(path.read_bytes()[:-cut])
    second = PartialResults(path, "one")
    assert second.done == {0: "whole"}
    second.add(2, "later")
    second.close(finished=False)
    assert PartialResults(path, "one").done == {0: "whole", 2: "later"}


def test_a_file_that_is_no_pickle_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "p"
    path.write_bytes(b"not a pickle at all")
    assert PartialResults(path, "one").done == {}


def test_the_fingerprint_depends_on_inputs_and_files(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("x: 1")
    one = fingerprint([1], [file])
    assert one == fingerprint([1], [file])
    assert one != fingerprint([2], [file])
    file.write_text("x: 2")
    assert one != fingerprint([1], [file])


def end_once(job: tuple[int, str]) -> int:
    """Job 2 asks this process to end, the first time."""
    number, folder = job
    mark = Path(folder) / f"ran_{number}"
    if number == 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGTERM)
    mark.touch()
    return 10 * number


def test_an_interrupted_command_says_how_far_it_came(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    partial, jobs = tmp_path / "some.partial", [(number, str(tmp_path)) for number in range(4)]
    with pytest.raises(SystemExit) as ended:
        run_long(end_once, jobs, label="some", files=[], partial=partial, workers=1)
    assert ended.value.code == 130
    assert f"2 of 4 parts are kept in {partial}" in capsys.readouterr().out
    (tmp_path / "ran_0").unlink()
    assert run_long(end_once, jobs, label="some", files=[], partial=partial, workers=1) == [0, 10, 20, 30]
    assert not (tmp_path / "ran_0").exists()  # its result was kept
    assert not partial.exists()


def test_a_longer_run_of_the_same_inputs_uses_what_is_kept(tmp_path: Path) -> None:
    partial, jobs = tmp_path / "some.partial", [(number, str(tmp_path)) for number in range(4)]
    for wanted in (3, 4):  # the first one is interrupted after two jobs
        try:
            results = run_long(end_once, jobs[:wanted], label="", files=[], partial=partial, inputs="same", workers=1)
        except SystemExit:
            (tmp_path / "ran_0").unlink()
    assert results == [0, 10, 20, 30] and not (tmp_path / "ran_0").exists()
