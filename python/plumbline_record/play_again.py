#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Records a sequence again by the clock, as if its camera and IMU were here: to try live mapping without either, and an
example of recording.py. Usage: play_again.py SEQUENCE OUT [--speed 1]"""
import argparse
import json
import os
import time

from recording import Recording


def rows_of(file):
    with open(file) as lines:
        return [line.strip().split(",") for line in lines if line[:1].isdigit()]


def stamp(text):
    """Seconds; whole numbers beyond 1e12 are nanoseconds (docs/formats.md)."""
    return int(text) * 1e-9 if text.isdigit() and int(text) > 10**12 else float(text)


def images_of(sequence):
    """(stamp_s, file) of each."""
    color = os.path.join(sequence, "color")
    table = os.path.join(sequence, "color.csv")
    if os.path.exists(table):
        return [(stamp(row[0]), os.path.join(color, os.path.basename(row[1].strip()))) for row in rows_of(table)]
    with open(os.path.join(sequence, "camera.json")) as file:
        rate_hz = json.load(file)["rate_hz"]
    return [(int(name.split(".")[0]) / rate_hz, os.path.join(color, name)) for name in sorted(os.listdir(color))]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sequence", help="with imu.csv, and body_from_cam in its camera.json")
    parser.add_argument("out")
    parser.add_argument("--speed", type=float, default=1, help="times as fast as it was recorded")
    arguments = parser.parse_args()
    beside = lambda name: os.path.join(arguments.sequence, name)
    images = images_of(arguments.sequence)
    coming = [(at, 1, file) for at, file in images]
    for row in rows_of(beside("imu.csv")):
        coming.append((stamp(row[0]), 0, [stamp(row[0])] + [float(number) for number in row[1:]]))
    coming.sort(key=lambda one: one[:2])
    imu_json = beside("imu.json") if os.path.exists(beside("imu.json")) else None
    with Recording(arguments.out, beside("camera.json"), imu_json) as recording:
        began, first, readings = time.monotonic(), coming[0][0], []
        for at, is_image, what in coming:
            wait = (at - first) / arguments.speed - (time.monotonic() - began)
            if readings and (wait > 0.002 or is_image):
                recording.readings(readings)
                readings = []
            if wait > 0.002:
                time.sleep(wait)
            if not is_image:
                readings.append(what)
                continue
            with open(what, "rb") as file:
                recording.image(at, file.read(), os.path.splitext(what)[1])
        if readings:
            recording.readings(readings)
        print(f"recorded {recording.num_images} images in {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main()
