"""What the web server needs to know of the chair, without ROS."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from seater_panel.hold.driver import Driver
from seater_panel.hold.hold import Hold
from seater_panel.web.check import Check
from seater_panel.web.frames import Frames


@dataclass(frozen=True, kw_only=True)
class Panel:
    """`view`: the mapping of seater_panel.view.model at this moment. `changed`: to be called when the hold has changed,
    so that `Driver.step` follows at once. `driver` None: the panel only shows. `check`: the doctor, if there is one."""

    hold: Hold
    driver: Driver | None
    frames: Frames
    view: Callable[[], dict[str, Any]]
    changed: Callable[[], None] = lambda: None
    clock: Callable[[], float] = time.monotonic
    check: Check | None = None
