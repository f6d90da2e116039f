"""Files may lie in folders with blanks in their names: roslaunch splits `args` as a shell does."""

import re
import shlex
from pathlib import Path

import pytest

LAUNCH = sorted((Path(__file__).resolve().parents[1] / "launch").glob("*.launch"))
PATHS = r"\$\((?:arg (?:\w+_file|bag|output|results|installation)|find \w+)\)"


@pytest.mark.parametrize("path", LAUNCH, ids=lambda path: path.stem)
def test_a_file_stays_one_word(path: Path) -> None:
    for args in re.findall(r"""\bargs="([^"]*)\"""", path.read_text()):
        words = shlex.split(re.sub(PATHS, "/a folder/file", args))
        assert not [word for word in words if word == "/a" or word.startswith("folder/")], args
