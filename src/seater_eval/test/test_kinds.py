"""Drawn kinds of cameras: where their pixels are, what they shift, and what the bars make of what was found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from seater_eval.kinds import cameras, evaluate
from seater_eval.kinds.cameras import KINDS, OPTICS, photograph
from seater_eval.kinds.evaluate import DICTIONARIES, KindJob, look, scene
from seater_eval.kinds.report import describe_kinds, draw_kinds, kind_bars
from seater_eval.perception.images.render import corners_of
from seater_eval.photographs.detectors import OPENCV, SEATER, Found
from seater_eval.photographs.evaluate import read_parameters
from seater_eval.photographs.measures import match

CONFIG = Path(__file__).resolve().parents[3] / "config"
PARAMETERS = read_parameters(CONFIG)


def job(kind: str, side: float = 40.0, shift: float = 0.0, seed: int = 3) -> KindJob:
    return KindJob(kind, shift, DICTIONARIES[0], side, seed, PARAMETERS)


@pytest.mark.parametrize("kind", ["ideal", pytest.param("aliased", marks=pytest.mark.extensive)])
def test_prints_are_drawn_where_they_are(kind: str) -> None:
    """By OpenCV's corners, and in pixels whose centres are whole numbers: half a pixel would show."""
    prints, random = scene(job(kind, 60.0))
    image = photograph(prints, kind, 0.0, random)
    settings = cv2.aruco.DetectorParameters_create()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    corners, ids, _ = cv2.aruco.detectMarkers(
        image, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), parameters=settings
    )
    truth = {p.id: corners_of(p, OPTICS.K) for p in prints}
    assert ids is not None and set(ids.ravel()) == set(truth)
    off = np.concatenate([c.reshape(4, 2) - truth[int(i)] for c, i in zip(corners, ids.ravel(), strict=True)])
    assert np.abs(off.mean(axis=0)).max() < 0.1 and np.abs(off).max() < 1.0


def test_sides_and_tilts_are_those_asked_for() -> None:
    prints, _ = scene(job("ideal", 40.0))
    assert len({p.id for p in prints}) == 12
    for p in prints:
        sight = p.pose[:3, 3] / np.linalg.norm(p.pose[:3, 3])
        tilt = np.degrees(np.arccos(-p.pose[:3, 2] @ sight))
        assert 7.9 < tilt < 45.1 and np.linalg.det(p.pose[:3, :3]) == pytest.approx(1.0)
        corners = corners_of(p, OPTICS.K)
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
        assert sides.min() > 40.0 * 0.85 * 0.6 and sides.max() < 40.0 * 1.15 * 1.4


def test_shifts_are_smooth_and_as_large_as_asked_for() -> None:
    """A ramp of grey levels shows them along one axis."""
    ramp, shown = np.tile(np.arange(640, dtype=np.float32) / 4.0, (480, 1)), []
    for seed in range(6):
        moved = cameras._shifted(ramp, 0.3, np.random.default_rng(seed))
        x = 4.0 * (moved - ramp)[20:-20, 20:-20]
        shown.append(float(x.std()))
        assert float(np.abs(np.diff(x, axis=1)).max()) < 0.3  # from pixel to pixel; 1.7 without correlation
    assert np.mean(shown) == pytest.approx(0.3, rel=0.1)


# Each takes a second or two; the rest is drawn and looked at the same way.
@pytest.mark.parametrize(
    "kind", [k if k in ("webcam", "over-exposed") else pytest.param(k, marks=pytest.mark.extensive) for k in KINDS]
)
def test_each_kind_is_found_with_poses_that_their_covariances_cover(kind: str) -> None:
    seen = look(job(kind, 40.0))
    assert seen.found[SEATER] >= 11 and seen.false[SEATER] == 0
    assert np.mean(seen.errors) < 12.0 and seen.wrong == 0


def test_what_is_elsewhere_or_not_there_is_false() -> None:
    prints, _ = scene(job("ideal"))
    here = corners_of(prints[0], OPTICS.K)
    places = [(prints[0].id, here + 30.0), (prints[0].id, here), (prints[0].id, here), (77, here)]
    finds = [Found(id=i, corners=corners) for i, corners in places]
    matched = match(evaluate._known(job("ideal"), prints)[0], finds)
    assert list(matched.found.values()) == [finds[1]] and len(matched.false) == 3


