"""The Python module is the gate itself: what velocity_gate_test.cpp says in detail holds through it."""

import math

import pytest

import seater_safety

PARAMETERS = {entry["key"]: entry["default"] for entry in seater_safety.describe_parameters()}


def armed() -> seater_safety.VelocityGate:
    """A gate that lets requests pass."""
    gate = seater_safety.VelocityGate(**PARAMETERS)
    assert gate.arm(0.0) == ""
    return gate


def settled(gate: seater_safety.VelocityGate, v: float, omega: float) -> tuple[float, float]:
    """The output after two seconds of this request."""
    for cycle in range(41):
        gate.request(0.05 * cycle, v, omega)
        output = gate.output(0.05 * cycle)
    return output


def test_each_parameter_is_the_one_that_its_name_says() -> None:
    assert settled(armed(), 9.0, 9.0) == pytest.approx((0.6, 0.8))
    assert settled(armed(), -9.0, -9.0) == pytest.approx((-0.3, -0.8))
    gate = armed()
    gate.request(0.0, 0.0, 0.0)
    gate.output(0.0)
    gate.request(0.05, 0.6, 0.8)
    assert gate.output(0.05) == pytest.approx((0.5 * 0.05, 1.0 * 0.05))  # a_max, alpha_max
    gate.request(0.10, 0.0, 0.0)
    assert gate.output(0.11) == pytest.approx((0.0, 0.0))  # a_stop, alpha_stop: 1.5 * 0.06 > 0.025


def test_a_stop_is_harder_than_a_start_and_no_harder() -> None:
    gate = armed()
    v, omega = settled(gate, 0.6, 0.8)
    gate.request(2.05, 0.0, 0.0)
    assert gate.output(2.05) == pytest.approx((v - 1.5 * 0.05, omega - 3.0 * 0.05))


def test_a_silent_node_stops_the_chair_and_the_state_says_so() -> None:
    gate = armed()
    settled(gate, 0.6, 0.0)
    assert gate.state == seater_safety.GateState.REQUEST
    assert gate.output(2.24)[0] == pytest.approx(0.6)
    assert gate.output(2.26)[0] < 0.6  # request_timeout
    assert gate.state == seater_safety.GateState.STALE


def test_joystick_and_emergency_stop_have_precedence() -> None:
    gate = armed()
    settled(gate, 0.6, 0.0)
    gate.user(2.01, -0.1, 0.0)
    gate.output(2.01)
    assert gate.state == seater_safety.GateState.USER
    gate.emergency_stop(2.02, True)
    gate.output(2.02)
    assert gate.state == seater_safety.GateState.EMERGENCY_STOP
    assert gate.arm(2.02) == gate.reason(2.02) == "the emergency stop is pressed"


def test_without_consent_nothing_moves() -> None:
    assert settled(seater_safety.VelocityGate(**PARAMETERS), 0.5, 0.0) == (0.0, 0.0)


def test_what_is_not_finite_is_refused_and_counted() -> None:
    gate = armed()
    gate.request(0.0, math.nan, 0.1)
    assert gate.output(0.0) == (0.0, 0.0)
    assert (gate.refused, gate.limited) == (1, 0)


@pytest.mark.parametrize("name", sorted(PARAMETERS))
@pytest.mark.parametrize("value", [1e4, -1.0, math.nan])
def test_a_wrong_parameter_is_named(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: "):
        seater_safety.VelocityGate(**PARAMETERS | {name: value})


def test_every_parameter_is_asked_for_and_no_other() -> None:
    with pytest.raises(ValueError, match=r"^a_stop: is missing"):
        seater_safety.VelocityGate(**{key: value for key, value in PARAMETERS.items() if key != "a_stop"})
    with pytest.raises(ValueError, match=r"^a_stopp: is no parameter"):
        seater_safety.VelocityGate(**PARAMETERS, a_stopp=1.0)
