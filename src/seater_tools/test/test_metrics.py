"""What Prometheus is told."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

client = pytest.importorskip("prometheus_client")
from seater_tools.metrics.metrics import SOLVES, Metrics  # noqa: E402

STATES = {0: "STOPPED", 5: "EMERGENCY_STOP"}
GUIDE = Path(__file__).resolve().parents[3] / "docs" / "how-to" / "watch_the_dockings.md"


class Told:
    """Metrics with a clock that is set by hand."""

    def __init__(self) -> None:
        self.now, self.registry = 100.0, client.CollectorRegistry()
        self.metrics = Metrics(self.registry, lambda: self.now, STATES)

    def value(self, name: str, **labels: str) -> float:
        value = self.registry.get_sample_value(name, labels)
        assert value is not None, name
        return float(value)


def test_goals_are_counted_by_their_result() -> None:
    told = Told()
    for code in (0, 0, 908):
        told.metrics.docked(code, 15.0, 1, None)
    told.metrics.undocked(0)
    told.metrics.undocked(31337)
    assert told.value("seater_goals_total", action="dock", result="SUCCESS") == 2
    assert told.value("seater_goals_total", action="dock", result="MARKER_LOST") == 1
    assert told.value("seater_goals_total", action="undock", result="31337") == 1
    assert told.value("seater_retries_total") == 3
    assert told.value("seater_docking_seconds_count") == 2 and told.value("seater_docking_seconds_sum") == 30.0


def test_the_error_is_that_of_the_last_docking_that_was_verified() -> None:
    told = Told()
    told.metrics.docked(0, 15.0, 0, (0.001, -0.002, 0.003))
    told.metrics.docked(907, 15.0, 0, None)
    assert told.value("seater_final_error_metres", axis="along") == 0.001
    assert told.value("seater_final_error_metres", axis="across") == -0.002
    assert told.value("seater_final_error_radians") == 0.003


def test_ages_grow_until_the_next_image() -> None:
    told = Told()
    assert math.isnan(told.value("seater_image_age_seconds"))
    told.metrics.image(True)
    told.now = 103.0
    told.metrics.image(False)
    told.now = 104.0
    assert (told.value("seater_image_age_seconds"), told.value("seater_dock_age_seconds")) == (1.0, 4.0)


def test_quantiles_are_of_the_last_solves() -> None:
    told = Told()
    assert math.isnan(told.value("seater_solve_seconds", quantile="0.99"))
    for i in range(3 * SOLVES):
        told.metrics.cycle(0.001 * (1 + i % 100) if i >= SOLVES else 9.0, True, i < 5)
    told.metrics.cycle(9.0, False, False)  # no solve
    assert told.value("seater_solve_seconds", quantile="0.5") == pytest.approx(0.0505)
    assert told.value("seater_solve_seconds", quantile="0.99") == pytest.approx(0.099, abs=0.001)
    assert told.value("seater_fallbacks_total") == 5


def test_the_gate_is_in_one_state() -> None:
    told = Told()
    told.metrics.gate(5, True)
    assert told.value("seater_gate_state", seater_gate_state="EMERGENCY_STOP") == 1
    told.metrics.gate(77, False)  # of a later version
    assert told.value("seater_gate_state", seater_gate_state="EMERGENCY_STOP") == 0
    assert (
        told.value("seater_gate_state", seater_gate_state="UNKNOWN") == 1 and told.value("seater_emergency_stop") == 0
    )


def test_the_guide_lists_what_is_served() -> None:
    told = Told()
    served = {family.name for family in told.registry.collect()}
    listed = set(re.findall(r"`(seater_\w+?)(?:_total)?(?:\{[^}]*\})?`", GUIDE.read_text().split("## Prometheus")[1]))
    assert served == {name for name in listed if not name.startswith("seater_bags")}


def test_the_node_serves_what_it_hears(monkeypatch: pytest.MonkeyPatch) -> None:
    rospy = pytest.importorskip("rospy")
    from seater_msgs.msg import DockActionResult, GateState, MarkerDetectionArray
    from seater_tools.ros import metrics

    hear: dict[str, Callable[[Any], None]] = {}
    monkeypatch.setattr(rospy, "get_param", {"~port": 0, "~bind": "127.0.0.1"}.__getitem__)
    monkeypatch.setattr(rospy, "Subscriber", lambda topic, _, listen, **__: hear.setdefault(topic, listen))
    served: list[Any] = []
    monkeypatch.setattr(metrics, "start_http_server", lambda *arguments: served.append(arguments))
    metrics.serve()
    ((port, bind, registry),) = served
    assert (port, bind) == (0, "127.0.0.1")
    result = DockActionResult()
    result.result.result_code, result.result.position_sd = 0, 0.001
    hear["dock/result"](result)
    hear["detections"](MarkerDetectionArray())
    hear["gate_state"](GateState(state=GateState.OBSTACLE))
    text = client.generate_latest(registry).decode()
    assert 'seater_goals_total{action="dock",result="SUCCESS"} 1.0' in text
    assert 'seater_gate_state{seater_gate_state="OBSTACLE"} 1.0' in text
    names = [n for n in dir(GateState) if n.isupper() and isinstance(getattr(GateState, n), int)]
    assert set(metrics.STATES.values()) == set(names)