def rows(found: dict[str, int], errors: float = 6.0, wrong: int = 0, broken: int = 0, **changes: int) -> dict[str, Any]:
    made = []
    for kind in KINDS:
        detectors = {
            name: {"markers": 100, "found": n, "found_by_seater": found[SEATER], "false": 0}
            for name, n in found.items()
        }
        detectors[SEATER]["found"] = detectors[SEATER]["found_by_seater"] = changes.get(kind, found[SEATER])
        made.append(
            {
                "kind": kind,
                "shift_px": 0.0,
                "detectors": detectors,
                "normalised_error_squared": errors,
                "certain": 1000,
                "wrong_and_certain": wrong,
                "branches": {"corners_decided": 90, "broken": broken, "open": 2, "corners_wrong": 3, "mended": 2},
            }
        )
    return {"images": 1, "seed": 1, "ours_only": False, "rows": made}


def met(data: dict[str, Any]) -> dict[str, bool]:
    return {bar.name: bar.met for bar in kind_bars(data)}


def test_bars_of_what_was_found() -> None:
    good = rows({SEATER: 99, OPENCV: 95})
    assert all(met(good).values())
    assert not met(rows({SEATER: 94, OPENCV: 95}))["found, fewer than by another detector, worst kind"]
    assert not met(rows({SEATER: 99, OPENCV: 95}, errors=9.1))["mean normalised error squared / 6, largest cell"]
    assert not met(rows({SEATER: 99, OPENCV: 95}, errors=3.9))["mean normalised error squared / 6, smallest cell"]
    assert not met(rows({SEATER: 99, OPENCV: 95}, wrong=1))["wrong branch called certain"]
    assert not met(rows({SEATER: 99, OPENCV: 95}, **{"over-exposed": 93}))["found, over-exposed fewer than ideal"]
    assert not met(rows({SEATER: 99, OPENCV: 95}, broken=1))["branches that the photometric stage breaks"]
    assert "over-exposed" in describe_kinds(good)


def test_table_says_what_the_number_of_branches_proves() -> None:
    """9 kinds of 1000: 0 wrong prove 1 in 3005 (1 - 0.05^(1 / 9000)), 9 wrong 1 in 573 (Clopper and Pearson)."""
    assert "0 of 9000 branches called certain are wrong: more than 1 in 3005 " in describe_kinds(rows({SEATER: 99}))
    assert "9 of 9000 branches called certain are wrong: more than 1 in 573 " in describe_kinds(
        rows({SEATER: 99}, wrong=1)
    )


@pytest.mark.extensive
def test_the_picture_shows_each_kind(tmp_path: Path) -> None:
    assert draw_kinds(rows({SEATER: 99, OPENCV: 95}), tmp_path / "a.png").stat().st_size > 20_000


def test_wrong_parameters_are_named() -> None:
    with pytest.raises(ValueError, match="no_such_key"):
        evaluate.run_kinds({**PARAMETERS, "no_such_key": 1}, 1, 1, workers=1)


def test_ours_only_goes_on_where_it_was_interrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All kinds and shifts of one scene, drawn once for each blur; what is kept is not looked at again."""
    drawn: list[float | None] = []
    behind_lens = cameras.behind_lens

    def counted(prints: list[Any], blur: float | None) -> Any:
        drawn.append(blur)
        if len(drawn) > 4:
            raise KeyboardInterrupt
        return behind_lens(prints[:2], blur)

    monkeypatch.setattr(evaluate, "behind_lens", counted)
    monkeypatch.setattr(evaluate, "DICTIONARIES", DICTIONARIES[:1])
    monkeypatch.setattr(evaluate, "SIDES", (30.0, 40.0))

    def run() -> dict[str, Any]:
        return evaluate.run_kinds(PARAMETERS, 1, 5, workers=1, ours_only=True, partial=tmp_path / "kept")

    with pytest.raises(SystemExit):
        run()
    assert drawn[:4] == [0.7, None, 0.6, 0.8]
    drawn[:] = drawn[5:]
    data = run()
    assert len(drawn) == 4  # the second scene's
    assert [(row["kind"], row["shift_px"]) for row in data["rows"]] == [(k, s) for k in KINDS for s in evaluate.SHIFTS]
    for row in data["rows"]:
        assert list(row["detectors"]) == [SEATER] and row["detectors"][SEATER]["markers"] == 24
        assert row["detectors"][SEATER]["found"] <= 4
    assert sum(row["detectors"][SEATER]["found"] for row in data["rows"]) > 120
    assert "found, fewer than by another detector, worst kind" not in met(data)
