# SPDX-License-Identifier: Apache-2.0
"""plumbline batch on a Slurm of this machine alone gives the table that it gives without; killed and stopped it stays in order."""
import json
import os
import pathlib
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from one_node_slurm import OneNodeSlurm, missing  # noqa: E402

PROGRAM = os.environ["PLUMBLINE_BINARY"]
PLAN = {
    "sequences": [{"name": "room", "seeds": "101:103",
                   "synth": {"scene": "room", "frames": 8, "size": "160x120", "light-rays": 4, "rate": 10}}],
    "recipes": [{"name": "as it is"}, {"name": "fails", "arguments": ["--no-such-option"]}],
    "seeds": "0:3",
    "evaluate": {"samples": 1000},
}
RUNS = 12


def rows(folder, table):
    with sqlite3.connect(f"file:{folder / 'results.sqlite'}?mode=ro", uri=True) as database:
        return database.execute(f"SELECT * FROM {table}").fetchall()


class Slurm(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="plumbline_slurm_")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.slurm = OneNodeSlurm(cls.folder / "slurm")
        cls.slurm.__enter__()
        cls.addClassCleanup(cls.slurm.stop)
        (cls.folder / "plan.json").write_text(json.dumps(PLAN))
        cls.local = cls.folder / "local"
        cls.batch("local", "--jobs", "2").communicate(timeout=500)

    @classmethod
    def batch(cls, out, *arguments):
        return subprocess.Popen([PROGRAM, "batch", "plan.json", "--out", out, *arguments], cwd=cls.folder,
                                env=cls.slurm.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    @classmethod
    def done(cls, out):
        return len(list((cls.folder / out / "jobs").glob("*/result.json")))

    def queue(self):
        return subprocess.run(["squeue", "-h", "-o", "%i"], env=self.slurm.environment, capture_output=True,
                              text=True).stdout.split()

    def wait_until(self, true, what):
        end = time.monotonic() + 120
        while not true():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.1)

    def assert_same_table(self, out):
        for table in ["results", "missed"]:
            self.assertEqual(rows(self.folder / out, table), rows(self.local, table))

    def test_gives_the_table_of_this_machine(self):
        batch = self.batch("cluster", "--engine", "slurm", "--jobs", "2")
        said = batch.communicate(timeout=500)
        self.assertEqual(batch.returncode, 1, said)  # a recipe fails
        self.assertIn("6 of 12 runs failed", said[1])
        self.assertEqual(len(rows(self.folder / "cluster", "results")), RUNS)
        self.assert_same_table("cluster")

    def test_killed_it_waits_for_its_array(self):
        killed = self.batch("killed", "--engine", "slurm", "--jobs", "1")
        self.wait_until(lambda: self.done("killed") > 1, "nothing is done")
        killed.send_signal(signal.SIGKILL)
        killed.communicate()
        self.assertTrue(self.queue())
        again = self.batch("killed", "--engine", "slurm", "--jobs", "1")
        said = again.communicate(timeout=500)
        self.assertIn("an array of an earlier call is still at work", said[0] + said[1])
        self.assert_same_table("killed")

    def test_stopped_it_cancels_its_array_and_goes_on(self):
        stopped = self.batch("stopped", "--engine", "slurm", "--jobs", "1")
        self.wait_until(lambda: self.done("stopped") > 1, "nothing is done")
        stopped.send_signal(signal.SIGINT)
        said = stopped.communicate(timeout=60)
        self.assertIn("the same command goes on", said[1])
        self.wait_until(lambda: not self.queue(), "tasks are left")
        self.assertLess(self.done("stopped"), RUNS)
        self.batch("stopped", "--engine", "slurm", "--jobs", "2").communicate(timeout=500)
        self.assert_same_table("stopped")


if __name__ == "__main__":
    if missing():
        print("skipped: Slurm is not on this machine (" + ", ".join(missing()) +
              "; Debian: apt-get install slurm-wlm munge)")
        sys.exit(77)
    unittest.main()
