"""The rooms of each package are those of rooms.yaml (docs draw the same file), and arrows go one way."""

from pathlib import Path

import pytest
from rooms import ROOT, Arrows, cpp_arrows, declared, levels, python_arrows

LARGEST_ROOM = 14  # files
HIGHEST_LEVEL = 12
PUBLIC_HEADERS = 14
PACKAGES = sorted(declared())


def real_arrows(package: str) -> Arrows:
    return cpp_arrows(package) if any((ROOT / "src" / package).glob("include/*/*.h")) else python_arrows(package)


@pytest.mark.parametrize("package", PACKAGES)
def test_arrows_are_the_declared_ones(package: str) -> None:
    real, wanted = real_arrows(package), declared()[package]
    assert {room: sorted(used) for room, used in real.items()} == {room: sorted(used) for room, used in wanted.items()}


@pytest.mark.parametrize("package", PACKAGES)
def test_arrows_go_one_way(package: str) -> None:
    assert max(levels(declared()[package]).values()) <= HIGHEST_LEVEL


def test_a_circle_is_noticed() -> None:
    with pytest.raises(AssertionError, match="circle of rooms: a -> b -> a"):
        levels({"a": {"b"}, "b": {"a"}})


def production_folders() -> list[Path]:
    places = [
        *ROOT.glob("src/*/src"),
        *ROOT.glob("src/*/python"),
        *ROOT.glob("src/*/nodes"),
        *ROOT.glob("src/*/launch"),
    ]
    places += [*ROOT.glob("src/*/include/*")]
    folders = {f for place in places for f in [place, *place.rglob("*")] if f.is_dir()}
    return sorted(f for f in folders if f.name != "__pycache__")


@pytest.mark.parametrize("folder", production_folders(), ids=lambda p: p.relative_to(ROOT).as_posix())
def test_no_folder_is_crowded(folder: Path) -> None:
    files = [f.name for f in folder.iterdir() if f.is_file()]
    assert len(files) <= LARGEST_ROOM, files


@pytest.mark.parametrize("include", sorted(ROOT.glob("src/*/include/*")), ids=lambda p: p.name)
def test_public_headers_are_few(include: Path) -> None:
    assert len(list(include.glob("*.h"))) <= PUBLIC_HEADERS
