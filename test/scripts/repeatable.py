#!/usr/bin/env python3
"""The same seed gives the same run to the last bit, alone and beside another run; another seed gives another run."""

import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import rostest

from seater_eval.docking.recording import Recording, read_recording

START = "-1.0 0.05 3"  # near: every phase of a docking in few images


class Repeatable(unittest.TestCase):
    def test_same_seed_same_run(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            first = self.simulate(Path(folder) / "first", seed=7)
            with ThreadPoolExecutor(2) as pool:  # these two take each other's processor time
                beside = pool.submit(self.simulate, Path(folder) / "other", seed=8)
                second = self.simulate(Path(folder) / "second", seed=7)
                other = beside.result()
        self.assert_same("true poses", first.truth, second.truth)
        self.assert_same("commands", first.commands, second.commands)
        length = min(len(first.truth), len(other.truth))
        self.assertFalse(np.array_equal(first.truth[:length], other.truth[:length]), "the seed changes nothing")

    def simulate(self, results: Path, seed: int) -> Recording:
        options = ["--start", START, "--images", "none", "--seed", str(seed), "--results", str(results)]
        command = ["rosrun", "seater_eval", "dock_run", *options]
        run = subprocess.run(command, capture_output=True, text=True, timeout=500)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return read_recording(results / "run.bag")

    def assert_same(self, what: str, first: np.ndarray, second: np.ndarray) -> None:
        # How long the simulation ran on after the result depends on the machine; all before must agree.
        length = min(len(first), len(second))
        self.assertGreater(length, 100, what)
        different = np.flatnonzero(np.any(first[:length] != second[:length], axis=1))
        self.assertEqual(len(different), 0, f"{what} differ first in row {different[:1]} of {length}")


if __name__ == "__main__":
    rostest.rosrun("seater_test", "repeatable", Repeatable, sys.argv)
