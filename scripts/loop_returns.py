# SPDX-License-Identifier: Apache-2.0
"""How well a trajectory comes back: the figures "at a return" of docs/algorithms/vio.md.

For each fifth image, the image at least GAP seconds older that was taken nearest to it in truth (within 1.5 m and 30 degrees): how far the
later one's position, seen from the older one, is off. `vio SEQUENCE --out T.txt` makes the first file; the second is groundtruth.csv.
"""
import argparse
import bisect
import math

REACH_M, TURN_DEG, M_PER_DEG = 1.5, 30, 1 / 60


def rotation(x, y, z, w):
    return ((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))


class Pose:
    """A row: stamp, position, quaternion x y z w."""

    def __init__(self, row):
        self.stamp, self.position, self.rotation = row[0], row[1:4], rotation(*row[4:8])

    def step_to(self, other):
        way = [b - a for a, b in zip(self.position, other.position)]
        return [sum(self.rotation[i][j] * way[i] for i in range(3)) for j in range(3)]

    def turn_deg(self, other):
        trace = sum(a * b for one, two in zip(self.rotation, other.rotation) for a, b in zip(one, two))
        return math.degrees(math.acos(max(-1, min(1, (trace - 1) / 2))))


def read(file, separator):
    rows = []
    for line in open(file):
        if line[0].isdigit() or line[0] == "-":
            rows.append([float(word) for word in line.strip().split(separator)[:8]])
    return rows


def at(rows, stamps, stamp):
    after = min(max(bisect.bisect_left(stamps, stamp), 1), len(stamps) - 1)
    one, two = rows[after - 1], rows[after]
    share = (stamp - one[0]) / (two[0] - one[0])
    return Pose([a + share * (b - a) for a, b in zip(one[:4], two[:4])] + (two if share > 0.5 else one)[4:8])


def returns(estimate, truth, gap_s):
    errors = []
    for j in range(0, len(truth), 5):
        nearest = None
        for i in range(0, j, 3):
            if estimate[j].stamp - estimate[i].stamp < gap_s:
                break
            distance = math.dist(truth[i].position, truth[j].position)
            if distance > REACH_M or truth[i].turn_deg(truth[j]) > TURN_DEG:
                continue
            off = distance + M_PER_DEG * truth[i].turn_deg(truth[j])
            if nearest is None or off < nearest[0]:
                nearest = off, i
        if nearest:
            i = nearest[1]
            errors.append(math.dist(estimate[i].step_to(estimate[j]), truth[i].step_to(truth[j])))
    return errors


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("estimate")
    parser.add_argument("truth")
    parser.add_argument("--gap", type=float, default=15, metavar="S")
    arguments = parser.parse_args()
    estimate = [Pose(row) for row in read(arguments.estimate, None)]
    rows = read(arguments.truth, ",")
    stamps = [row[0] for row in rows]
    errors = returns(estimate, [at(rows, stamps, pose.stamp) for pose in estimate], arguments.gap)
    if not errors:
        return print("no returns")
    ordered = sorted(errors)
    print(f"{len(errors)} returns: median {ordered[len(errors) // 2]:.3f} m, 90 % {ordered[len(errors) * 9 // 10]:.3f}, "
          f"largest {ordered[-1]:.3f}; last {errors[-1]:.3f}")


if __name__ == "__main__":
    main()
