"""A new file in the place of an old one, which stays."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest

from seater_common.files.whole import replace_kept

NOW = datetime.datetime(2026, 11, 27, 16, 5, 9, tzinfo=datetime.UTC)


def test_the_old_file_is_kept(tmp_path: Path) -> None:
    target = tmp_path / "dock.yaml"
    assert replace_kept("first", target, NOW) == [target]
    old = tmp_path / "dock.yaml.20261127T160509Z"
    assert replace_kept("second", target, NOW) == [target, old]
    assert target.read_text() == "second" and old.read_text() == "first"
    with pytest.raises(FileExistsError):  # twice in a second: the file kept is not overwritten
        replace_kept("third", target, NOW)
    assert target.read_text() == "second" and old.read_text() == "first"
