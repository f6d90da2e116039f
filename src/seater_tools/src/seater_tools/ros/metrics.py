"""The node that serves metrics to Prometheus. It listens, and sends nothing. Private parameters: ~port, ~bind."""

from __future__ import annotations

import time

import rospy
from prometheus_client import CollectorRegistry, start_http_server

from seater_msgs.msg import (
    ControllerStatus,
    DockActionResult,
    GateState,
    MarkerDetectionArray,
    UndockActionResult,
)
from seater_tools.metrics.metrics import Metrics

_STATES = (
    *("STOPPED", "REQUEST", "USER", "STALE", "REFUSED", "EMERGENCY_STOP"),
    *("FAULT", "RUNAWAY", "WRONG_DIRECTION", "OBSTACLE", "CHARGING"),
)
STATES = {getattr(GateState, name): name for name in _STATES}
_FALLBACKS = (ControllerStatus.FALLBACK_SHIFTED, ControllerStatus.FALLBACK_BRAKE)


def serve() -> None:
    """Raises KeyError (a parameter is missing) and OSError (the port is taken)."""
    port, bind = int(rospy.get_param("~port")), str(rospy.get_param("~bind"))
    registry = CollectorRegistry()
    listen(Metrics(registry, time.monotonic, STATES))
    start_http_server(port, bind, registry)


def listen(metrics: Metrics) -> None:
    """Subscribes all."""

    def on_docked(message: DockActionResult) -> None:
        r = message.result
        error = (r.longitudinal_error, r.lateral_error, r.heading_error) if r.position_sd > 0.0 else None
        metrics.docked(r.result_code, r.docking_time, r.num_retries, error)

    def on_cycle(m: ControllerStatus) -> None:
        metrics.cycle(m.solve_time, m.status != ControllerStatus.IDLE, m.status in _FALLBACKS)

    rospy.Subscriber("dock/result", DockActionResult, on_docked, queue_size=10)
    rospy.Subscriber("undock/result", UndockActionResult, lambda m: metrics.undocked(m.result.result_code))
    rospy.Subscriber("detections", MarkerDetectionArray, lambda m: metrics.image(bool(m.dock)), queue_size=10)
    rospy.Subscriber("controller_status", ControllerStatus, on_cycle, queue_size=100)
    rospy.Subscriber("gate_state", GateState, lambda m: metrics.gate(m.state, m.emergency_stop), queue_size=10)
