"""Motor controller, motors, battery and brakes: from the speeds asked for to the turning of the two wheels."""

from __future__ import annotations

import math

from seater_sim.chair.plant import Axis
from seater_sim.settings import MotorSettings

BRAKES_GRIP = 0.1  # [s] after the loss of power; spring-applied brakes of such motors: some hundredths; assumed
LOWEST_STRENGTH = 0.3  # an empty battery: the motor controller of a real chair switches off below


class RampedAxis:
    """One axis of the motor controller: ramps, one for each direction of change, and a first-order lag."""

    def __init__(self, lag: float, acceleration: float, deceleration: float) -> None:
        """Lag [s]; ramps in m/s^2 or rad/s^2, 0: none."""
        self._axis = Axis(lag, math.inf)
        self._acceleration, self._deceleration = acceleration or math.inf, deceleration or math.inf

    @property
    def speed(self) -> float:
        """Behind ramp and lag [m/s or rad/s]."""
        return self._axis.speed

    @property
    def asked(self) -> bool:
        """Whether the ramp has a demand."""
        return self._axis.demand != 0.0

    def advance(self, target: float, duration: float) -> float:
        """Drive towards `target` for `duration` [s]; returns the way. A step in which the demand changes its sign is
        made with the deceleration."""
        demand = self._axis.demand
        slower = target * demand < 0.0 or abs(target) < abs(demand)
        self._axis.rate = self._deceleration if slower else self._acceleration
        return self._axis.advance(target, duration)

    def brake(self, duration: float) -> float:
        """Without power the brakes slow the wheel down as hard as the ramp would, but without its lag; returns the
        way."""
        return self._axis.brake(self._deceleration, duration)

    def coast(self, duration: float) -> float:
        """Neither driven nor braked; returns the way."""
        return self._axis.brake(0.0, duration)

    def stop(self) -> None:
        """Stand at once."""
        self._axis.stop()


class Drive:
    """Both axes with the brakes.

    An electromagnetic brake holds each wheel once the demand has been zero for `brake_delay`, and until there is one.
    """

    def __init__(self, settings: MotorSettings) -> None:
        s = settings
        self.linear = RampedAxis(s.lag_v, s.acceleration, s.deceleration)
        self.angular = RampedAxis(s.lag_omega, s.turn_acceleration, s.turn_deceleration)
        self._settings = settings
        self._idle = 0.0  # [s] without demand
        self._unpowered = 0.0  # [s] without power

    def advance(self, v: float, omega: float, duration: float) -> tuple[float, float]:
        """(way [m], turn [rad]) of the wheels' turning in `duration` [s], before load."""
        self._unpowered = 0.0
        way, turn = self.linear.advance(v, duration), self.angular.advance(omega, duration)
        if v or omega or self.linear.asked or self.angular.asked:
            self._idle = 0.0
            return way, turn
        self._idle += duration
        if 0.0 < self._settings.brake_delay < self._idle:
            self.stop()
            return 0.0, 0.0
        return way, turn

    def advance_unpowered(self, duration: float) -> tuple[float, float]:
        """The same without power: the brakes of both wheels grip after BRAKES_GRIP."""
        self._unpowered += duration
        if self._unpowered <= BRAKES_GRIP:
            return self.linear.coast(duration), self.angular.coast(duration)
        return self.linear.brake(duration), self.angular.brake(duration)

    @property
    def moving(self) -> bool:
        """Whether the motors turn or are to turn; a chair at rest is held by brakes or friction."""
        return bool(self.linear.speed or self.angular.speed or self.linear.asked or self.angular.asked)

    def stop(self) -> None:
        """Stand at once."""
        self.linear.stop()
        self.angular.stop()

    def strength(self, elapsed: float, load: float) -> float:
        """Speed of the motors over what is asked, for the time since the start [s] and the load [m/s^2].

        The no-load speed of a DC motor is proportional to its voltage, which falls with the charge and with the current
        (inner resistance), hence with the load.
        """
        s = self._settings
        return max(LOWEST_STRENGTH, 1.0 - s.droop_time * elapsed - s.droop_load * max(load, 0.0))
