"""What a goal that ends is said to have come to: what its phases and the installation say of it together."""

from __future__ import annotations

from seater_nmpc.sequence.goal.results import GoalEnd, Phase, ResultCode
from seater_nmpc.sequence.phases.context import Context
from seater_nmpc.sequence.phases.phases import Phases
from seater_nmpc.sequence.report import standard_deviations

# Ends at the dock: a wrong installation leads to each of them.
_AT_THE_DOCK = (ResultCode.SUCCESS, ResultCode.NOT_WITHIN_TOLERANCE, ResultCode.FAILED_TO_CHARGE)
# What ends the watch of the contact, and leaves the docked chair where it is.
_LETS_DOCKED = (
    ResultCode.CANCELED,
    ResultCode.TIMEOUT,
    ResultCode.STOPPED_BY_USER,
    ResultCode.EMERGENCY_STOP,
    ResultCode.GATE_LOST,
    ResultCode.CLIENT_LOST,
    ResultCode.CHARGING,
)


class Conclusion:
    """Of one goal after another."""

    def __init__(self, context: Context, phases: Phases) -> None:
        self._context, self._goal, self._phases = context, context.goal, phases

    def of_phase(self, end: GoalEnd) -> tuple[ResultCode, str]:
        """Code and text of an end that a phase has raised: of one at the dock, those of a wrong installation that
        shows, or of a dock that has jumped in the images; not the latter where the contact says that the chair stands
        in it. What the docking has shown of the installation is learned."""
        if end.code not in _AT_THE_DOCK or self._goal.phase is Phase.UNDOCKING or self._goal.staging:
            return end.code, end.text
        watch, installation = self._context.watch, self._context.watch.installation
        doubt = installation.final() or (None if self._goal.contact else watch.jumped())
        suspicion = installation.suspected() if end.code is ResultCode.SUCCESS else ""
        hint = installation.hint() if end.code is ResultCode.FAILED_TO_CHARGE else ""
        watch.learn(turned=self._phases.installation_shown)
        if doubt is not None:
            failed = "" if end.code is ResultCode.SUCCESS else f"{end.text}: "
            return ResultCode[doubt.kind.name], failed + doubt.text
        text = f"{end.text}, but {suspicion}" if suspicion else f"{end.text}: {hint}" if hint else end.text
        unsure = installation.unsure(self.standard_deviations[0], checked=self._phases.installation_checked)
        if end.code is ResultCode.SUCCESS and unsure and not self._goal.contact:
            return ResultCode.NOT_CERTAIN, f"{text}, and {unsure}"
        return end.code, text

    def of_goal(self, code: ResultCode, text: str) -> tuple[ResultCode, str]:
        """Code and text of the result: a docked chair stays so, whatever ends the watch of its contact; a chair that
        has backed out has failed before."""
        if self._goal.phase is Phase.HOLDING and self._goal.contact and code in _LETS_DOCKED:
            self._context.watch.learn(turned=self._phases.installation_shown)  # no phase has ended it, see `of_phase`
            code, text = ResultCode.SUCCESS, f"docked; the watch of the contact ended: {text}"
        failure = self._goal.failure
        if failure is not None and failure.code is not code:
            text = f"{text}, backing out after {failure.code.name} ({failure.text})"
        return code, text

    @property
    def standard_deviations(self) -> tuple[float, float]:
        """Of the final error [m, rad]; zero: it is not verified."""
        covariance = self._goal.covariance
        if covariance is None:
            return 0.0, 0.0
        final = self._context.watch.installation.final_error(turned=self._phases.installation_shown)
        return standard_deviations(covariance, self._context.observer.parameters, *final)
