"""Speeds, tolerances and weights of the running docking node, by dynamic_reconfigure."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import rospy
from dynamic_reconfigure.server import Server

from seater_common.params import ParameterError
from seater_nmpc.live.offered import SPEEDS, Values, check_speeds, offered, refusal
from seater_nmpc.live.tuning import Prepared, Tunable, prepare
from seater_nmpc.ros.live.description import ANSWER, Description

NAMESPACE = "live"  # below the node


class LiveParameters:
    """A change is prepared in the service's thread (other weights are another optimisation problem: about a second) and
    made by the worker between two control cycles, whole or not at all. Files count anew when the node starts anew.
    They hold for all docks."""

    def __init__(
        self,
        cores: Callable[[], Iterable[Tunable]],
        ask: Callable[[Callable[[], str]], str],
        driving: Callable[[], bool],
    ) -> None:
        """`ask(work)`: the answer of `work` from the worker; `driving`: whether a goal is active, paused ones too."""
        self._cores, self._ask, self._driving = cores, ask, driving
        core = next(iter(cores()))
        entries = offered(core.given, core.vehicle.chair.limits)
        self._values: Values = {entry.name: entry.default for entry in entries}
        self._most = {entry.name: entry.high for entry in entries if entry.name in SPEEDS}
        if rospy.has_param(f"~{NAMESPACE}"):
            rospy.delete_param(f"~{NAMESPACE}")  # of a node before
        self._server = Server(Description(entries), self._on_change, NAMESPACE)

    def adopt(self, core: Tunable) -> None:
        """A core that was made later has the values of now, too. No goal is active there.

        Raises:
            ParameterError: they do not fit to its dock.
        """
        prepare(core, self._values).make()
        core.controller.pace.cap(*(self._values[name] for name in SPEEDS))

    def _on_change(self, config: Any, _: int) -> Any:
        """Called with what is asked for; returns what holds."""
        before, after = self._values, {name: config[name] for name in self._values}
        text = self._change(before, after) if after != before else ""
        if text:
            rospy.logwarn("live parameters not changed: %s", text)
            config.update(before)
        elif after != before:
            rospy.loginfo("live parameters: %s", {n: v for n, v in after.items() if v != before[n]})
            self._values = after
        config[ANSWER] = f"refused: {text}" if text else ""
        return config

    def _change(self, before: Values, after: Values) -> str:
        """Empty, or why it was not made."""
        text = refusal(before, after, driving=self._driving())
        if text:
            return text
        try:
            check_speeds(after, self._most)
            slow = any(after[name] != before[name] for name in after if name not in SPEEDS)
            prepared = [prepare(core, after) for core in self._cores()] if slow else []
        except ParameterError as error:
            return str(error)
        return self._ask(lambda: self._make(before, after, prepared))

    def _make(self, before: Values, after: Values, prepared: list[Prepared]) -> str:
        """In the worker: a goal may have begun meanwhile."""
        text = refusal(before, after, driving=self._driving())
        if text:
            return text
        for core in self._cores():
            core.controller.pace.cap(*(after[name] for name in SPEEDS))
        for one in prepared:
            one.make()
            for warning in one.warnings:
                rospy.logwarn(warning)
        return ""
