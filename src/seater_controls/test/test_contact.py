"""The emergency stop's contact: open once is pressed, whatever fails is pressed, released only after a while."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from seater_common.params import ParameterError, load, read_yaml
from seater_controls.contact.contact import Contact
from seater_controls.contact.lines import LineError, Lines
from seater_controls.contact.watch import Watch
from seater_controls.settings import ContactSettings

SETTINGS = ContactSettings()
CONFIG = Path(__file__).resolve().parents[3] / "config"
STEP = 1.0 / SETTINGS.sampling


class Chip:
    """What stands in for libgpiod: module, chip and lines in one."""

    LINE_REQ_DIR_IN, LINE_REQ_FLAG_BIAS_PULL_UP, LINE_REQ_FLAG_BIAS_PULL_DOWN = 1, 32, 16

    def __init__(self) -> None:
        self.levels: list[int] = [0]
        self.there, self.fails, self.allowed = True, False, True
        self.requested: dict = {}
        self.opened = self.closed = 0

    def Chip(self, name: str) -> "Chip":
        if not self.there:
            raise FileNotFoundError(2, "No such file or directory")
        if not self.allowed:
            raise PermissionError(13, "Permission denied")
        self.opened += 1
        return self

    def get_lines(self, numbers: list[int]) -> "Chip":
        if max(numbers) > 53:
            raise OSError(22, "Invalid argument")
        return self

    def request(self, **how: object) -> None:
        self.requested = how

    def get_values(self) -> list[int]:
        if self.fails:
            raise OSError(5, "Input/output error")
        return self.levels

    def release(self) -> None: ...

    def close(self) -> None:
        self.closed += 1


def released(settings: ContactSettings = SETTINGS) -> tuple[Contact, float]:
    """Closed from 0 s on, and when it is told to be released."""
    made, now = Contact(settings), 0.0
    while made.read([settings.closed] * len(settings.lines), now):
        now += STEP
        assert now < 1.0
    return made, now


def test_the_shipped_file_holds_the_defaults() -> None:
    assert load(ContactSettings, read_yaml(CONFIG / "emergency_stop.yaml"), "x") == SETTINGS


def test_pressed_at_the_start_and_released_after_a_while() -> None:
    assert Contact(SETTINGS).why == "not read yet"
    made, now = released()
    assert now == pytest.approx(SETTINGS.release, abs=1.5 * STEP) and made.why == ""


def test_open_once_is_pressed_and_bounces_release_nothing() -> None:
    made, now = released()
    random = np.random.default_rng(2)
    assert made.read([1], now + STEP)
    opened, releases = now + STEP, 0
    for k in range(2, 2000):
        level, at = int(random.random() < 0.1), now + STEP * k
        pressed = made.read([level], at)
        opened = at if level else opened
        assert pressed or at - opened >= SETTINGS.release
        releases += not pressed
    assert releases > 0
    assert made.read([1], now + STEP * 2001) and "line 17 is open" in made.why


@pytest.mark.parametrize("levels", [None, [], [0, 0]])
def test_what_cannot_be_read_is_pressed(levels: list[int] | None) -> None:
    made, now = released()
    assert made.read(levels, now + STEP, "Input/output error")
    assert made.read([0], now + 2 * STEP), "and is not released at once"


def test_each_of_two_contacts_stops() -> None:
    made, now = released(replace(SETTINGS, lines=(17, 27)))
    assert made.read([0, 1], now + STEP) and made.why == "line 27 is open"


def test_a_release_needs_readings_without_a_break() -> None:
    made = Contact(SETTINGS)
    assert made.read([0], 0.0) and made.read([0], 5.0), "nobody looked between them"
    made, now = released()
    assert not made.read([0], now + 5.0), "a machine that was busy presses nothing"


def test_a_contact_to_the_supply() -> None:
    made, now = released(replace(SETTINGS, closed=1))
    assert made.read([0], now + STEP)
    chip = Chip()
    Lines(replace(SETTINGS, closed=1), chip)
    assert chip.requested["flags"] == chip.LINE_REQ_FLAG_BIAS_PULL_DOWN


def test_lines_are_inputs_with_a_pull_up_and_are_given_back() -> None:
    chip = Chip()
    lines = Lines(SETTINGS, chip)
    assert (chip.requested["type"], chip.requested["flags"]) == (chip.LINE_REQ_DIR_IN, chip.LINE_REQ_FLAG_BIAS_PULL_UP)
    assert lines.levels() == [0]
    chip.fails = True
    with pytest.raises(LineError, match="cannot be read"):
        lines.levels()
    lines.close()
    assert chip.closed == 1


@pytest.mark.parametrize(
    ("change", "settings", "words"),
    [
        ({"there": False}, SETTINGS, "gpiochip0, line 17: .*gpioinfo"),
        ({"allowed": False}, SETTINGS, "usermod -aG gpio"),
        ({}, replace(SETTINGS, lines=(99,)), "line 99: .*Invalid"),
    ],
)
def test_lines_that_cannot_be_had_say_what_to_do(change: dict, settings: ContactSettings, words: str) -> None:
    chip = Chip()
    for name, value in change.items():
        setattr(chip, name, value)
    with pytest.raises(LineError, match=words):
        Lines(settings, chip)


class Watched:
    """A watch in a time of its own."""

    def __init__(self) -> None:
        self.chip, self.now, self.told = Chip(), 0.0, []
        self.watch = Watch(SETTINGS, lambda p: self.told.append((self.now, p)), lambda s: Lines(s, self.chip))

    def run(self, seconds: float) -> list[tuple[float, bool]]:
        """What was told meanwhile."""
        begin = len(self.told)
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            self.watch.step(self.now)
        return self.told[begin:]


def test_a_heartbeat_at_its_rate_and_pressed_at_once() -> None:
    made = Watched()
    assert made.run(0.05)[0][1] is True
    beats = made.run(2.0)
    assert 38 <= len(beats) <= 41 and not beats[-1][1] and made.watch.why == ""
    made.chip.levels = [1]
    (first, *_) = made.run(0.1)
    assert first == (pytest.approx(made.now - 0.1 + STEP), True)
    made.chip.levels = [0]
    assert all(pressed for at, pressed in made.run(0.095)) and not made.run(0.1)[-1][1]


def test_a_chip_that_is_gone_is_pressed_and_opened_anew() -> None:
    made = Watched()
    made.run(0.5)
    made.chip.fails = True
    made.chip.there = False
    assert made.run(1.2)[0][1] and made.told[-1][1] and "gpioinfo" in made.watch.why
    made.chip.fails, made.chip.there = False, True
    assert not made.run(0.8)[-1][1]
    assert made.chip.opened == 2


def test_random_presses_and_faults() -> None:
    """60 s of random levels and failures: never told released within `release` of an open or failed reading."""
    random, made, bad_at = np.random.default_rng(4), Watched(), 0.0
    for _ in range(round(60.0 / STEP)):
        if random.random() < 0.02:
            made.chip.levels = [int(random.random() < 0.4)]
            made.chip.fails = bool(random.random() < 0.1)
        made.run(STEP)
        if made.chip.levels != [0] or made.chip.fails:
            bad_at = made.now
        at, pressed = made.told[-1]
        assert pressed or at - bad_at >= SETTINGS.release - STEP - 1e-9 or at < bad_at <= at + 1.0 / SETTINGS.rate
        assert made.now > bad_at or made.told[-1][1], "an open one is told at once"
    assert {pressed for _, pressed in made.told} == {True, False}


def wait(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.005)


def test_the_thread_ends_with_pressed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("threading.excepthook", lambda arguments: None)
    told: list[bool] = []
    watch = Watch(SETTINGS, told.append, lambda s: Lines(s, Chip()))
    watch.start()
    wait(lambda: told != [] and not told[-1])
    watch.stop()
    assert told[-1] and not watch.alive

    def broken(settings: ContactSettings) -> Lines:
        raise KeyError("nobody has thought of it")

    told.clear()
    watch = Watch(SETTINGS, told.append, broken)
    watch.start()
    wait(lambda: not watch.alive)
    assert told == [True], "silence follows, which the gate notices"


@pytest.mark.parametrize("lines", [[], [17, 17], [-1]])
def test_wrong_lines_are_named(lines: list[int]) -> None:
    with pytest.raises(ParameterError, match="lines"):
        load(ContactSettings, {**read_yaml(CONFIG / "emergency_stop.yaml"), "lines": lines}, "emergency_stop")


def test_a_real_contact_that_is_closed(request: pytest.FixtureRequest) -> None:
    told = [t.split(":")[1:] for t in request.config.getoption("--hardware") if t.startswith("contact:")]
    if not told:
        pytest.skip("no --hardware contact:CHIP:LINE")
    for chip, line in told:
        lines = Lines(replace(SETTINGS, chip=chip, lines=(int(line),)))
        assert lines.levels() == [0]
        lines.close()
