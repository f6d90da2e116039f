"""From the measured bar to the sizes in a copy of the dock file."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import yaml
from printed import DEFAULT_DOCK

from seater_common.files.whole import write_whole
from seater_common.params import ParameterError
from seater_tools.correct.scale import printed_scale, reading_error
from seater_tools.correct.sizes import with_printed_sizes
from seater_tools.sheets.layout.paper import PAPERS

A4, A3 = PAPERS["a4"], PAPERS["a3"]


def test_bars_are_as_long_as_fits() -> None:
    assert (A4.bar, A3.bar) == (190.0, 270.0)


def test_the_scale_is_measured_over_wanted() -> None:
    assert printed_scale([190.0], A4) == 1.0
    assert printed_scale([188.1], A4) == pytest.approx(0.99)
    assert printed_scale([275.4], A3) == pytest.approx(1.02)
    assert printed_scale([189.0, 189.5], A4) == pytest.approx(math.sqrt(189.0 * 189.5) / 190.0)
    assert reading_error(A4) == pytest.approx(0.0013, abs=1e-4)


@pytest.mark.parametrize("measured", [151.9, 237.6, 19.0, 0.0, -190.0, math.nan, math.inf])
def test_nonsense_is_refused(measured: float) -> None:
    with pytest.raises(ParameterError, match=r"--measured-bar: is .* mm, must be 152 to 237\.5 mm \(80 to 125 %"):
        printed_scale([measured], A4)


def test_the_limits_are_allowed() -> None:
    assert printed_scale([152.0], A4) == pytest.approx(0.8)
    assert printed_scale([237.5], A4) == pytest.approx(1.25)


def test_a_stretched_print_is_refused() -> None:
    """No number is its size."""
    assert printed_scale([190.0, 190.9], A4) == pytest.approx(1.00237, abs=1e-5)
    for bars in ([190.0, 191.1], [191.1, 190.0]):
        with pytest.raises(ParameterError, match=r"--measured-bar: is .* and .* mm: stretched by 0\.6 % one way"):
            printed_scale(bars, A4)


def test_only_the_sizes_change() -> None:
    text = DEFAULT_DOCK.read_text()
    new = with_printed_sizes(text, 0.99, "default.yaml", "99 %")
    first, _, rest = new.partition("\n")
    assert first == "# Sizes of the markers as printed: 99 %"
    changed = [(a, b) for a, b in zip(text.split("\n"), rest.split("\n"), strict=True) if a != b]
    assert [(a.replace("0.100", "0.099").replace("0.150", "0.1485")) for a, _ in changed] == [b for _, b in changed]
    values, wanted = yaml.safe_load(new), yaml.safe_load(text)
    assert [marker.pop("size") for marker in values["markers"]] == [0.099, 0.1485, 0.1485]
    assert [marker.pop("size") for marker in wanted["markers"]] == [0.1, 0.15, 0.15]
    assert values == wanted


def test_other_ways_to_write_a_list() -> None:
    text = (
        "markers:\n- id: 0\n  size: 0.2       # [m] black\n- {size: &s .1, id: 1}\n- {id: 2, size: *s}\nname: size: x\n"
    )
    text = text.replace("name: size: x", 'name: "size: 0.2"')
    new = with_printed_sizes(text, 0.99, "f", "x").partition("\n")[2]
    assert new == (
        "markers:\n- id: 0\n  size: 0.198     # [m] black\n- {size: &s 0.099, id: 1}\n- {id: 2, size: *s}\n"
        'name: "size: 0.2"\n'
    )


def test_a_size_is_written_to_a_hundredth_of_a_millimetre() -> None:
    new = with_printed_sizes("markers: [{size: 0.1}, {size: 1}]\n", 0.991234, "f", "x")
    assert new.endswith("\nmarkers: [{size: 0.09912}, {size: 0.99123}]\n")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("markers: [{size: 0.1}, {id: 1}]", r"f/markers\[1\]/size: is not written there"),
        ("name: x", r"f/markers: is not written there"),
        ("a: &a {size: 0.1}\nmarkers: [{size: 0.2}, {<<: *a}]", r"f/markers\[1\]/size: is not written there"),
        ("a: &s 0.1\nmarkers: [{size: *s}]", r"f/markers: sizes cannot be replaced one by one"),
        ("markers: [", r"cannot edit f"),
    ],
)
def test_what_cannot_be_replaced_is_said(text: str, problem: str) -> None:
    with pytest.raises(ParameterError, match=problem):
        with_printed_sizes(text, 0.99, "f", "x")


def test_a_copy_is_not_corrected_again() -> None:
    once = with_printed_sizes("markers: [{size: 0.1}]\n", 0.99, "f", "99 %")
    with pytest.raises(ParameterError, match="f: its sizes are corrected for a print"):
        with_printed_sizes(once, 0.99, "f", "99 %")


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "new" / "dock.yaml"
    write_whole(path, b"first", overwrite=False)
    with pytest.raises(FileExistsError, match=r"dock\.yaml exists already; --force overwrites it"):
        write_whole(path, b"second", overwrite=False)
    assert path.read_bytes() == b"first"

    def fail(_: int) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("os.fsync", fail)
    with pytest.raises(OSError, match="disk full"):
        write_whole(path, b"third", overwrite=True)
    assert path.read_bytes() == b"first"
    assert [file.name for file in path.parent.iterdir()] == ["dock.yaml"]
    monkeypatch.undo()
    write_whole(path, b"fourth", overwrite=True)
    assert path.read_bytes() == b"fourth"
