"""What the panel says in words: what happens, or why the chair stands."""

from __future__ import annotations

from seater_panel.view.heard import Gate, Progress, Result

GATE_PATIENCE = 1.0  # [s] the gate speaks ten times per second
PROGRESS_PATIENCE = 1.0  # [s] feedback comes with every control cycle

PHASES = {
    "WAITING_FOR_DOCK": "Looking for the dock",
    "APPROACH": "Driving to the dock",
    "FINAL": "Driving in",
    "STOPPING": "Coming to rest",
    "VERIFY": "Checking the place",
    "RETRY": "Backing out to try again",
    "UNDOCKING": "Backing out",
    "CORRECTING": "Small correction",
    "SEARCHING": "Searching for the dock",
    "CHECK_INSTALLATION": "Turning to check where the camera sits",
    "STAGING": "Driving in front of the dock",
    "HOLDING": "Docked, watching the charge",
}
# States of the gate in which it holds the chair, whoever asks.
HELD_BY_GATE = {
    "STALE": "Braking",
    "REFUSED": "Braking",
    "EMERGENCY_STOP": "Emergency stop",
    "FAULT": "Fault",
    "RUNAWAY": "Motors switched off",
    "WRONG_DIRECTION": "Motors switched off",
    "OBSTACLE": "Something is in the way",
}
ENDS = {"dock": "Docked", "undock": "Undocked"}


def running(progress: Progress | None, result: Result | None, now: float) -> Progress | None:
    """The progress of the goal that runs; None: none does."""
    if progress is None or now - progress.time > PROGRESS_PATIENCE:
        return None
    return None if result is not None and result.time >= progress.time else progress


def headline(gate: Gate | None, progress: Progress | None, result: Result | None, now: float) -> tuple[str, str]:
    """What happens in a few words, and the reason or the next step; `progress` as of `running`."""
    if gate is None or now - gate.time > GATE_PATIENCE:
        return "No safety gate", "The safety gate is silent: start wheelchair.launch, or look at its terminal."
    if gate.state in HELD_BY_GATE:
        return HELD_BY_GATE[gate.state], _sentence(gate.reason)
    if gate.state == "USER":
        return "Joystick drives", "The docking has ended. Let the joystick go before the next one."
    if progress is not None:
        return PHASES.get(progress.phase, progress.phase), _hint(progress)
    if result is None:
        return "Ready", "Hold a button to drive. Let go to stop."
    if result.success:
        return ENDS.get(result.action, "Done"), _sentence(result.text)
    return "Stopped", _sentence(result.text)


def _hint(progress: Progress) -> str:
    if progress.phase == "WAITING_FOR_DOCK":
        return "The chair stands until the camera has seen the markers well."
    if progress.marker_seen is False:
        return "No marker in view at the moment."
    return f"Try {progress.retries + 1}." if progress.retries else ""


def _sentence(text: str) -> str:
    text = text.strip()
    return text if not text or text.endswith((".", "!", "?")) else f"{text[0].upper()}{text[1:]}."
