# SPDX-License-Identifier: Apache-2.0
"""Measures the visual-inertial filter: the figures of docs/algorithms/vio.md.

Recordings in the data folder (as for measure.sh: $PLUMBLINE_DATA), ten seeds of dropped tracks on the
hand-held fisheye, starts in motion all over the kitchen with three IMUs, and simulated walks (`plumbline synth --imu --tracks`): half from rest, half in
motion, each with its own biases. Writes tables.md and results.json into build/measure/vio.
"""
import argparse
import bisect
import json
import math
import os
import pathlib
import random
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LOOP_SEEDS = range(1, 11)
WALK_SEEDS = range(301, 351)
WALK_SECONDS, WALK_RATE_HZ, REST_S = 40, 20, 2
DIVERGED_M = 1.0
START_FRAMES = range(0, 401, 40)
START_SECONDS, START_IMUS = 8, 3


def commit():
    def git(*words):
        return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True).stdout.strip()
    return git("rev-parse", "--short", "HEAD") + ("+" if git("status", "--porcelain", "--untracked-files=no") else "")


class Measurement:
    def __init__(self, arguments):
        self.program = arguments.program
        self.out = pathlib.Path(arguments.out)
        self.out.mkdir(parents=True, exist_ok=True)
        self.settings = [word for setting in arguments.set for word in ("--set", setting)]

    def call(self, *words):
        done = subprocess.run([self.program, *map(str, words)], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError((done.stderr.strip() or "it failed").splitlines()[-1])

    def estimate(self, name, sequence, *words):
        """Runs the filter; the trajectory's file and what was said."""
        file, said = self.out / f"{name}.txt", self.out / f"{name}.json"
        self.call("vio", sequence, "--out", file, "--json", said, *words, *self.settings)
        return file, json.loads(said.read_text())

    def judge(self, name, sequence, reference, *words):
        file, said = self.estimate(name, sequence, *words)
        judged = self.out / f"{name}.errors.json"
        self.call("evaluate", "--trajectory", file, "--reference", reference, "--json", judged)
        errors = json.loads(judged.read_text())
        return {"name": name, "stretches": said["stretches"], "messages": said["messages"],
                "ms": said["timings_ms"]["propagate"] + said["timings_ms"]["update"],
                "nis": said["nis_per_dof"],
                **{key: errors.get(key) for key in ("ate_m", "ate_max_m", "ate_deg", "tilt_deg", "scale", "nees", "path_m")}}


def poses_of(file):
    """Stamps, and (position, quaternion x y z w)."""
    stamps, poses = [], []
    for line in file.read_text().splitlines():
        if line.startswith("#"):
            continue
        values = [float(word) for word in line.split()]
        stamps.append(values[0])
        poses.append((values[1:4], values[4:8]))
    return stamps, poses


def turned_back(quaternion, vector):
    """The vector in the axes of a pose with this rotation."""
    x, y, z, w = quaternion
    rows = ((1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)),
            (2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)),
            (2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)))
    return [sum(r * v for r, v in zip(row, vector)) for row in rows]


def loop_error(file, loop):
    stamps, poses = poses_of(file)

    def at(stamp):
        after = min(max(bisect.bisect_left(stamps, stamp), 1), len(stamps) - 1)
        share = min(max((stamp - stamps[after - 1]) / (stamps[after] - stamps[after - 1]), 0), 1)
        (a, turn), (b, later) = poses[after - 1], poses[after]
        return [p + share * (q - p) for p, q in zip(a, b)], turn if share < 0.5 else later

    (a, turn), (b, _) = at(loop["time_a"]), at(loop["time_b"])
    moved = turned_back(turn, [q - p for p, q in zip(a, b)])
    return math.dist(moved, [row[3] for row in loop["body_a_from_body_b"][:3]])


