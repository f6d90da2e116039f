"""The rooms (folders) of a package's production code and the arrows between them, read from includes and imports."""

from __future__ import annotations

import re
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^\s*#include\s+"([\w/]+)\.h"', re.MULTILINE)

Arrows = dict[str, set[str]]  # room -> rooms that it uses
HEADER_ONLY = {"errors": "config"}  # public headers without a source of their name


def declared() -> dict[str, Arrows]:
    """rooms.yaml: package -> room -> rooms that it may use."""
    packages = yaml.safe_load((Path(__file__).parent / "rooms.yaml").read_text())
    return {name: {room: set(uses or []) for room, uses in rooms.items()} for name, rooms in packages.items()}


def python_arrows(package: str) -> Arrows:
    """Of the modules in src/<package>/src/<package>; a module beside the rooms is a room by itself."""
    top = ROOT / "src" / package / "src" / package
    pattern = re.compile(rf"^\s*(?:from|import)\s+{package}((?:\.\w+)*)(?:\s+import\s+([\w, ]+))?", re.MULTILINE)
    arrows: Arrows = {}
    for path in sorted(top.rglob("*.py")):
        if path == top / "__init__.py":
            continue
        room = _module_room(path, top)
        arrows.setdefault(room, set())
        for dotted, names in pattern.findall(path.read_text()):
            parts = dotted.split(".")[1:]
            modules = [parts] if _is_module(top, parts) else [[*parts, name.strip()] for name in names.split(",")]
            arrows[room].update(_module_room(_file(top, module), top) for module in modules if module)
    return _without_loops(arrows)


def cpp_arrows(package: str) -> Arrows:
    """Of the files in src/<package>/src; a public header belongs to the room of the source of its name."""
    top = ROOT / "src" / package / "src"
    sources = [*sorted(top.rglob("*.cpp")), *sorted(top.rglob("*.h"))]
    public = sorted((top.parent / "include" / package).glob("*.h"))
    home = HEADER_ONLY | {path.stem: _room(path.parent, top) for path in sources}
    arrows: Arrows = {}
    for path in [*sources, *public]:
        room = home[path.stem] if path in public else _room(path.parent, top)
        arrows.setdefault(room, set())
        for name in INCLUDE.findall(path.read_text()):
            target = _included_room(name, package, home, path, top)
            if target is not None:
                arrows[room].add(target)
    return _without_loops(arrows)


def _included_room(name: str, package: str, home: dict[str, str], path: Path, top: Path) -> str | None:
    folder, _, stem = name.rpartition("/")
    if folder == package:
        return home[stem]
    if folder:
        return folder if (top / folder).is_dir() else None  # else a header of another package
    return _room(path.parent, top) if (path.parent / f"{stem}.h").exists() else None


def levels(arrows: Arrows) -> dict[str, int]:
    """1 for a room that uses none, else one more than the highest that it uses. Raises AssertionError on a circle."""
    result: dict[str, int] = {}

    def level(room: str, above: tuple[str, ...]) -> int:
        assert room not in above, f"a circle of rooms: {' -> '.join([*above, room])}"
        if room not in result:
            result[room] = 1 + max((level(used, (*above, room)) for used in sorted(arrows[room])), default=0)
        return result[room]

    for room in arrows:
        level(room, ())
    return result


def _room(folder: Path, top: Path) -> str:
    return folder.relative_to(top).as_posix()


def _module_room(path: Path, top: Path) -> str:
    return path.stem if path.parent == top else _room(path.parent, top)


def _file(top: Path, parts: list[str]) -> Path:
    """The module's file; of a package its __init__."""
    place = top.joinpath(*parts)
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def _is_module(top: Path, parts: list[str]) -> bool:
    return bool(parts) and top.joinpath(*parts).with_suffix(".py").is_file()


def _without_loops(arrows: Arrows) -> Arrows:
    return {room: used - {room} for room, used in arrows.items()}
