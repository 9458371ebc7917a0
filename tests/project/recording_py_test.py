#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""python/plumbline_record: what it records is the sequence that it plays, and is whole up to its last row when it is killed."""
import fcntl
import os
import signal
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from recorded_film import PLUMBLINE, RecordedFilm, rows  # noqa: E402

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
PLAY_AGAIN = os.path.join(SOURCE, "python", "plumbline_record", "play_again.py")


class PlayAgain(RecordedFilm):
    def start(self, name, speed):
        out = os.path.join(self.folder.name, name)
        return out, subprocess.Popen([sys.executable, "-B", PLAY_AGAIN, self.film, out, "--speed", speed],
                                     stdout=subprocess.DEVNULL)

    def test_records_what_it_plays(self):
        out, process = self.start("again", "2")
        self.wait_for_images(out, 2)
        with open(os.path.join(out, "color.csv.lock")) as lock, self.assertRaises(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        self.assertEqual(process.wait(), 0)
        names = sorted(os.listdir(os.path.join(self.film, "color")))
        self.assertEqual(len(names), 12)
        recorded = sorted(os.listdir(os.path.join(out, "color")))
        self.assertEqual(len(recorded), 12)
        for was, now in zip(names, recorded):
            with open(os.path.join(self.film, "color", was), "rb") as a, open(os.path.join(out, "color", now), "rb") as b:
                self.assertEqual(a.read(), b.read())
        for was, now in zip(rows(os.path.join(self.film, "imu.csv")), rows(os.path.join(out, "imu.csv"))):
            for a, b in zip(map(float, was), map(float, now)):
                self.assertAlmostEqual(a, b, delta=1e-8 * max(1, abs(a)))
        self.assertEqual(self.frames(out), 12)
        self.assertFalse(os.path.exists(os.path.join(out, "color.csv.lock")))

    def test_is_whole_when_it_is_killed(self):
        out, process = self.start("killed", "1")
        self.wait_for_images(out, 4)
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.assertGreaterEqual(self.frames(out), 4)

    def test_refuses_a_folder_that_is_not_empty(self):
        again = subprocess.run([sys.executable, "-B", PLAY_AGAIN, self.film, self.film], capture_output=True, text=True)
        self.assertNotEqual(again.returncode, 0)
        self.assertIn("is not empty", again.stderr)


if __name__ == "__main__":
    unittest.main()
