#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""CloudCompare's ICP with its rotation about z (-ROT Z) on the cases of alignment_benchmark.

  alignment_benchmark 100 FOLDER; cloudcompare_alignment.py FOLDER [overlap percent [starts]]

The model starts where alignment_benchmark starts it, or from `starts` azimuths of which the one with the largest share
of model points within 2 cm of the scan counts (as for Open3D). Success: under 2 cm and 2 degrees. Times are
CloudCompare's own (wall), less those of the same run without -ICP. Needs python3-numpy and python3-scipy.
"""
import glob, math, os, re, subprocess, sys
import numpy
from scipy.spatial import cKDTree

folder = sys.argv[1]
overlap = sys.argv[2] if len(sys.argv) > 2 else "50"
starts = int(sys.argv[3]) if len(sys.argv) > 3 else 1


def read_points(path):
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    count = int(re.search(rb"element vertex (\d+)", data[:end]).group(1))
    return numpy.frombuffer(data, "<f4", 3 * count, end).reshape(-1, 3).astype(float)


def write_points(path, points):
    with open(path, "wb") as file:
        file.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
                   b"property float z\nend_header\n" % len(points))
        file.write(points.astype("<f4").tobytes())


def turn_about(center, angle):
    c, s = math.cos(angle), math.sin(angle)
    turn = numpy.eye(4)
    turn[:2, :2] = [[c, -s], [s, c]]
    turn[:3, 3] = center - turn[:3, :3] @ center
    return turn


def run(arguments):
    """The seconds that CloudCompare says its commands took."""
    command = ["CloudCompare", "-SILENT", "-NO_TIMESTAMP", "-AUTO_SAVE", "OFF"] + arguments
    log = subprocess.run(command, env={**os.environ, "QT_QPA_PLATFORM": "offscreen"}, stdout=subprocess.PIPE,
                         stderr=subprocess.DEVNULL, check=False, text=True).stdout
    found = re.search(r"finished in ([0-9.]+) s", log)
    return float(found.group(1)) if found else 0.0


def read_matrix(path):
    rows = [line.split() for line in open(path).read().splitlines()[:4]] if os.path.exists(path) else []
    return numpy.array(rows, float) if len(rows) == 4 else None  # none: it gave up


def align(base, center):
    """The best motion of the model, or none, and the seconds it took."""
    model, scan = read_points(base + "_model.ply"), read_points(base + "_scan.ply")
    turns = [turn_about(center, 2 * math.pi * k / starts) for k in range(starts)]
    names = [f"{base}_turned{k}" for k in range(starts)]
    load, register = [], []
    for name, turn in zip(names, turns):
        write_points(name + ".ply", model @ turn[:3, :3].T + turn[:3, 3])
        both = ["-O", name + ".ply", "-O", base + "_scan.ply"]
        load += both + ["-CLEAR"]
        register += both + ["-ICP", "-ROT", "Z", "-OVERLAP", overlap, "-CLEAR"]
    seconds = run(register) - run(load)
    tree, best, most = cKDTree(scan), None, -1.0
    for name, turn in zip(names, turns):
        moved = read_matrix(name + "_REGISTRATION_MATRIX.txt")
        if moved is not None:
            moved = moved @ turn
            share = numpy.mean(tree.query(model @ moved[:3, :3].T + moved[:3, 3], distance_upper_bound=0.02)[0] < 1)
            if share > most:
                most, best = share, moved
    for name in names:
        for old in glob.glob(name + "*"):
            os.remove(old)
    return best, seconds


rows = []
for truth_file in sorted(glob.glob(os.path.join(folder, "case*[0-9].txt"))):
    lines = open(truth_file).read().splitlines()
    truth, center, order = numpy.array([x.split() for x in lines[:4]], float), numpy.array(lines[4].split(), float), int(lines[5])
    moved, seconds = align(truth_file[:-4], center)
    if moved is None:
        rows.append((1e9, 180, 90, seconds))
        continue
    translation = numpy.linalg.norm(moved[:3, :3] @ center + moved[:3, 3] - truth[:3, :3] @ center - truth[:3, 3])
    turn = math.degrees(math.atan2(moved[1][0], moved[0][0]) - math.atan2(truth[1][0], truth[0][0]))
    step = 360 / order if order else 1e-9
    azimuth = abs((turn + step / 2) % step - step / 2)
    tilt = math.atan2(math.hypot(moved[0][2], moved[1][2]), moved[2][2])
    rows.append((translation, azimuth, tilt, seconds))
good, middle = sum(t < 0.02 and a < 2 for t, a, _, _ in rows), len(rows) // 2
median = [sorted(row[i] for row in rows)[middle] for i in range(3)]
print(f"CloudCompare -ICP -ROT Z -OVERLAP {overlap}, {starts} starts: {good} of {len(rows)}, "
      f"median {1000 * median[0]:.1f} mm, {median[1]:.2f} deg, tilt: median {median[2]:.1e}, "
      f"worst {max(row[2] for row in rows):.1e} rad, {1000 * sum(row[3] for row in rows) / len(rows):.0f} ms")
