#!/usr/bin/env python3
"""Each part its own process, on the clock on the wall: the stage that fails is named; a fault ends the docking at rest;
once it is gone, it docks."""

import json
import subprocess
import sys
import time
from pathlib import Path

import rospy
import rostest
from seater_test.harness import DockingCase
from seater_test.stalls import Stalls

from seater_msgs.msg import DockResult
from seater_tools.history.store import read


def fail(*words: str) -> subprocess.CompletedProcess[str]:
    """`rosrun seater_sim failure`, as a person types it."""
    return subprocess.run(["rosrun", "seater_sim", "failure", *words], capture_output=True, text=True, timeout=60.0)


class FreeRunning(DockingCase):
    simulator = "/plant"

    def setUp(self) -> None:
        super().setUp()
        self.results: list[DockResult] = []
        self.stalls = Stalls()
        rospy.Subscriber("ground_truth", rospy.AnyMsg, self.stalls.heard)

    def test_a_covered_marker_a_runaway_and_a_docking(self) -> None:
        refused = fail("camera", "tired")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("camera has no fault 'tired'", refused.stderr)

        self.assert_camera_is_named()
        self.ends_with(DockResult.MARKER_LOST, "camera", "cover", "--nearer", "1.1")
        self.ends_with(DockResult.RUNAWAY, "plant", "runaway", "0.4")
        docked = self.ends_with(DockResult.SUCCESS, "plant", "clear")
        self.assert_commands_within_limits()
        position, _ = self.final_error()
        self.assertLess(position, 0.03)
        self.assert_history(docked)

    def ends_with(self, code: int, component: str, *fault: str) -> DockResult:
        """A docking, into which the fault comes, ends with this code and at rest; the fault is gone afterwards."""
        before = len(self.results)
        result = self.stalls.undisturbed(
            lambda: self.dock_with(component, *fault), lambda result: bool(result.result_code == code)
        )
        again = len(self.results) - before > 1
        if again and code == DockResult.SUCCESS and result.result_code == DockResult.ALREADY_DOCKED:
            return result  # the try before was disturbed when the chair had arrived
        self.assertEqual(result.result_code, code, result.result_text)
        self.assert_standing()
        return result

    def dock_with(self, component: str, *fault: str) -> DockResult:
        self.client.send()
        done = fail(component, *fault)
        self.results.append(self.result())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(fail(component, "clear").returncode, 0)
        return self.results[-1]

    def assert_camera_is_named(self) -> None:
        """Without images every stage still reports, and the camera, not one that waits for it, is the first to fail."""
        self.assertEqual(fail("camera", "off").returncode, 0)
        time.sleep(2.0)  # 1.5 s of silence
        words = ["rosrun", "seater_tools", "doctor", "--stages", "--json", "--seconds", "2.5"]
        done = subprocess.run(words, capture_output=True, text=True, timeout=60.0)
        self.assertEqual(fail("camera", "clear").returncode, 0)
        self.assertEqual(done.returncode, 1, done.stderr)
        said = json.loads(done.stdout)
        self.assertEqual(said["first"], "camera", said["conclusion"])
        self.assertIn("no image with its camera_info on /camera/color/image_raw for", said["conclusion"])
        levels = {stage["name"]: stage["level"] for stage in said["stages"]}
        unknown = [name for name, level in levels.items() if level == "STALE"]
        self.assertEqual(unknown, ["obstacles", "inputs"], said)  # not launched here
        self.assertEqual([name for name, level in levels.items() if level == "ERROR"], ["camera"], said)

    def assert_history(self, docked: DockResult) -> None:
        """A line for each docking, once the docking node's diagnostics have come."""
        results = self.results
        path, end = Path(rospy.get_param("~history")), time.monotonic() + 15.0
        while time.monotonic() < end and (not path.exists() or len(read(path)[0]) < len(results)):
            time.sleep(0.2)
        dockings, damaged = read(path)
        path.unlink()
        path.with_name(f".{path.name}.lock").unlink()
        self.assertEqual(([docking.code for docking in dockings], damaged), ([r.result_code for r in results], 0))
        if docked.result_code == DockResult.ALREADY_DOCKED:
            return
        last = dockings[-1]
        self.assertAlmostEqual(last.x, docked.longitudinal_error, places=6)
        self.assertEqual((last.contact, last.tries), (1, 1 + docked.num_retries))
        self.assertTrue(last.nis > 0.0 and last.mount_x_sd > 0.0 and 0.0 < last.accepted <= 1.0, last)


if __name__ == "__main__":
    rostest.rosrun("seater_test", "free_running", FreeRunning, sys.argv)
