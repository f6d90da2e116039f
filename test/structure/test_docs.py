"""Documents can be walked through: every link leads somewhere, every page is in the index, no line is too long."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted(ROOT.glob("docs/**/*.md"))]
LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
MENTIONED = re.compile(r"\bdocs/[\w/-]+\.md\b")
LONGEST_LINE = 120


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as forges make them."""
    found: list[str] = []
    for title in re.findall(r"^#+ (.*)$", CODE.sub("", page.read_text()), re.MULTILINE):
        name = re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-")
        found.append(name if name not in found else f"{name}-{found.count(name)}")
    return set(found)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for link in LINK.findall(CODE.sub("", page.read_text())):
        if re.match(r"https?:", link):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_lines_are_short(page: Path) -> None:
    assert [line for line in page.read_text().splitlines() if len(line) > LONGEST_LINE] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_run_as_they_are_copied(page: Path) -> None:
    """Not only in a shell that knows ROS: the first word of each is ./seater, or one of the system's."""
    for line in page.read_text().splitlines():
        assert not re.match(r"\s*ros(run|launch|topic|service|test)\s+(-\w|\w+_\w+|echo|pub|call)", line), line


def test_the_index_knows_every_page() -> None:
    index = ROOT / "docs" / "README.md"
    known = {(index.parent / link.partition("#")[0]).resolve() for link in LINK.findall(index.read_text())}
    assert [page for page in PAGES if page not in known and page.parent != ROOT and page != index] == []


def test_pages_that_the_code_mentions_exist() -> None:
    patterns = (
        "src/**/*.py",
        "src/**/*.h",
        "src/**/*.cpp",
        "src/**/*.launch",
        "src/*/nodes/**/*",
        "src/*/evaluation/*",
        "tools/*",
        "config/**/*.yaml",
    )
    files = [path for pattern in patterns for path in sorted(ROOT.glob(pattern)) if path.is_file()]
    missing = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in files
        for name in MENTIONED.findall(path.read_text(errors="replace"))
        if not (ROOT / name).exists()
    }
    assert sorted(missing) == []


@pytest.mark.parametrize("page", ["tutorials/controller_in_ten_lines.md", "how-to/simulate_without_ros.md"])
def test_python_of_the_documents_runs(page: str) -> None:
    program = "\n".join(PYTHON.findall((ROOT / "docs" / page).read_text()))
    run = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


def test_the_ten_lines_of_the_readme_are_those_of_the_tutorial() -> None:
    tutorial = PYTHON.findall((ROOT / "docs" / "tutorials" / "controller_in_ten_lines.md").read_text())
    assert PYTHON.findall((ROOT / "README.md").read_text()) == tutorial[:1]
