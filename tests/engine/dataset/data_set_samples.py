#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes small samples in the layouts of public data sets, for the tests of their readers.

    data_set_samples.py LAYOUT FOLDER [more]

It shares nothing with the readers: the layouts are written here as the data sets' own pages and tools describe them
(see docs/data_sets.md), with the standard library alone. Frame i of every sample shows, at column x and row y,
red = 5 (x // 16) + 40 i, green = 7 (y // 16), blue = 30 i + 10 (each modulo 256); its depth is 1000 + 10 (x // 16) + i mm,
none in the first sixteen columns. Frame i has the camera at pose(i).
"""
import bz2
import math
import os
import struct
import sys
import zlib


def png(rows, width, height, depth, colour):
    """A PNG of rows of bytes: depth bits a channel, colour type 0 (grey) or 2 (RGB)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    body = b"".join(b"\0" + row for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(body, 6)) + chunk(b"IEND", b""))


def rgb(i, x, y):
    return (5 * (x // 16) + 40 * i) % 256, 7 * (y // 16) % 256, (30 * i + 10) % 256


def colour_rows(i, width, height):
    rows = []
    for y in range(height):
        if y % 16 == 0:
            row = b"".join(bytes(rgb(i, x, y)) * min(16, width - x) for x in range(0, width, 16))
        rows.append(row)
    return rows


def colour_png(i, width=640, height=480):
    return png(colour_rows(i, width, height), width, height, 8, 2)


def depth_mm(i, x):
    return 0 if x < 16 else 1000 + 10 * (x // 16) + i


def depth_png(i, width=640, height=480, units_per_mm=1, none=0):
    row = b"".join(struct.pack(">H", depth_mm(i, x) * units_per_mm or none) for x in range(width))
    return png([row] * height, width, height, 16, 0)


def rotation(i):
    """About z by 0.1 i, then about x by 0.2."""
    c, s, d, e = math.cos(0.1 * i), math.sin(0.1 * i), math.cos(0.2), math.sin(0.2)
    return [[c, -s * d, s * e], [s, c * d, -c * e], [0, e, d]]


def centre(i):
    return [0.5 * i, 0.25, 1 + 0.1 * i]


def pose(i):
    """world_from_cam, 4x4."""
    return [row + [t] for row, t in zip(rotation(i), centre(i))] + [[0, 0, 0, 1]]


def multiply(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(len(b))) for c in range(len(b[0]))] for r in range(len(a))]


def quaternion(r):
    """x, y, z, w of a rotation less than half a turn."""
    w = math.sqrt(1 + r[0][0] + r[1][1] + r[2][2]) / 2
    return (r[2][1] - r[1][2]) / (4 * w), (r[0][2] - r[2][0]) / (4 * w), (r[1][0] - r[0][1]) / (4 * w), w


def write(folder, name, content):
    path = os.path.join(folder, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())


def matrix_text(matrix, separator=" "):
    return "".join(separator.join("%.9e" % v for v in row) + "\n" for row in matrix)


def seven_scenes(folder):
    for i in range(4):
        write(folder, "redkitchen/seq-01/frame-%06d.color.png" % i, colour_png(i))
        write(folder, "redkitchen/seq-01/frame-%06d.depth.png" % i, depth_png(i, none=65535))
        write(folder, "redkitchen/seq-01/frame-%06d.pose.txt" % i, matrix_text(pose(i), "\t "))
    write(folder, "redkitchen/TrainSplit.txt", "sequence1\n")


def tum_line(stamp, matrix):
    return " ".join([stamp] + ["%.6f" % row[3] for row in matrix[:3]] + ["%.9f" % v for v in quaternion(matrix)]) + "\n"


def tum_rgbd(folder, name="rgbd_dataset_freiburg3_sample"):
    """Depth comes 5 ms after its image, that of image 2 25 ms before it; poses come at 100 Hz and stop before image 3."""
    root = os.path.join(folder, name)
    lists = {"rgb": "# color images\n# file: 'sample.bag'\n# timestamp filename\n",
             "depth": "# depth maps\n# file: 'sample.bag'\n# timestamp filename\n"}
    for i in range(4):
        stamp = "1341845688.%06d" % (100000 + 33333 * i)
        write(root, "rgb/%s.png" % stamp, colour_png(i))
        lists["rgb"] += "%s rgb/%s.png\n" % (stamp, stamp)
        other = "1341845688.%06d" % (100000 + 33333 * i + (-25000 if i == 2 else 5000))
        write(root, "depth/%s.png" % other, depth_png(i, units_per_mm=5))
        lists["depth"] += "%s depth/%s.png\n" % (other, other)
    for kind, text in lists.items():
        write(root, kind + ".txt", text)
    truth = "# ground truth trajectory\n# file: 'sample.bag'\n# timestamp tx ty tz qx qy qz qw\n"
    for k in range(9):  # at 0.095 + 0.01 k; frame i is at 0.1 + 0.033333 i, so that no stamp is that of an image
        t = (0.01 * k - 0.005) / 0.033333
        truth += tum_line("1341845688.%04d" % (950 + 100 * k), pose(t))
    write(root, "groundtruth.txt", truth)
    write(root, "accelerometer.txt", "# accelerometer data\n# timestamp ax ay az\n1341845688.1 0.1 9.7 -1.2\n")


def icl_nuim(folder):
    """The renderer's world and camera have y up: what is at pose(i) in right-handed axes, mirrored in y on both sides."""
    mirror = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    root = os.path.join(folder, "living_room_traj2_frei_png")
    lists = truth = ""
    for n in range(12):
        i = n % 4
        write(root, "rgb/%d.png" % n, colour_png(i))
        write(root, "depth/%d.png" % n, depth_png(i, units_per_mm=5))
        lists += "%d depth/%d.png %d rgb/%d.png\n" % (n, n, n, n)
        if n > 0:  # the ground truth begins with 1
            truth += tum_line("%d" % n, multiply(mirror, multiply(pose(n), mirror)))
    write(root, "associations.txt", lists)
    write(root, "livingRoom2.gt.freiburg", truth)


def kitchen_as_seven_scenes(folder, kitchen, count):
    """Frames of a sequence in Plumbline's layout (with OpenCV, which decodes its JPEG)."""
    import cv2
    import numpy
    poses = {}
    with open(os.path.join(kitchen, "trajectory.txt")) as file:
        for line in file:
            if not line.startswith("#"):
                numbers = [float(v) for v in line.split()]
                poses[round(numbers[0] * 30)] = numbers[1:]
    for i in range(0, 10 * int(count), 10):
        stem = os.path.join(folder, "seq-01", "frame-%06d" % i)
        os.makedirs(os.path.dirname(stem), exist_ok=True)
        cv2.imwrite(stem + ".color.png", cv2.imread(os.path.join(kitchen, "color", "%06d.jpg" % i)))
        depth = cv2.imread(os.path.join(kitchen, "depth", "%06d.png" % i), cv2.IMREAD_UNCHANGED)
        depth[depth == 0] = 65535
        cv2.imwrite(stem + ".depth.png", depth)
        x, y, z, qx, qy, qz, qw = poses[i]
        matrix = numpy.array([
            [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw), x],
            [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw), y],
            [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy), z], [0, 0, 0, 1]])
        write(folder, "seq-01/frame-%06d.pose.txt" % i, matrix_text(matrix.tolist(), "\t"))


