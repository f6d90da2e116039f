"""Whatever a package imports, its package.xml or tools/requirements.txt names; every manifest says who made it."""

import ast
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MANIFESTS = sorted(p for folder in ("src/*", "config", "test") for p in ROOT.glob(f"{folder}/package.xml"))
# Modules whose dependency has another name than they.
DEBIAN = {name: f"python3-{name}" for name in ("numpy", "scipy", "yaml", "matplotlib", "rospkg", "tqdm", "tabulate")}
DEBIAN |= {"cv2": "python3-opencv", "mpl_toolkits": "python3-matplotlib", "reportlab": "python3-reportlab"}
DEBIAN |= {"aiohttp": "python3-aiohttp", "prometheus_client": "python3-prometheus-client"}
DEBIAN |= {"evdev": "python3-evdev", "gpiod": "python3-libgpiod"}


def manifest(path: Path) -> ElementTree.Element:
    return ElementTree.parse(path).getroot()


def pinned() -> set[str]:
    """Packages of tools/requirements.txt, as modules."""
    lines = (ROOT / "tools" / "requirements.txt").read_text().splitlines()
    names = [match[1] for line in lines if (match := re.match(r"([\w-]+)==", line))]
    return {name.replace("-", "_") for name in names}


def imports(package: Path) -> dict[str, Path]:
    """Top-level modules that production code imports, each with a file that does."""
    found: dict[str, Path] = {}
    programs = [*package.glob("nodes/**/*"), *(f for f in package.glob("evaluation/*") if f.suffix == "")]
    files = [*package.glob("src/**/*.py"), *(f for f in programs if f.is_file())]
    for path in files:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0]: path for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                found[node.module.split(".")[0]] = path
    return found


@pytest.mark.parametrize("path", MANIFESTS, ids=lambda p: p.parent.name)
def test_runtime_dependencies_are_named(path: Path) -> None:
    root = manifest(path)
    tags = ("depend", "exec_depend", *(("test_depend",) if path.parent.name == "test" else ()))
    named = {e.text for tag in tags for e in root.iter(tag)}
    own = {root.findtext("name")}
    for module, file in imports(path.parent).items():
        if module in sys.stdlib_module_names or module in own or module in pinned():
            continue
        assert DEBIAN.get(module, module) in named, f"{file.relative_to(ROOT)} imports {module}"


@pytest.mark.parametrize("path", MANIFESTS, ids=lambda p: p.parent.name)
def test_manifests_are_complete(path: Path) -> None:
    root = manifest(path)
    for tag in ("name", "version", "description", "maintainer", "author", "license"):
        assert (root.findtext(tag) or "").strip(), tag
    assert re.fullmatch(r"[^@\s]+@[^@\s]+\.\w+", root.find("maintainer").get("email"))  # type: ignore[union-attr]


def test_manifests_have_one_version() -> None:
    assert len({manifest(path).findtext("version") for path in MANIFESTS}) == 1
