# SPDX-License-Identifier: Apache-2.0
"""Tests that record a little drawn film again."""
import json
import os
import subprocess
import tempfile
import time
import unittest

PLUMBLINE = os.environ["PLUMBLINE_BINARY"]


def rows(file):
    """Of color.csv or imu.csv."""
    with open(file) as lines:
        return [line.strip().split(",") for line in lines if line[:1].isdigit()]


class RecordedFilm(unittest.TestCase):
    """`film` has 12 images at 10 Hz, and an IMU."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.film = os.path.join(cls.folder.name, "film")
        subprocess.run([PLUMBLINE, "synth", "--imu", "--size", "160x120", "--rate", "10", "--frames", "12",
                        "--light-rays", "4", "--out", cls.film], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def frames(self, sequence):
        """How many `info` finds."""
        info = subprocess.run([PLUMBLINE, "info", sequence, "--json", "-"], check=True, capture_output=True, text=True)
        return json.loads(info.stdout)["frames"]["count"]

    def wait_for_images(self, recording, number):
        for _ in range(4000):
            table = os.path.join(recording, "color.csv")
            if os.path.exists(table) and len(rows(table)) >= number:
                return
            time.sleep(0.005)
        self.fail("no images came")
