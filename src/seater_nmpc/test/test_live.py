"""Parameters that are changed while the node runs: which, when, and without a step of the command."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import CAMERA, World

from seater_common.geometry import Chair, Dock, Limits
from seater_common.params import ParameterError
from seater_nmpc.control.controller import DockingController
from seater_nmpc.drive.axis import configured
from seater_nmpc.live.offered import SPEEDS, TOLERANCES, changed, check_speeds, offered, refusal
from seater_nmpc.live.tuning import prepare
from seater_nmpc.parameters import NmpcParameters, SequenceParameters, Weights
from seater_nmpc.sequence.goal.results import ResultCode, Step
from seater_nmpc.sequence.vehicle import Vehicle

PERIOD = 0.05
VALUES = {entry.name: entry.default for entry in offered(NmpcParameters(), Limits())}


def started(world: World) -> World:
    world.tick()
    world.sequence.start_dock(world.now)
    return world


def speeds(world: World) -> np.ndarray:
    return np.array([(command.v, command.omega) for command in world.commands])


def test_ranges_and_meanings_are_those_of_the_structs() -> None:
    entries = {entry.name: entry for entry in offered(NmpcParameters(), Limits(v_max=0.4, v_reverse_max=0.5))}
    hold = {f.name: f for f in dataclasses.fields(SequenceParameters)}["hold_position"].metadata
    entry = entries["hold_position"]
    assert (entry.low, entry.high, entry.default) == (hold["low"], hold["high"], SequenceParameters().hold_position)
    assert hold["doc"] in entry.doc and "[m]" in entry.doc
    assert isinstance(entries["max_moves"].high, int)
    assert entries["weight_x"].high == math.inf
    assert set(entries) == {*SPEEDS, *TOLERANCES, *(f"weight_{f.name}" for f in dataclasses.fields(Weights))}
    assert entries["v_max"].high == 0.5, "never faster than the chair's file says, backward neither"


def test_values_reach_the_structs_or_are_refused_with_their_name() -> None:
    tuned = changed(NmpcParameters(), VALUES | {"hold_heading": 0.02, "weight_y": 3.0, "max_retries": 1})
    assert (tuned.sequence.hold_heading, tuned.control.weights.y, tuned.sequence.max_retries) == (0.02, 3.0, 1)
    assert changed(NmpcParameters(), VALUES) == NmpcParameters()
    for wrong in ({"hold_heading": math.nan}, {"weight_y": -1.0}, {"weight_y": math.inf}, {"max_retries": 99}):
        with pytest.raises(ParameterError, match=next(iter(wrong)).removeprefix("weight_")):
            changed(NmpcParameters(), VALUES | wrong)
    for speed in (math.nan, 0.0, 0.7):
        with pytest.raises(ParameterError, match="v_max"):
            check_speeds(VALUES | {"v_max": speed}, VALUES)


@pytest.mark.parametrize(
    ("change", "allowed"),
    [
        ({"v_max": 0.3}, True),
        ({"v_max": 0.3, "omega_max": 0.2}, True),
        ({"v_max": 0.3, "omega_max": 0.9}, False),
        ({"v_max": math.nan}, False),
        ({"v_max": 0.3, "hold_position": 0.002}, False),
        ({"weight_x": 2.0}, False),
    ],
)
def test_while_a_goal_is_active_speeds_may_fall_and_nothing_else(change: dict[str, float], allowed: bool) -> None:
    after = VALUES | change
    assert (refusal(VALUES, after, driving=True) == "") == allowed
    assert refusal(VALUES, after, driving=False) == ""


def test_a_speed_that_falls_on_the_way_slows_down_without_a_step_and_docks(make_world, quick_controller) -> None:
    cap, world = 0.2, started(make_world((-2.5, 0.5, -10.0)))

    def fast(step: Step) -> bool:
        return step.command.v > 0.45

    world.run(20.0, fast)
    before = len(world.commands)
    quick_controller.pace.cap(v=cap, omega=0.3)
    try:
        result = world.run(80.0).result
    finally:
        quick_controller.pace.cap()
    assert result is not None and result.code is ResultCode.SUCCESS, result
    limits, driven = Chair().limits, speeds(world)
    assert driven[before - 1, 0] > 0.45
    steps = np.abs(np.diff(driven[:-1], axis=0))  # the last one is the zero of the goal's end
    assert np.all(steps <= np.array([limits.a_max, limits.alpha_max]) * PERIOD + 1e-6)
    slowed = before + math.ceil((0.6 - cap) / (0.5 * limits.a_max) / PERIOD) + 20  # it slows down softly
    assert np.abs(driven[slowed:, 0]).max() <= cap + 1e-3
    assert np.abs(driven[slowed:, 1]).max() <= 0.3 + 1e-3
    assert driven[:, 0].max() > 0.45


def test_other_tolerances_hold_from_the_next_goal_on(make_world) -> None:
    world = started(make_world((-0.5, 0.0, 0.0), seen=lambda world: False))
    world.run(1.0)
    with pytest.raises(ValueError, match="between two goals"):
        world.sequence.tune(SequenceParameters(max_retries=0))
    world.sequence.abort(world.now, ResultCode.CANCELED, "")
    timeouts = dataclasses.replace(SequenceParameters().timeouts, detect=0.5)
    world.sequence.tune(SequenceParameters(timeouts=timeouts))
    world.sequence.start_dock(world.now)
    result = world.run(5.0).result
    assert result is not None and result.code is ResultCode.FAILED_TO_DETECT_DOCK
    assert world.now < 12.0, "after half a second, not after ten"


def core(controller: DockingController) -> SimpleNamespace:
    given = NmpcParameters(control=controller.parameters)
    return SimpleNamespace(
        dock=Dock(),
        given=given,
        parameters=given,
        camera=CAMERA,
        lock_step=True,
        vehicle=Vehicle(Chair(), Dock()),
        controller=controller,
        sequence=SimpleNamespace(tune=lambda parameters: None),
    )


def test_other_weights_are_planned_with_and_what_was_learned_stays(quick_controller) -> None:
    parameters = quick_controller.parameters
    controller = DockingController(Chair(), Dock(), parameters, deterministic=True, camera=CAMERA)
    learned = controller.history
    learned.drive.curvature = 0.0123
    here = ([-1.5, 0.4, 0.0], (0.0, 0.0), [0.0, 0.0, 0.0])
    before = controller.command(*here)
    tuned, values = core(controller), VALUES | {"weight_y": 20.0, "weight_speed": 50.0}
    change = prepare(tuned, values)
    assert controller.parameters is parameters, "nothing changes before it is made"
    change.make()
    assert controller.parameters.weights.y == 20.0 and tuned.parameters.control.weights.y == 20.0
    assert controller.history is learned and learned.drive.curvature == 0.0123
    controller.reset_commands()
    after = controller.command(*here)
    assert after.path[10, 0] < before.path[10, 0] - 0.1, "speed costs more, so it drives more slowly"
    assert prepare(tuned, values).controller is None, "the same weights need no other problem"


def test_what_does_not_fit_to_the_dock_is_refused(quick_controller) -> None:
    tuned = core(quick_controller)
    with pytest.raises(ParameterError, match="hold_position"):
        prepare(tuned, VALUES | {"hold_position": 0.02})  # the dock's tolerance is 0.01
    assert tuned.parameters is tuned.given


def test_dynamic_reconfigure_reads_the_description() -> None:
    encoding = pytest.importorskip("dynamic_reconfigure.encoding")
    from seater_nmpc.ros.live.description import ANSWER, Description

    description = Description(offered(NmpcParameters(), Limits()))
    decoded = encoding.decode_description(encoding.encode_description(description))
    assert {p["name"] for p in encoding.extract_params(decoded)} == {*VALUES, ANSWER}
    assert set(decoded["groups"]) == {"speeds, both ways", "sequence", "weights"}
    found = {p["name"]: p for p in encoding.extract_params(decoded)}
    assert (found["hold_position"]["min"], found["hold_position"]["max"]) == (0.0001, 0.1)
    assert found["max_moves"]["type"] == "int" and found["weight_x"]["type"] == "double"


def test_a_refused_change_leaves_all_as_it_was_and_says_why(quick_controller, monkeypatch) -> None:
    pytest.importorskip("dynamic_reconfigure.server")
    from seater_nmpc.ros.live import server as module

    silent = lambda *_, **__: None  # noqa: E731
    monkeypatch.setattr(module, "Server", silent)
    monkeypatch.setattr(module, "rospy", SimpleNamespace(has_param=lambda _: False, logwarn=silent, loginfo=silent))
    refused = ["a goal has begun meanwhile"]
    live = module.LiveParameters(
        lambda: [core(quick_controller)], lambda work: refused.pop() if refused else work(), lambda: False
    )
    for change, why in (
        ({"v_max": 0.3}, "meanwhile"),
        ({"v_max": math.nan}, "v_max"),
        ({"weight_x": -1.0}, "weights/x"),
    ):
        answered = live._on_change(VALUES | {"hold_heading": 0.008} | change, 0)
        assert {name: answered[name] for name in VALUES} == VALUES
        assert why in answered["answer"]
    try:
        answered = live._on_change(VALUES | {"v_max": 0.3}, 0)
        assert (answered["v_max"], answered["answer"]) == (0.3, "")
        as_told = configured(quick_controller.parameters.prediction)
        assert quick_controller.pace.limits(as_told) == (0.3, Limits().omega_max)
    finally:
        quick_controller.pace.cap()
