"""The problem that acados gets is the controller's: compared with its own functions, without acados."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_eval.acados.peer import AcadosError, AcadosPeer
from seater_eval.acados.stage import docking_stage, from_stages, to_stages
from seater_eval.control.acados_comparison import acados_bars
from seater_nmpc.ocp.areas import dock_areas
from seater_nmpc.ocp.docking_problem import DockingProblem
from seater_nmpc.parameters import ControlParameters

PARAMETERS = ControlParameters(horizon=6)


def test_the_stages_together_are_the_controllers_problem() -> None:
    areas, stage = dock_areas(Dock()), docking_stage(Chair(), Dock(), PARAMETERS)
    problem = DockingProblem(Chair(), PARAMETERS, areas)
    rng, N = np.random.default_rng(3), PARAMETERS.horizon
    lines = rng.uniform(-1.0, 1.0, (N, PARAMETERS.max_obstacles, 7))
    x = rng.uniform(-1.0, 1.0, problem.data(np.zeros(5), areas).lbx.size)
    data = problem.data(x[:5], areas, lines)
    states, inputs = to_stages(x, stage, N)
    x = from_stages(states, inputs)  # with the terminal penalty's slacks as acados' soft bounds have them
    functions = problem.functions
    f, g = (
        value.full().ravel()
        for value in ca.Function("fg", [functions["x"], functions["p"]], [functions["f"], functions["g"]])(x, data.p)
    )
    of_stage = ca.Function("stage", [stage.z, stage.inputs, stage.p], [stage.cost, stage.following, stage.margins])
    cost, gaps, margins = 0.0, [], []
    for k in range(N + 1):
        p = np.concatenate([stage.areas, [float(k < N)]])
        if k > 0:
            p[stage.lines] = lines[k - 1].ravel()
        c, following, m = (value.full().ravel() for value in of_stage(states[k], inputs[k], p))
        cost += stage.step * float(c[0])
        gaps.append(states[min(k + 1, N)] - following)
        margins.append(m)
    assert cost + float(stage.terminal @ np.abs(states[-1, :3])) == pytest.approx(float(f[0]), rel=1e-12)
    rows = g[:-6].reshape(N, -1)  # dynamics and margins of each step
    assert rows[:, :5] == pytest.approx(np.array(gaps[:-1]), abs=1e-12)
    assert gaps[-1] == pytest.approx(np.zeros(5), abs=1e-15)  # the last stage goes nowhere
    assert rows[:, 5:] == pytest.approx(np.array(margins[1:]), abs=1e-12)


def test_bounds_and_the_order_of_variables() -> None:
    stage = docking_stage(Chair(), Dock(), PARAMETERS)
    data = DockingProblem(Chair(), PARAMETERS, dock_areas(Dock())).data(np.zeros(5), dock_areas(Dock()))
    _, lower = to_stages(data.lbx, stage, PARAMETERS.horizon)
    assert np.array_equal(lower[1, 2:], stage.lower[2:]) and np.array_equal(lower[0, :2], stage.lower[:2])
    x = np.random.default_rng(1).uniform(size=data.lbx.size)
    x[-3:] = np.abs(to_stages(x, stage, PARAMETERS.horizon)[0][-1, :3])
    assert np.array_equal(from_stages(*to_stages(x, stage, PARAMETERS.horizon)), x)


@pytest.mark.parametrize("change", [{"fine_steps": 3}, {"last_step": 0.2}, {"max_jerk": 1.0}, {"walls": False}])
def test_problems_that_it_is_not_set_up_for_are_refused(change: dict) -> None:
    with pytest.raises(ValueError, match="acados"):
        docking_stage(Chair(), Dock(), replace(PARAMETERS, **change))


def test_a_folder_without_acados_says_how_to_make_it(tmp_path: Path) -> None:
    with pytest.raises(AcadosError, match=r"libacados.so is missing.*tools/make_acados.sh"):
        AcadosPeer(Chair(), Dock(), PARAMETERS, tmp_path)


@pytest.mark.parametrize(("median", "p99", "met"), [(1.2, 0.9, [True, True]), (1.4, 1.1, [False, False])])
def test_the_bars_are_ratios_of_processor_times(median: float, p99: float, met: list[bool]) -> None:
    times = {"command": {"median": 2.0 * median, "p99": 3.0 * p99}, "acados": {"median": 2.0, "p99": 3.0}}
    bars = acados_bars({"cpu_ms": times, "horizon": 30})
    assert [bar.value for bar in bars] == pytest.approx([p99, median])
    assert [bar.met for bar in bars] == met