class Bag:
    """A bag of format 2.0, as wiki.ros.org/Bags/Format/2.0 has it."""

    def __init__(self, compression="none"):
        self.compression, self.topics, self.chunks, self.messages = compression, [], [], []

    @staticmethod
    def record(fields, data):
        header = b"".join(struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value
                          for name, value in fields)
        return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data

    @staticmethod
    def time(ns):
        return struct.pack("<II", ns // 10**9, ns % 10**9)

    def add(self, topic, kind, ns, data):
        if (topic, kind) not in self.topics:
            self.topics.append((topic, kind))
        self.messages.append((self.topics.index((topic, kind)), ns, data))

    def end_chunk(self):
        self.chunks.append(self.messages)
        self.messages = []

    def connection(self, number):
        topic, kind = self.topics[number]
        data = self.record([("topic", topic.encode()), ("type", kind.encode()), ("md5sum", b"*"),
                            ("message_definition", b"")], b"")[4:-4]
        return self.record([("op", b"\7"), ("conn", struct.pack("<I", number)), ("topic", topic.encode())], data)

    def bytes(self):
        magic, body, infos = b"#ROSBAG V2.0\n", b"", []
        start = len(magic) + 4096 + 8
        for messages in self.chunks:
            plain, index = b"", {}
            for number, ns, data in messages:
                if number not in index:
                    plain += self.connection(number)
                index.setdefault(number, []).append((ns, len(plain)))
                plain += self.record([("op", b"\2"), ("conn", struct.pack("<I", number)), ("time", self.time(ns))], data)
            infos.append((start + len(body), messages, index))
            packed = bz2.compress(plain) if self.compression == "bz2" else plain
            body += self.record([("op", b"\5"), ("compression", self.compression.encode()),
                                 ("size", struct.pack("<I", len(plain)))], packed)
            for number, entries in index.items():
                body += self.record([("op", b"\4"), ("ver", struct.pack("<I", 1)), ("conn", struct.pack("<I", number)),
                                     ("count", struct.pack("<I", len(entries)))],
                                    b"".join(self.time(ns) + struct.pack("<I", at) for ns, at in entries))
        tail = b"".join(self.connection(n) for n in range(len(self.topics)))
        for place, messages, index in infos:
            tail += self.record([("op", b"\6"), ("ver", struct.pack("<I", 1)), ("chunk_pos", struct.pack("<Q", place)),
                                 ("start_time", self.time(min(m[1] for m in messages))),
                                 ("end_time", self.time(max(m[1] for m in messages))),
                                 ("count", struct.pack("<I", len(index)))],
                                b"".join(struct.pack("<II", n, len(e)) for n, e in index.items()))
        fields = [("op", b"\3"), ("index_pos", struct.pack("<Q", start + len(body))),
                  ("conn_count", struct.pack("<I", len(self.topics))), ("chunk_count", struct.pack("<I", len(infos)))]
        bare = len(self.record(fields, b"")) - 8
        return magic + self.record(fields, b" " * (4096 - bare)) + body + tail


def ros_text(text):
    data = text if isinstance(text, bytes) else text.encode()
    return struct.pack("<I", len(data)) + data


def ros_header(ns, frame, number=0):
    return struct.pack("<I", number) + Bag.time(ns) + ros_text(frame)


def ros_image(ns, frame, width, height, encoding, step, data):
    return (ros_header(ns, frame) + struct.pack("<II", height, width) + ros_text(encoding) + struct.pack("<BI", 0, step) +
            ros_text(data))


def ros_transforms(*transforms):
    message = struct.pack("<I", len(transforms))
    for ns, parent, child, matrix in transforms:
        message += ros_header(ns, parent) + ros_text(child) + struct.pack("<3d", *(row[3] for row in matrix[:3]))
        message += struct.pack("<4d", *quaternion(matrix))
    return message


def rigid_inverse(m):
    turned = [[m[c][r] for c in range(3)] for r in range(3)]
    moved = [-sum(turned[r][k] * m[k][3] for k in range(3)) for r in range(3)]
    return [turned[r] + [moved[r]] for r in range(3)] + [[0, 0, 0, 1]]


BASE_FROM_CAM = [[0, 0, 1, 0.3], [-1, 0, 0, 0.1], [0, -1, 0, 1.2], [0, 0, 0, 1]]
BASE_FROM_IMU = [[1, 0, 0, -0.5], [0, 1, 0, 0], [0, 0, 1, 0.25], [0, 0, 0, 1]]
BAG_START = 1600000000 * 10**9


def ros_bag(folder, compression="none", name="sample.bag", width=160, height=120):
    """Four images at 10 Hz, which are recorded 7 ms after their stamps; a second camera, compressed, with two images."""
    width, height = int(width), int(height)
    bag = Bag(compression)

    def add(topic, kind, ns, data):
        bag.add(topic, kind, ns + 7 * 10**6, data)

    still = [(BAG_START, "base", "cam0_optical", BASE_FROM_CAM), (BAG_START, "base", "imu0", BASE_FROM_IMU)]
    add("/tf_static", "tf2_msgs/TFMessage", BAG_START, ros_transforms(*still))
    for i in range(4):
        ns = BAG_START + i * 10**8
        pixels = b"".join(b"".join(bytes(rgb(i, x, y)[::-1]) for x in range(width)) + b"pad!" for y in range(height))
        add("/cam0/image_raw", "sensor_msgs/Image", ns,
            ros_image(ns, "/cam0_optical", width, height, "bgr8", 3 * width + 4, pixels))
        add("/cam0/camera_info", "sensor_msgs/CameraInfo", ns,
            ros_header(ns, "cam0_optical") + struct.pack("<II", height, width) + ros_text("plumb_bob") +
            struct.pack("<I5d", 5, -0.2, 0.05, 0.001, -0.002, 0) + struct.pack("<9d", 130, 0, 81, 0, 131, 61, 0, 0, 1) +
            struct.pack("<9d", 1, 0, 0, 0, 1, 0, 0, 0, 1) + struct.pack("<12d", 120, 0, 80, 0, 0, 121, 60, 0, 0, 0, 1, 0) +
            struct.pack("<IIIIIIB", 0, 0, 0, 0, 0, 0, 0))
        depth = b"".join(struct.pack("<f", depth_mm(i, x) / 1000 if depth_mm(i, x) else math.nan) for x in range(width))
        add("/cam0/depth/image", "sensor_msgs/Image", ns + 3 * 10**6,
            ros_image(ns + 3 * 10**6, "cam0_optical", width, height, "32FC1", 4 * width, depth * height))
        if i < 2:
            add("/cam1/image_raw/compressed", "sensor_msgs/CompressedImage", ns,
                ros_header(ns, "cam1") + ros_text("rgb8; png compressed bgr8") + ros_text(colour_png(i, width, height)))
        for k in range(20):  # 200 Hz
            at = ns + k * 5 * 10**6
            add("/imu0", "sensor_msgs/Imu", at, ros_header(at, "imu0") + struct.pack("<4d9d", 0, 0, 0, 1, *[0] * 9) +
                struct.pack("<3d9d", 0.01 * k, 0.02, -0.03, *[0] * 9) + struct.pack("<3d9d", 0.1, 0.2, 9.81, *[0] * 9))
        if i < 3:
            for half in (0, 1):
                at = i + half / 2
                add("/tf", "tf2_msgs/TFMessage", ns + half * 5 * 10**7, ros_transforms(
                    (ns + half * 5 * 10**7, "world", "base", multiply(pose(at), rigid_inverse(BASE_FROM_CAM)))))
        if i == 1:
            bag.end_chunk()
    bag.end_chunk()
    write(folder, name, bag.bytes())


LAYOUTS = {f.__name__: f for f in (seven_scenes, tum_rgbd, icl_nuim, ros_bag, kitchen_as_seven_scenes)}

if __name__ == "__main__":
    LAYOUTS[sys.argv[1]](*sys.argv[2:])
