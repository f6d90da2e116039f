"""The search: Optuna's tree-structured Parzen estimator with constraints, kept in a file from trial to trial.

The sampler is made anew for each trial, from the seed and the number of trials that are done. So a search that was
interrupted goes on as it would have gone.
"""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from seater_common.params import ParameterError
from seater_tools.tune.objective import Verdict
from seater_tools.tune.space import Tunable

STARTUP = 10  # trials drawn at random before the estimator has its say
_CONSTRAINTS, _VIOLATIONS, _KEY = "constraints", "violations", "key"

Evaluate = Callable[[Mapping[str, float]], Verdict]


@dataclass(frozen=True, kw_only=True)
class Trial:
    """Values that were tried, and what came of it."""

    number: int
    values: dict[str, float]
    verdict: Verdict


def _optuna() -> Any:
    try:
        optuna = importlib.import_module("optuna")
    except ImportError as error:
        raise ParameterError(
            "needs Optuna, which the Debian package does not bring: run it beside the sources"
        ) from error
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
    return optuna


class Search:
    """Trials in the file `path`; the first one is what the configuration has."""

    def __init__(self, path: Path, space: Sequence[Tunable], seed: int, key: str) -> None:
        """`key`: equal for searches whose trials can be compared.

        Raises ParameterError: Optuna is missing, or the file is of another search.
        """
        self._optuna = _optuna()
        self._space, self._seed = list(space), seed
        path.parent.mkdir(parents=True, exist_ok=True)
        backend = self._optuna.storages.journal.JournalFileBackend(str(path))
        self._study = self._optuna.create_study(
            storage=self._optuna.storages.JournalStorage(backend), study_name="tune", load_if_exists=True
        )
        kept = self._study.user_attrs.setdefault(_KEY, key)
        if kept != key:
            raise ParameterError(
                f"{path}: is of another search (other files, seed, dockings or code); remove it, or choose another "
                "--results"
            )
        self._study.set_user_attr(_KEY, key)

    @property
    def trials(self) -> list[Trial]:
        """Those that are complete, in their order."""
        complete = self._optuna.trial.TrialState.COMPLETE
        found = self._study.get_trials(deepcopy=False, states=(complete,))
        return [
            Trial(
                number=number,
                values=dict(trial.params),
                verdict=Verdict(score=trial.value, violations=trial.user_attrs[_VIOLATIONS]),
            )
            for number, trial in enumerate(found)
        ]

    def step(self, evaluate: Evaluate) -> Trial:
        """One more trial. What `evaluate` raises leaves no trace."""
        number = len(self.trials)
        self._study.sampler = self._sampler(number)
        spread = {t.key: self._optuna.distributions.FloatDistribution(t.low, t.high, log=True) for t in self._space}
        if number == 0:
            self._study.enqueue_trial({t.key: t.begin for t in self._space}, skip_if_exists=True)
        trial = self._study.ask(spread)
        verdict = evaluate(dict(trial.params))
        trial.set_user_attr(_VIOLATIONS, verdict.violations)
        trial.set_user_attr(_CONSTRAINTS, list(verdict.violations.values()))
        self._study.tell(trial, verdict.score)
        return Trial(number=number, values=dict(trial.params), verdict=verdict)

    def _sampler(self, number: int) -> Any:
        return self._optuna.samplers.TPESampler(
            seed=self._seed + 7919 * number,
            n_startup_trials=STARTUP,
            multivariate=True,
            constraints_func=lambda trial: trial.user_attrs[_CONSTRAINTS],
        )


def best(trials: Sequence[Trial]) -> Trial | None:
    """The lowest score of those that break nothing."""
    allowed = [trial for trial in trials if trial.verdict.allowed]
    return min(allowed, key=lambda trial: trial.verdict.score, default=None)
