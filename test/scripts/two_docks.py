#!/usr/bin/env python3
"""A chair with two docks, docked at one, leaves it and docks at the other; what it must not do in between."""

import math
import shutil
import sys
import tempfile
from pathlib import Path

import actionlib
import rospy
import rostest
from nav_msgs.msg import Odometry
from seater_test.harness import DockingCase
from std_msgs.msg import UInt32
from std_srvs.srv import Trigger

from seater_common.se2 import relative
from seater_msgs.msg import DockAction, DockGoal, DockInUse, DockResult, DockState
from seater_msgs.srv import ListDocks

LAB = (0.0, 0.0, 0.0)
HALL = (0.6, 1.8, 0.5)  # where its prints hang in the simulated world, in the frame of lab
PREDOCK_X = -1.2  # of both


class TwoDocks(DockingCase):
    def setUp(self) -> None:
        super().setUp()
        self.dock_client = actionlib.SimpleActionClient("dock", DockAction)
        self.wait(lambda: self.dock_client.wait_for_server(rospy.Duration.from_sec(0.1)), "the action dock")
        rospy.wait_for_message("odom", Odometry, 60.0)
        self.list_docks = rospy.ServiceProxy("list_docks", ListDocks)
        self.reload = rospy.ServiceProxy("reload_docks", Trigger)
        self.states: list[DockState] = []
        self.in_use: list[DockInUse] = []
        rospy.Subscriber("dock_state", DockState, self.states.append, queue_size=10)
        self.collisions: list[int] = []
        rospy.Subscriber("collisions", UInt32, lambda message: self.collisions.append(message.data), queue_size=10)
        rospy.Subscriber("dock_in_use", DockInUse, self.in_use.append, queue_size=10)

    def test_one_dock_after_the_other(self) -> None:
        self.unknown_dock()
        self.docked_at_lab()
        self.no_way_from_dock_to_dock()
        self.docks_loaded_anew_while_docked()
        self.stage_at_lab()
        self.dock_at_hall()
        self.assertEqual(self.collisions, [0], "the walls of lab were touched on the way to hall")

    def unknown_dock(self) -> None:
        docks = self.list_docks()
        self.assertEqual((docks.names, docks.configured, docks.in_use), (["lab", "hall"], "lab", "lab"))
        result = self.end(DockGoal(dock_id="attic"))
        self.assertEqual(result.result_code, DockResult.DOCK_NOT_IN_DB)
        self.assertIn("known are lab, hall", result.result_text)

    def docked_at_lab(self) -> None:
        result = self.end(DockGoal())
        self.assertEqual(result.result_code, DockResult.ALREADY_DOCKED, result.result_text)
        self.expect_state(DockState.DOCKED, "lab")
        self.assertEqual(self.states[-1].contact, DockState.CONTACT_CLOSED)

    def no_way_from_dock_to_dock(self) -> None:
        where = self.truth[-1][1:4]
        result = self.end(DockGoal(dock_id="hall"))
        self.assertEqual(result.result_code, DockResult.DOCKED_ELSEWHERE, result.result_text)
        self.assertIn("docked at lab: undock first", result.result_text)
        self.assertEqual(self.list_docks().in_use, "lab")
        self.assertEqual(self.truth[-1][1:4], where)

    def docks_loaded_anew_while_docked(self) -> None:
        folder = Path(tempfile.mkdtemp()) / "docks"
        self.addCleanup(shutil.rmtree, folder.parent)
        shutil.copytree(rospy.get_param("~folder"), folder)
        rospy.set_param("docking/docks", str(folder))
        lab, hall = folder / "lab.yaml", folder / "hall.yaml"
        told, text = lab.read_text(), hall.read_text()
        hall.write_text(text.replace("id: 4", "id: 2"))
        answer = self.reload()
        self.assertFalse(answer.success)
        self.assertIn(f"{lab}/markers[2]/id", answer.message)  # the one that has it already
        self.assertIn(f"{hall}/markers[1]/id: is 2", answer.message)

        hall.write_text(text)
        lab.unlink()
        (folder / "attic.yaml").write_text(text.replace("name: hall", "name: attic").replace("id: ", "id: 1"))
        lab.write_text(told.replace("position: 0.010", "position: 0.011"))
        answer = self.reload()
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(self.list_docks().names, ["lab", "attic", "hall"])
        self.wait(lambda: self.in_use[-1].revision == 1, "the new lab to be told")
        self.expect_state(DockState.DOCKED, "lab")  # by contact and images, once more

    def stage_at_lab(self) -> None:
        result = self.end(DockGoal(staging_only=True))
        self.assertEqual(result.result_code, DockResult.SUCCESS, result.result_text)
        off = relative(LAB, self.truth[-1][1:4]) - [PREDOCK_X, 0.0, 0.0]
        self.assertLess(math.hypot(off[0], off[1]), 0.1)  # predock_position, and what the images are wrong by
        self.assertLess(abs(off[2]), 0.11)
        self.expect_state(DockState.NOT_DOCKED, "")

    def dock_at_hall(self) -> None:
        self.dock_client.send_goal(DockGoal(dock_id="hall"))
        self.wait(lambda: abs(self.truth[-1][4]) > 0.05, "the chair to drive")
        answer = self.reload()
        self.assertEqual((answer.success, answer.message), (False, "a goal to dock is active"))
        result = self.await_result()
        self.assertEqual(result.result_code, DockResult.SUCCESS, result.result_text)
        x, y, heading = relative(HALL, self.truth[-1][1:4]).tolist()
        self.assertLess(math.hypot(x, y), self.dock.tolerance.position)
        self.assertLess(abs(heading), self.dock.tolerance.heading)
        self.expect_state(DockState.DOCKED, "hall")
        self.assertEqual(self.list_docks().in_use, "hall")

    def end(self, goal: DockGoal) -> DockResult:
        self.dock_client.send_goal(goal)
        return self.await_result()

    def await_result(self) -> DockResult:
        self.assertTrue(self.dock_client.wait_for_result(rospy.Duration.from_sec(200.0)))
        self.let_pass(0.3)
        self.assert_standing()
        return self.dock_client.get_result()

    def assert_standing(self) -> None:
        if self.commands:
            super().assert_standing()

    def expect_state(self, state: int, dock: str) -> None:
        what = f"dock_state {state} {dock}"
        self.wait(
            lambda: bool(self.states) and (self.states[-1].state, self.states[-1].dock) == (state, dock), what, 20
        )


if __name__ == "__main__":
    rostest.rosrun("seater_test", "two_docks", TwoDocks, sys.argv)
