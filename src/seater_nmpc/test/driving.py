"""Drives a perfect chair with a controller."""

import math

import numpy as np

from seater_common.geometry import Chair, Dock, polygon_distance
from seater_common.se2 import arc_step, compose

PERIOD, CHAIR, DOCK = 0.05, Chair(), Dock()
T_COMMON_DOCK = np.array([3.0, -1.0, 2.5])


def drive(controller, start, seconds, target="dock"):
    """Perfect unicycle in a turned common frame; poses in the dock's frame and commands, one row per cycle."""
    pose, velocity = np.array([start[0], start[1], math.radians(start[2])]), (0.0, 0.0)
    poses, commands = [pose], []
    controller.reset()
    for k in range(round(seconds / PERIOD)):
        command = controller.command(compose(T_COMMON_DOCK, pose), velocity, T_COMMON_DOCK, target, k * PERIOD)
        velocity = (command.v, command.omega)
        pose = arc_step(pose, *velocity, PERIOD)
        poses.append(pose)
        commands.append(command)
    return np.array(poses), commands


def distance_to(pose, outlines) -> float:
    """Of the footprint to the nearest outline [m]; below zero where they overlap."""
    return min(polygon_distance(CHAIR.corners_at(pose), outline) for outline in outlines)
