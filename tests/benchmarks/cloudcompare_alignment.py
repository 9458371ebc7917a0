#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""CloudCompare's ICP on the cases of alignment_benchmark.

  alignment_benchmark 100 FOLDER; cloudcompare_alignment.py FOLDER [overlap percent [starts]]
  cloudcompare_alignment.py --picked FOLDER [overlap percent]

The first: the model moves, rotation about z only (-ROT Z), from where alignment_benchmark starts it or from `starts`
azimuths, of which the one with the largest share of model points within 2 cm of the scan counts (as for Open3D).

The second is how its users work: four points are picked on scan and model (here: the true ones, seen in the scan and
far apart, each off by 1 cm along each axis as a hand picks them), the scan is aligned by them and cropped to 5 cm around
the model, and then the scan moves onto the model, which stays (-ICP -OVERLAP 60); once free, once with -ROT Z. So the
true place and azimuth are given to a centimetre or two, and the crop is made by somebody who knows the object.

Success: under 2 cm and 2 degrees. Times are CloudCompare's own (wall), less those of the same run without -ICP. Needs
cloudcompare, python3-numpy and python3-scipy.
"""
import glob, math, os, re, subprocess, sys
import numpy
from scipy.spatial import cKDTree

picked = sys.argv[1] == "--picked"
words = sys.argv[2:] if picked else sys.argv[1:]
folder = words[0]
overlap = words[1] if len(words) > 1 else "60" if picked else "50"
starts = int(words[2]) if len(words) > 2 else 1


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


def fit_pairs(source, target):
    """The rigid motion of least squares from source to target: Kabsch."""
    a, b = source.mean(axis=0), target.mean(axis=0)
    u, _, v = numpy.linalg.svd((source - a).T @ (target - b))
    turn = v.T @ numpy.diag([1, 1, numpy.sign(numpy.linalg.det(v.T @ u.T))]) @ u.T
    motion = numpy.eye(4)
    motion[:3, :3], motion[:3, 3] = turn, b - turn @ a
    return motion


def far_apart(points, count):
    """Indices of points that are as far from one another as it goes, one after another."""
    chosen = [int(numpy.argmax(numpy.linalg.norm(points - points.mean(axis=0), axis=1)))]
    distance = numpy.full(len(points), numpy.inf)
    while len(chosen) < count:
        distance = numpy.minimum(distance, numpy.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(numpy.argmax(distance)))
    return chosen


def align_picked(base, truth, about_z, generator):
    """The motion of the model that the scan's onto it says, or none, and the seconds it took."""
    model, scan = read_points(base + "_model.ply"), read_points(base + "_scan.ply")
    moved = model @ truth[:3, :3].T + truth[:3, 3]
    near, which = cKDTree(scan).query(moved)
    seen = numpy.flatnonzero(near < 0.01)
    if len(seen) < 4:
        return None, 0.0
    seen = seen[far_apart(model[seen], 4)]
    in_model = model[seen] + 0.01 * generator.standard_normal((4, 3))
    in_scan = scan[which[seen]] + 0.01 * generator.standard_normal((4, 3))
    if about_z:  # -ROT Z keeps a tilt, so the picks must not make one: turn about z and translation
        a, b = in_scan - in_scan.mean(axis=0), in_model - in_model.mean(axis=0)
        rough = turn_about(numpy.zeros(3), math.atan2(numpy.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]),
                                                      numpy.sum(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])))
        rough[:3, 3] = in_model.mean(axis=0) - rough[:3, :3] @ in_scan.mean(axis=0)
    else:
        rough = fit_pairs(in_scan, in_model)
    placed = scan @ rough[:3, :3].T + rough[:3, 3]
    low, high = model.min(axis=0) - 0.05, model.max(axis=0) + 0.05
    name = base + "_crop"
    write_points(name + ".ply", placed[numpy.all((placed > low) & (placed < high), axis=1)])
    both = ["-O", name + ".ply", "-O", base + "_model.ply"]
    seconds = run(both + ["-ICP", "-OVERLAP", overlap] + (["-ROT", "Z"] if about_z else [])) - run(both)
    icp = read_matrix(name + "_REGISTRATION_MATRIX.txt")
    for old in glob.glob(name + "*"):
        os.remove(old)
    return (None if icp is None else numpy.linalg.inv(icp @ rough)), seconds


def report(name, rows):
    good, middle = sum(t < 0.02 and a < 2 for t, a, _, _ in rows), len(rows) // 2
    median = [sorted(row[i] for row in rows)[middle] for i in range(3)]
    print(f"CloudCompare {name}: {good} of {len(rows)}, median {1000 * median[0]:.1f} mm, {median[1]:.2f} deg, "
          f"tilt: median {median[2]:.1e}, worst {max(row[2] for row in rows):.1e} rad, "
          f"{1000 * sum(row[3] for row in rows) / len(rows):.0f} ms")


def judge(case, moved, seconds):
    truth, center, order = case
    if moved is None:
        return 1e9, 180, 90, seconds
    translation = numpy.linalg.norm(moved[:3, :3] @ center + moved[:3, 3] - truth[:3, :3] @ center - truth[:3, 3])
    turn = math.degrees(math.atan2(moved[1][0], moved[0][0]) - math.atan2(truth[1][0], truth[0][0]))
    step = 360 / order if order else 1e-9
    azimuth = abs((turn + step / 2) % step - step / 2)
    return translation, azimuth, math.atan2(math.hypot(moved[0][2], moved[1][2]), moved[2][2]), seconds


cases = []
for truth_file in sorted(glob.glob(os.path.join(folder, "case*[0-9].txt")), key=lambda f: int(re.findall(r"\d+", f)[-1])):
    lines = open(truth_file).read().splitlines()
    cases.append((truth_file[:-4], (numpy.array([x.split() for x in lines[:4]], float),
                                    numpy.array(lines[4].split(), float), int(lines[5]))))
if picked:
    for about_z in (False, True):
        generator = numpy.random.default_rng(1)
        rows = [judge(case, *align_picked(base, case[0], about_z, generator)) for base, case in cases]
        for (base, _), row in zip(cases, rows):
            print(f"  {os.path.basename(base):10s} {100 * row[0]:7.2f} cm {row[1]:7.2f} deg")
        report(f"picked and cropped, scan onto model, overlap {overlap}" + (" -ROT Z" if about_z else ""), rows)
else:
    report(f"-ICP -ROT Z -OVERLAP {overlap}, {starts} starts",
           [judge(case, *align(base, case[1])) for base, case in cases])
