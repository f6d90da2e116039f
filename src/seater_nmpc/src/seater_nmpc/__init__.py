"""Docking by nonlinear model predictive control: model, optimal control problem, solver, observer, sequence. No ROS."""
