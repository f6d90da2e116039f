"""One folder for all commands: what is missing begins as a copy, what is new keeps the old beside it, and what has been
done stands in the files."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from seater_common.files.installation import SHIPPED, Installation, add_option, conclude, use


@pytest.fixture
def installation(tmp_path: Path) -> Installation:
    sources = {}
    for role in SHIPPED:
        sources[role] = tmp_path / "config" / f"shipped_{role}.yaml"
        sources[role].parent.mkdir(exist_ok=True)
        sources[role].write_text(f"role: {role}\n")
    made = Installation(tmp_path / "my chair")
    assert made.missing == list(SHIPPED)
    assert len(made.create(sources)) == 3 and made.create(sources) == []
    return made


def test_the_next_step_is_named_as_it_is_typed(installation: Installation, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SEATER_COMMAND", raising=False)
    assert installation.next().startswith("./seater sheets ")
    monkeypatch.setenv("SEATER_COMMAND", "seater")
    assert installation.next().startswith("seater sheets ")


def put(installation: Installation, role: str, text: str) -> list[str]:
    new = installation.folder / "work" / "new.yaml"
    new.parent.mkdir(exist_ok=True)
    new.write_text(text)
    return installation.take({role: new})


def test_the_next_step_follows_from_the_files(installation: Installation) -> None:
    assert "seater sheets" in installation.next()
    (installation.folder / "sheets").mkdir()
    (installation.folder / "sheets" / "dock_a4.pdf").touch()
    assert "seater calibrate camera" in installation.next()
    put(installation, "camera", "# Lens calibrated: today\n")
    assert "seater calibrate mount" in installation.next()
    put(installation, "chair", "# Camera calibrated: today\nrole: chair\n")
    assert "identify.launch" in installation.next()
    put(installation, "controller", "# Identified: today\nrole: controller\n")
    assert "teach.launch" in installation.next()
    put(installation, "dock", "# Sizes\n# Taught: today\nrole: dock\n")
    assert "seater doctor" in installation.next() and all(installation.done().values())
    assert f"'{installation.folder}'" in installation.next()  # the folder's name has a space


def test_a_camera_that_brings_its_calibration_needs_none(installation: Installation) -> None:
    (installation.folder / "sheets").mkdir()
    (installation.folder / "sheets" / "dock_a4.pdf").touch()
    put(installation, "chair", "# Camera calibrated: today\n")
    assert "identify.launch" in installation.next()


def test_another_lens_asks_for_the_mount_again(installation: Installation) -> None:
    (installation.folder / "sheets").mkdir()
    (installation.folder / "sheets" / "dock_a4.pdf").touch()
    assert len(put(installation, "camera", "# Lens calibrated: today\n")) == 1
    put(installation, "chair", "# Camera calibrated: today\nrole: chair\n")
    for old in installation.folder.glob("*.yaml.2*"):  # twice within a second, the second would be refused
        old.unlink()
    assert "calibrate the mount again" in put(installation, "camera", "# Lens calibrated: tomorrow\n")[1]
    assert installation.file("chair").read_text() == "role: chair\n"
    assert "seater calibrate mount" in installation.next()


def test_a_lens_that_comes_with_its_mount_asks_for_none(installation: Installation, tmp_path: Path) -> None:
    new = {role: tmp_path / f"new_{role}.yaml" for role in ("camera", "chair")}
    new["camera"].write_text("# Lens calibrated: today\n")
    new["chair"].write_text("# Camera calibrated: today\n")
    installation.take(new)
    assert installation.done()["lens calibrated"] and installation.done()["mount calibrated"]


def test_the_old_file_is_kept(installation: Installation) -> None:
    (line,) = put(installation, "chair", "role: new\n")
    assert installation.file("chair").read_text() == "role: new\n"
    (kept,) = installation.folder.glob("chair.yaml.2*")
    assert kept.read_text() == "role: chair\n" and kept.name in line


def parsed(*words: str | Path) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("--dock", default="shipped")
    parser.add_argument("--camera")
    parser.add_argument("--results", type=Path, default=Path("results/x"))
    parser.add_argument("--force", action="store_true")
    add_option(parser)
    options = parser.parse_args(list(map(str, words)))
    use(options, parser, {"dock": "dock", "camera": "camera"}, "x")
    return options


def test_options_that_are_not_given_are_those_of_the_folder(installation: Installation) -> None:
    folder = installation.folder
    assert vars(parsed())["dock"] == "shipped"
    options = parsed("--installation", folder)
    assert options.dock == folder / "dock.yaml" and options.results == folder / "x" and options.force
    assert options.camera is None  # there is none yet
    assert parsed("--installation", folder, "--dock", "mine").dock == "mine"
    put(installation, "camera", "a")
    assert parsed("--installation", folder).camera == folder / "camera.yaml"


def test_a_folder_without_its_files_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        parsed("--installation", tmp_path)
    assert end.value.code == 2
    assert f"has no chair.yaml; ./seater installation {tmp_path} makes" in capsys.readouterr().err


def test_a_command_ends_with_what_comes_next(installation: Installation, capsys: pytest.CaptureFixture[str]) -> None:
    new = installation.folder / "new.yaml"
    new.write_text("# Taught: now\n")
    conclude(parsed(), {"dock": new})
    assert capsys.readouterr().out == "" and not list(installation.folder.glob("dock.yaml.2*"))
    conclude(parsed("--installation", installation.folder), {"dock": new})
    assert "dock.yaml is new; the one before is kept as dock.yaml.2" in (out := capsys.readouterr().out)
    assert out.rpartition("\n\n")[2].startswith("Next: ./seater sheets")


def test_commands_that_follow_each_other_within_a_second_both_keep_the_old_file(installation: Installation) -> None:
    """A quick machine goes from `calibrate mount` to `teach` so; the second one was refused."""
    for text in ("first\n", "second\n"):
        put(installation, "dock", text)
    kept = sorted(path.read_text() for path in installation.folder.glob("dock.yaml.*"))
    assert kept == ["first\n", "role: dock\n"] and installation.file("dock").read_text() == "second\n"