def number(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def table(records):
    lines = ["| run | ATE m | largest m | deg | tilt deg | scale | NEES of 6 | innovations | stretches | ms an image |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for r in records:
        lines.append("| " + " | ".join([r["name"], number(r["ate_m"], 3), number(r["ate_max_m"], 3),
                                        number(r["ate_deg"], 2), number(r["tilt_deg"], 2), number(r["scale"], 4),
                                        number(r["nees"], 1), number(r["nis"], 2), str(r["stretches"]),
                                        number(r["ms"], 1)]) + " |")
    return lines


def recordings(measurement, data):
    vio, kitchen = data / "vio", data / "kitchen"
    cases = [("sim_room1", vio / "sim_room1", "groundtruth.csv", True),
             ("sim_room1 in motion", vio / "sim_room1", "groundtruth.csv", False),
             ("semireal_v101", vio / "semireal_v101", "groundtruth.csv", True),
             ("semireal_v101 in motion", vio / "semireal_v101", "groundtruth.csv", False),
             ("euroc_v101_micro", vio / "euroc_v101_micro", "gt_tum.txt", False),
             ("kitchen", kitchen, "groundtruth.csv", False)]
    records = []
    for name, folder, reference, given in cases:
        if not folder.exists():
            print(f"{name}: skipped: no '{folder}'", flush=True)
            continue
        start = ["--init", folder / reference] if given else []
        records.append(measurement.judge(name, folder, folder / reference, *start))
        print("{name}: ATE {ate_m:.3f} m, NEES {nees:.1f}".format(**records[-1]), flush=True)
    return records


def loops(measurement, data):
    folder = data / "vio/tango_lc"
    if not folder.exists():
        return []
    loop = json.loads((folder / "loop.json").read_text())
    errors = []
    for seed in LOOP_SEEDS:
        file, _ = measurement.estimate(f"tango {seed}", folder, "--drop-tracks", 0.2, "--seed", seed)
        errors.append(loop_error(file, loop))
        print(f"tango, seed {seed}: loop error {errors[-1]:.2f} m", flush=True)
    return errors


def rows_of(file):
    lines = [line for line in file.read_text().splitlines() if line]
    return lines[0], [[float(word) for word in line.split(",")] for line in lines[1:]]


def piece(source, folder, first, seconds, imu):
    """A part of a sequence as one of its own; with imu > 0 the biases and some noise of another IMU."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "color").mkdir(parents=True)
    for name in ("camera.json", "imu.json", "gravity.json"):
        shutil.copy(source / name, folder / name)
    rate = json.loads((source / "camera.json").read_text())["rate_hz"]
    names = sorted(path.name for path in (source / "color").iterdir())[first:first + int(seconds * rate)]
    for name in names:
        (folder / "color" / name).symlink_to((source / "color" / name).resolve())
    begin, end = first / rate - 0.05, (first + len(names) - 1) / rate + 0.3
    title, readings = rows_of(source / "imu.csv")
    states_title, states = rows_of(source / "groundtruth.csv")
    if imu > 0:
        noise = json.loads((source / "imu.json").read_text())
        draw = random.Random(imu)
        biases = [draw.gauss(0, 0.02) for _ in range(3)] + [draw.gauss(0, 0.1) for _ in range(3)]
        spread = [0.7 * noise[name] * math.sqrt(noise["rate_hz"]) for name in ("gyro_noise_density", "accel_noise_density")]
        stamps = [state[0] for state in states]
        for reading in readings:
            own = states[min(bisect.bisect_left(stamps, reading[0]), len(states) - 1)][11:17]
            for i in range(6):
                reading[1 + i] += biases[i] - own[i] + draw.gauss(0, spread[i // 3])
        for state in states:
            state[11:17] = biases
    for name, first_line, rows in (("imu.csv", title, readings), ("groundtruth.csv", states_title, states)):
        kept = [",".join(f"{value:.8f}" for value in row) for row in rows if begin <= row[0] <= end]
        (folder / name).write_text("\n".join([first_line] + kept) + "\n")


def starts(measurement, data):
    kitchen = data / "kitchen"
    if not kitchen.exists():
        return []
    records = []
    for first in START_FRAMES:
        for imu in range(START_IMUS):
            folder = measurement.out / "piece"
            piece(kitchen, folder, first, START_SECONDS, imu)
            try:
                records.append(measurement.judge(f"start {first}, IMU {imu}", folder, folder / "groundtruth.csv", "--no-loops"))
                print("{name}: ATE {ate_m:.3f} m of {path_m:.2f}, NEES {nees:.1f}".format(**records[-1]), flush=True)
            except RuntimeError as error:
                print(f"start {first}, IMU {imu}: FAILED: {error}", flush=True)
                records.append({"name": f"start {first}, IMU {imu}", "failed": str(error)})
    return records


def walks(measurement, seeds):
    records = []
    for seed in seeds:
        folder = measurement.out / "walk"
        rest = REST_S if seed % 2 == 0 else 0
        measurement.call("synth", "--out", folder, "--imu", "--tracks", "--size", "640x480", "--rate", WALK_RATE_HZ,
                         "--frames", (WALK_SECONDS + rest) * WALK_RATE_HZ, "--rest", rest, "--seed", seed)
        records.append(measurement.judge(f"walk {seed}", folder, folder / "groundtruth.csv"))
        print("walk {0}: ATE {ate_m:.3f} m, NEES {nees:.1f}".format(seed, **records[-1]), flush=True)
    return records


def summary(records):
    def over(key):
        values = [r[key] for r in records]
        return f"mean {statistics.mean(values):.3f}, median {statistics.median(values):.3f}, largest {max(values):.3f}"
    diverged = [r["name"] for r in records if r["ate_max_m"] > DIVERGED_M]
    return [f"- ATE m: {over('ate_m')}", f"- tilt deg: {over('tilt_deg')}", f"- NEES of 6: {over('nees')}",
            f"- scale off: mean {statistics.mean(abs(r['scale'] - 1) for r in records):.4f}",
            f"- diverged (an error over {DIVERGED_M:g} m): {', '.join(diverged) or 'none'} of {len(records)}"]


def main():
    parser = argparse.ArgumentParser(prog="measure.sh --only vio", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/bin/plumbline"), metavar="FILE")
    parser.add_argument("--walks", type=int, default=len(WALK_SEEDS), metavar="N", help="simulated walks (default 50)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="an option of the filter")
    parser.add_argument("--out", default=str(ROOT / "build/measure/vio"), metavar="DIR")
    arguments = parser.parse_args()
    measurement = Measurement(arguments)
    lines = [f"Commit {commit()}" + "".join(f", `{setting}`" for setting in arguments.set) + ".", ""]
    results = {"commit": commit(), "settings": arguments.set}
    data = pathlib.Path(os.environ.get("PLUMBLINE_DATA", ROOT.parent / "shared")).resolve() / "data"
    if data.exists():
        results["recordings"] = recordings(measurement, data)
        lines += ["## Recordings", ""] + table(results["recordings"]) + [""]
        results["loops"] = loops(measurement, data)
        if results["loops"]:
            listed = " ".join(f"{error:.2f}" for error in results["loops"])
            lines += [f"**tango_lc**, 20 % of the tracks dropped, seeds 1 to 10, loop error m: {listed}; "
                      f"median {statistics.median(results['loops']):.2f}, largest {max(results['loops']):.2f}.", ""]
        results["starts"] = starts(measurement, data)
        good = [record for record in results["starts"] if "failed" not in record]
        if good:
            lines += [f"## Kitchen, {START_SECONDS} s from every 40th image on, with three IMUs", "",
                      f"- without a pose: {len(results['starts']) - len(good)} of {len(results['starts'])}"]
            lines += summary(good) + [""] + table(good) + [""]
    if arguments.walks > 0:
        results["walks"] = walks(measurement, list(WALK_SEEDS)[:arguments.walks])
        lines += [f"## {len(results['walks'])} simulated walks of {WALK_SECONDS} s", ""]
        lines += summary(results["walks"]) + [""] + table(results["walks"]) + [""]
    (measurement.out / "tables.md").write_text("\n".join(lines))
    (measurement.out / "results.json").write_text(json.dumps(results, indent=1))
    print(f"wrote {measurement.out / 'tables.md'}")


if __name__ == "__main__":
    sys.exit(main())
