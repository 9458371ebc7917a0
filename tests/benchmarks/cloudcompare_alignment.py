#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""CloudCompare's ICP with its rotation about z (-ROT Z) on the cases of alignment_benchmark.

  alignment_benchmark 100 FOLDER; cloudcompare_alignment.py FOLDER [overlap percent]

The model starts where alignment_benchmark starts it; success: under 2 cm and 2 degrees.
"""
import glob, math, os, subprocess, sys, time

folder, overlap = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "50"


def read_matrix(lines):
    return [[float(x) for x in line.split()] for line in lines[:4]]


def apply(m, p):
    return [sum(m[r][c] * p[c] for c in range(3)) + m[r][3] for r in range(3)]


rows = []
for truth_file in sorted(glob.glob(os.path.join(folder, "case*[0-9].txt"))):
    base = truth_file[:-4]
    lines = open(truth_file).read().splitlines()
    truth, center, order = read_matrix(lines), [float(x) for x in lines[4].split()], int(lines[5])
    for old in glob.glob(base + "_model_*"):
        os.remove(old)
    begin = time.time()
    subprocess.run(["CloudCompare", "-SILENT", "-NO_TIMESTAMP", "-AUTO_SAVE", "OFF", "-O", base + "_model.ply",
                    "-O", base + "_scan.ply", "-ICP", "-ROT", "Z", "-OVERLAP", overlap],
                   env={**os.environ, "QT_QPA_PLATFORM": "offscreen"}, stdout=subprocess.DEVNULL, check=False)
    seconds = time.time() - begin
    found = glob.glob(base + "_model_*MATRIX*.txt")
    if not found:
        rows.append((1e9, 180, 90, seconds))
        continue
    lines = open(found[0]).read().splitlines()
    if len(lines) < 4:  # it gave up
        rows.append((1e9, 180, 90, seconds))
        continue
    moved = read_matrix(lines)
    translation = math.dist(apply(moved, center), apply(truth, center))
    turn = math.degrees(math.atan2(moved[1][0], moved[0][0]) - math.atan2(truth[1][0], truth[0][0]))
    step = 360 / order if order else 1e-9
    azimuth = abs((turn + step / 2) % step - step / 2)
    tilt = math.degrees(math.acos(max(-1, min(1, moved[2][2]))))
    rows.append((translation, azimuth, tilt, seconds))
good = sum(t < 0.02 and a < 2 for t, a, _, _ in rows)
middle = len(rows) // 2
print(f"CloudCompare -ICP -ROT Z -OVERLAP {overlap}, the given start: {good} of {len(rows)}, "
      f"median {1000 * sorted(r[0] for r in rows)[middle]:.1f} mm, {sorted(r[1] for r in rows)[middle]:.2f} deg, "
      f"worst tilt {max(r[2] for r in rows):.1e} deg, {sum(r[3] for r in rows) / len(rows):.2f} s with reading")
