"""The optimal control problem: model, constraints, cost, as a programme in stages."""
