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


def numbers_text(numbers):
    return " ".join("%.12e" % v for v in numbers)


def flat(matrix):
    return [v for row in matrix for v in row]


def rigid(*rows):
    return [list(row) for row in rows] + [[0, 0, 0, 1]]


# A camera that looks ahead, 0.1 m before, 0.05 m right of and 0.3 m below the velodyne, whose axes are x forward, y left, z up.
KITTI_CAM0_FROM_VELO = rigid((0, -1, 0, -0.05), (0, 0, -1, -0.3), (1, 0, 0, -0.1))
KITTI_VELO_FROM_IMU = rigid((1, 0, 0, -0.8), (0, 1, 0, 0.3), (0, 0, 1, -0.75))
KITTI_RECT = [[math.cos(0.01), -math.sin(0.01), 0], [math.sin(0.01), math.cos(0.01), 0], [0, 0, 1]]
KITTI_WIDTH, KITTI_HEIGHT = 160, 48


def kitti_projection(camera):
    """P of the cameras 0 to 3: f 100, centre (80, 24); cameras 2 and 3 stand 6 cm left and 47 cm right of camera 0."""
    shift = {0: 0, 1: -0.54, 2: 0.06, 3: -0.47}[camera]
    return [100, 0, 80, 100 * shift, 0, 100, 24, 0, 0, 0, 1, 0]


def kitti_raw(folder, kind="sync", oxts_rate=1):
    """Five images; the vehicle drives north-east at 5 m/s over a plane and turns left. One car is parked, one drives."""
    day = os.path.join(folder, "2011_09_26")
    drive = os.path.join(day, "2011_09_26_drive_0005_" + kind)
    lines = ["calib_time: 09-Jan-2012 13:57:47", "corner_dist: 9.950000e-02"]
    for c in range(4):
        lines += ["S_%02d: 1.392000e+03 5.120000e+02" % c, "S_rect_%02d: %.6e %.6e" % (c, KITTI_WIDTH, KITTI_HEIGHT),
                  "R_rect_%02d: " % c + numbers_text(flat(KITTI_RECT)), "P_rect_%02d: " % c + numbers_text(kitti_projection(c))]
    write(day, "calib_cam_to_cam.txt", "\n".join(lines) + "\n")
    for name, m in (("calib_velo_to_cam.txt", KITTI_CAM0_FROM_VELO), ("calib_imu_to_velo.txt", KITTI_VELO_FROM_IMU)):
        write(day, name, "calib_time: 15-Mar-2012 11:37:16\nR: %s\nT: %s\n" % (
            numbers_text(flat([row[:3] for row in m[:3]])), numbers_text([row[3] for row in m[:3]])))
    stamps = ""
    for i in range(5):
        second = 59.964389445 - 0.2 + 0.1 * i
        stamps += "2011-09-26 13:%02d:%012.9f\n" % (2 + (second >= 60), second - 60 * (second >= 60))
        write(drive, "image_02/data/%010d.png" % i, colour_png(i, KITTI_WIDTH, KITTI_HEIGHT))
    write(drive, "image_02/timestamps.txt", stamps)
    oxts_stamps, radius, lat0, lon0 = "", 6378137.0, 49.0, 8.4
    for k in range(0, 4 * int(oxts_rate) + 1):
        i = k / int(oxts_rate)
        east, north, yaw = kitti_place(i)
        scale = radius * math.cos(math.radians(lat0))
        y0 = math.log(math.tan(math.radians(90 + lat0) / 2))
        lat = 2 * math.degrees(math.atan(math.exp(y0 + north / scale))) - 90
        lon = lon0 + math.degrees(east / scale)
        packet = [lat, lon, 116.5 + 0.1 * i, 0.02, -0.01, yaw, 3.5, 3.5, 5, 0, 0, 0.1 * i, 0.2, 9.8, 0.3, 0.4, 9.9, 0.01, 0.02,
                  0.03 * i, 0.04, 0.05, 0.06, 0.5, 0.05, 4, 10, 5, 5, 0]
        write(drive, "oxts/data/%010d.txt" % k, " ".join("%.15g" % v for v in packet) + "\n")
        # Synchronised packets belong to images by number: their own stamps are up to some tens of milliseconds off.
        second = 59.964389445 - 0.2 + 0.1 * i + (0.03 if kind == "sync" else 0)
        oxts_stamps += "2011-09-26 13:%02d:%012.9f\n" % (2 + (second >= 60), second - 60 * (second >= 60))
    write(drive, "oxts/timestamps.txt", oxts_stamps)
    write(drive, "tracklet_labels.xml", tracklets([kitti_tracklet("Car", 0, range(5), (20, 8, 116.5), 0.7, (0, 0)),
                                                   kitti_tracklet("Van", 1, range(1, 5), (10, 2, 116.5), 0.1, (1, 0)),
                                                   kitti_tracklet("Pedestrian", 2, range(4, 7), (12, 3, 116.5), 0, (0, 0))]))


def kitti_place(i):
    return 0.35 * i, 0.35 * i, math.pi / 4 + 0.05 * i


def kitti_world_from_velo(i):
    """In a world with x east, y north, z up; its origin is that of the first packet but for the height."""
    east, north, yaw = kitti_place(i)
    roll, pitch = 0.02, -0.01
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw, pitch, roll) for f in (math.cos, math.sin))
    turn = multiply(multiply([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]], [[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]),
                    [[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    world_from_imu = rigid(*(row + [t] for row, t in zip(turn, (east, north, 0.1 * i))))
    return multiply(world_from_imu, rigid_inverse(KITTI_VELO_FROM_IMU))


def kitti_tracklet(kind, number, frames, place, yaw, speed):
    """Of an object that stands or drives on the plane 1.7 m below the first packet, in the velodyne's frame."""
    poses = []
    for i in frames:
        in_world = [[place[0] + speed[0] * i], [place[1] + speed[1] * i], [-1.7], [1]]
        x, y, z, _ = (row[0] for row in multiply(rigid_inverse(kitti_world_from_velo(i)), in_world))
        m = kitti_world_from_velo(i)
        poses.append((x, y, z, yaw - math.atan2(m[1][0], m[0][0])))
    return kind, (1.5 + 0.1 * number, 1.8, 4.2), frames[0], poses


def tracklets(items):
    xml = """<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>
<!DOCTYPE boost_serialization>
<boost_serialization signature="serialization::archive" version="9">
<tracklets class_id="0" tracking_level="0" version="0">
\t<count>%d</count>
\t<item_version>1</item_version>
""" % len(items)
    for kind, (h, w, l), first, poses in items:
        xml += ("\t<item class_id=\"1\" tracking_level=\"0\" version=\"1\">\n\t\t<objectType>%s</objectType>\n\t\t<h>%.9g</h>\n"
                "\t\t<w>%.9g</w>\n\t\t<l>%.9g</l>\n\t\t<first_frame>%d</first_frame>\n\t\t<poses class_id=\"2\" "
                "tracking_level=\"0\" version=\"0\">\n\t\t\t<count>%d</count>\n\t\t\t<item_version>2</item_version>\n"
                % (kind, h, w, l, first, len(poses)))
        for x, y, z, yaw in poses:
            xml += ("\t\t\t<item class_id=\"3\" tracking_level=\"0\" version=\"2\">\n\t\t\t\t<tx>%.15g</tx>\n\t\t\t\t<ty>%.15g</ty>\n"
                    "\t\t\t\t<tz>%.15g</tz>\n\t\t\t\t<rx>0</rx>\n\t\t\t\t<ry>0</ry>\n\t\t\t\t<rz>%.15g</rz>\n\t\t\t\t<state>2</state>\n"
                    "\t\t\t\t<occlusion>0</occlusion>\n\t\t\t\t<occlusion_kf>1</occlusion_kf>\n\t\t\t\t<truncation>0</truncation>\n"
                    "\t\t\t\t<amt_occlusion>0</amt_occlusion>\n\t\t\t\t<amt_border_kf>-1</amt_border_kf>\n\t\t\t</item>\n" % (x, y, z, yaw))
        xml += "\t\t</poses>\n\t\t<finished>1</finished>\n\t</item>\n"
    return xml + "</tracklets>\n</boost_serialization>\n"


def kitti_odometry(folder, velodyne_key="Tr"):
    """Sequence 04 with grey and colour images; sequence 11, as those from 11 on, has no poses and grey images alone."""
    for sequence in ("04", "11"):
        root = os.path.join(folder, "dataset/sequences", sequence)
        lines = ["P%d: %s" % (c, numbers_text(kitti_projection(c))) for c in range(4)]
        lines.append(velodyne_key + ": " + numbers_text(flat(KITTI_CAM0_FROM_VELO[:3])))
        write(root, "calib.txt", "\n".join(lines) + "\n")
        write(root, "times.txt", "".join("%.6e\n" % (0.103736 * i) for i in range(4)))
        for i in range(4):
            write(root, "image_0/%06d.png" % i, png(grey_rows(i), KITTI_WIDTH, KITTI_HEIGHT, 8, 0))
            if sequence == "04":
                write(root, "image_2/%06d.png" % i, colour_png(i, KITTI_WIDTH, KITTI_HEIGHT))
    write(folder, "dataset/poses/04.txt", "".join(numbers_text(flat(pose(i)[:3])) + "\n" for i in range(4)))


def grey_rows(i):
    return [bytes((10 * i + y) % 256 for _ in range(KITTI_WIDTH)) for y in range(KITTI_HEIGHT)]


SCANNET_COLOR, SCANNET_DEPTH = (160, 120), (80, 60)


def scannet_matrix(width, height):
    """The depth camera sees the same as the colour camera at half its size."""
    f = 0.75 * width
    return [[f, 0, (width - 1) / 2, 0], [0, f, (height - 1) / 2, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def scannet_depth(i):
    """Of the depth camera: column x is that of the colour image at 2 x."""
    row = struct.pack("<%dH" % SCANNET_DEPTH[0], *(depth_mm(i, 2 * x) for x in range(SCANNET_DEPTH[0])))
    return row * SCANNET_DEPTH[1]


LOST = [[-math.inf] * 4] * 4


def scannet_sens(folder, depth_compression=1, stamps="rising"):
    """Frame 2 has lost its track."""
    def floats(matrix):
        return struct.pack("<16f", *flat(matrix))

    identity = [[float(r == c) for c in range(4)] for r in range(4)]
    out = struct.pack("<IQ", 4, 15) + b"StructureSensor"
    out += floats(scannet_matrix(*SCANNET_COLOR)) + floats(identity) + floats(scannet_matrix(*SCANNET_DEPTH)) + floats(identity)
    out += struct.pack("<iiIIIIfQ", 1, int(depth_compression), *SCANNET_COLOR, *SCANNET_DEPTH, 1000.0, 4)
    for i in range(4):
        color, depth = colour_png(i, *SCANNET_COLOR), scannet_depth(i)
        if int(depth_compression) == 1:
            depth = zlib.compress(depth)
        us = 5000000 + 33333 * i if stamps == "rising" else 0
        out += floats(LOST if i == 2 else pose(i)) + struct.pack("<QQQQ", us, us + 1000, len(color), len(depth)) + color + depth
    out += struct.pack("<Q", 0)  # samples of an IMU
    write(folder, "scans/scene0042_01/scene0042_01.sens", out)
    write(folder, "scans/scene0042_01/scene0042_01_vh_clean_2.ply", "ply\n")


def scannet_extracted(folder):
    root = os.path.join(folder, "scans/scene0042_01/exported")
    for i in range(12):
        write(root, "color/%d.png" % i, colour_png(i % 4, *SCANNET_COLOR))
        values = struct.unpack("<%dH" % (SCANNET_DEPTH[0] * SCANNET_DEPTH[1]), scannet_depth(i % 4))
        rows = [struct.pack(">%dH" % SCANNET_DEPTH[0], *values[y * SCANNET_DEPTH[0]:(y + 1) * SCANNET_DEPTH[0]])
                for y in range(SCANNET_DEPTH[1])]
        write(root, "depth/%d.png" % i, png(rows, *SCANNET_DEPTH, 16, 0))
        write(root, "pose/%d.txt" % i, "-inf -inf -inf -inf\n" * 4 if i == 2 else matrix_text(pose(i)))
    for kind, size in (("color", SCANNET_COLOR), ("depth", SCANNET_DEPTH)):
        write(root, "intrinsic/intrinsic_%s.txt" % kind, "\n".join(" ".join("%f" % v for v in row) for row in scannet_matrix(*size)))
        write(root, "intrinsic/extrinsic_%s.txt" % kind, matrix_text([[float(r == c) for c in range(4)] for r in range(4)]))


def scan2cad(folder):
    """A chair of ShapeNet that stands at (2, 1, 0) of the scan, its front along the scan's +y, stretched by (0.5, 0.8, 0.6);
    Scan2CAD's world is y up: the scan turned by -90 degrees about x and moved by (5, 0, 0)."""
    import json
    half = math.sqrt(0.5)
    chair = {"sym": "__SYM_NONE", "catid_cad": "03001627", "id_cad": "1a2b3c", "center": [0.05, 0.1, -0.02],
             "bbox": [0.4, 0.5, 0.3], "keypoints_scan": {"n_keypoints": 0, "position": []},
             # in their world: foot of the box at (5 + 2, 0, -1); CAD -z (front) goes to scan +y, which is their -z: no turn
             "trs": {"translation": [7 - 0.5 * 0.05, -0.8 * (0.1 - 0.5), -1 + 0.6 * 0.02],
                     "rotation": [1, 0, 0, 0], "scale": [0.5, 0.8, 0.6]}}
    scan = {"id_scan": "scene0042_01", "trs": {"translation": [5, 0, 0], "rotation": [half, -half, 0, 0], "scale": [1, 1, 1]},
            "n_aligned_models": 1, "aligned_models": [chair]}
    other = dict(scan, id_scan="scene0042_00", aligned_models=[])
    write(folder, "full_annotations.json", json.dumps([other, scan]))


def varint(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def wire(number, value, kind):
    """A field of a protobuf message: an int, a double, a float or bytes."""
    if kind == "int":
        return varint(number << 3) + varint(value)
    if kind == "double":
        return varint(number << 3 | 1) + struct.pack("<d", value)
    if kind == "float":
        return varint(number << 3 | 5) + struct.pack("<f", value)
    data = value.encode() if isinstance(value, str) else value
    return varint(number << 3 | 2) + varint(len(data)) + data


def wire_doubles(number, values, packed):
    if packed:
        return wire(number, struct.pack("<%dd" % len(values), *values), "bytes")
    return b"".join(wire(number, v, "double") for v in values)


VISMA_WIDTH, VISMA_HEIGHT = 160, 96
# Stamps of one second of float: 1512345678 * 10^9 ns and a few hundredths of a second.
VISMA_STAMPS = [1512345678000000000 + 33333333 * i for i in range(4)]
VISMA_SCAN_FROM_WORLD = rigid((0, -1, 0, 0.5), (1, 0, 0, -1), (0, 0, 1, 0.25))


def visma(folder, packed="", stem="%d.000000", unit="1"):
    """Gravity lies along exp([pi / 2, 0, 0]) (0, 0, -1) = (0, 1, 0): `world` has y down. An Aeron chair stands at (1, 2, 3) of
    the scan, turned by 0.5 rad about its up axis, which is the scan's +z."""
    import json
    root = os.path.join(folder, "clutter1")
    camera = wire(1, VISMA_HEIGHT, "int") + wire(2, VISMA_WIDTH, "int") + wire_doubles(3, [110, 111, 80, 48], packed)
    dataset = wire(1, "a sample", "bytes") + wire(2, camera, "bytes")
    for i, ns in enumerate(VISMA_STAMPS):
        feature = wire(1, 7, "int") + wire(2, 6, "int") + wire_doubles(3, [10, 20], packed) + wire_doubles(4, [1, 2, 3], packed)
        packet = (wire(1, float(ns), "double") + wire_doubles(2, flat(pose(i)[:3]), packed) + wire(3, feature, "bytes") +
                  wire_doubles(4, [math.pi / 2, 0], packed))
        dataset += wire(3, packet, "bytes")
        name = stem % (ns // int(unit))
        write(root, name + ".png", colour_png(i, VISMA_WIDTH, VISMA_HEIGHT))
        if i != 1:  # one is missing: those behind it keep their images
            box = b"".join(wire(k + 1, v, "float") for k, v in enumerate((10 + i, 20, 60, 70.5)))
            scores = struct.pack("<2f", 0.5 + 0.1 * i, 0.1)
            box += wire(5, scores, "bytes") if packed else b"".join(
                wire(5, v, "float") for v in struct.unpack("<2f", scores))
            box += wire(6, "chair", "bytes") + wire(7, 56, "int") + wire(8, 0.5, "float")
            write(root, name + ".bbox", wire(1, "boxes", "bytes") + wire(2, box, "bytes"))
    dataset += wire(4, wire(1, 1.0, "double"), "bytes")
    write(root, "dataset", dataset)
    c, s = math.cos(0.5), math.sin(0.5)
    # The model has y up: its y goes to the scan's z, its x to (c, s, 0).
    chair = rigid((c, 0, s, 1), (s, 0, -c, 2), (0, 1, 0, 3))
    fragments = os.path.join(folder, "RGBD/clutter1/fragments")
    write(fragments, "objects.json", json.dumps({"entries": ["swivel_chair_0", "Aeron_12", "gone_1"]}))
    write(fragments, "alignment.json", json.dumps({"swivel_chair_0": flat(chair[:3]), "Aeron_12": flat(rigid(
        (1, 0, 0, 4), (0, 0, -1, 5), (0, 1, 0, 6))[:3])}))
    write(fragments, "result_alignment.json", json.dumps({"T_ef_corvis": flat(VISMA_SCAN_FROM_WORLD[:3])}))


def scenenn_pose(i):
    """A camera held level, in a world with y down."""
    c, s = math.cos(0.1 * i), math.sin(0.1 * i)
    return rigid((c, 0, s, 0.2 * i), (0, 1, 0, 0), (-s, 0, c, 0))


def scenenn_mesh():
    """A floor of 4 by 4 m at y = 1.2 (label 1), a chair of 0.5 x 0.9 x 0.5 m (label 7) and a wall's scrap (label 9)."""
    vertices, labels, faces = [], [], []

    def grid(label, point, across, up, steps):
        start = len(vertices)
        for r in range(steps + 1):
            for c in range(steps + 1):
                vertices.append([point[k] + across[k] * c / steps + up[k] * r / steps for k in range(3)])
                labels.append(label)
        for r in range(steps):
            for c in range(steps):
                a = start + r * (steps + 1) + c
                faces.append((a, a + 1, a + steps + 2))
                faces.append((a, a + steps + 2, a + steps + 1))

    grid(1, (-2, 1.2, 0), (4, 0, 0), (0, 0, 4), 40)
    x, z = 0.5, 2.0
    for point, across, up in (((x, 0.3, z), (0.5, 0, 0), (0, 0.9, 0)), ((x, 0.3, z + 0.5), (0.5, 0, 0), (0, 0.9, 0)),
                              ((x, 0.3, z), (0, 0, 0.5), (0, 0.9, 0)), ((x + 0.5, 0.3, z), (0, 0, 0.5), (0, 0.9, 0)),
                              ((x, 0.3, z), (0.5, 0, 0), (0, 0, 0.5))):
        grid(7, point, across, up, 5)
    grid(9, (-2, 0, 4), (0.1, 0, 0), (0, 0.1, 0), 1)
    ply = ("ply\nformat binary_little_endian 1.0\ncomment a sample\nelement vertex %d\nproperty float x\nproperty float y\n"
           "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty int label\n"
           "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(vertices), len(faces))).encode()
    ply += b"".join(struct.pack("<3f3Bi", *v, 10, 20, 30, label) for v, label in zip(vertices, labels))
    return ply + b"".join(struct.pack("<B3i", 3, *f) for f in faces)


def scenenn(folder):
    """Images are counted from 1, and come every 40 ms; image 3 has no row in timestamp.txt."""
    root = os.path.join(folder, "123")
    log = stamps = ""
    for i in range(4):
        write(root, "image/image%05d.png" % (i + 1), colour_png(i))
        write(root, "depth/depth%05d.png" % (i + 1), depth_png(i))
        log += "%d %d %d\n" % (i, i, i + 1) + matrix_text(scenenn_pose(i))
        if i != 2:
            stamps += "%d %d %d\n" % (i + 1, 40000 * i + 1000, 40000 * i)
    write(root, "trajectory.log", log)
    write(root, "timestamp.txt", stamps)
    write(root, "123.ply", scenenn_mesh())
    write(root, "123.xml", """<?xml version="1.0"?>
<annotation>
  <label id="1" color="255 0 0" text="floor" nyu_class="floor" aabbox="-2 1.2 0 2 1.2 4"/>
  <label id="7" color="0 255 0" text="chair" nyu_class="chair" aabbox="0.5 0.3 2 1 1.2 2.5"/>
  <label id="9" color="0 0 255" text="table" nyu_class="table" aabbox="-2 0 4 -1.9 0.1 4"/>
</annotation>
""")


BOP_WIDTH, BOP_HEIGHT = 160, 120


def bop_scene(folder):
    """Object 3 stands at (1, 2, 0.5) of the world, turned by 0.4 rad about z; object 5 at (2, 2, 0.5). Raw depth is in 0.1 mm."""
    import json
    root = os.path.join(folder, "sample/train_real/000012")
    k = [140, 0, 79, 0, 141, 59, 0, 0, 1]
    cameras, truth = {}, {}
    c, s = math.cos(0.4), math.sin(0.4)
    models = {3: rigid((c, -s, 0, 1), (s, c, 0, 2), (0, 0, 1, 0.5)), 5: rigid((1, 0, 0, 2), (0, 1, 0, 2), (0, 0, 1, 0.5))}
    for i in (0, 1, 2, 10):
        world_to_cam = rigid_inverse(pose(i))
        cameras[str(i)] = {"cam_K": k, "depth_scale": 0.1, "cam_R_w2c": flat([row[:3] for row in world_to_cam[:3]]),
                           "cam_t_w2c": [1000 * row[3] for row in world_to_cam[:3]]}
        truth[str(i)] = []
        for obj_id, world_from_model in models.items():
            m = multiply(world_to_cam, world_from_model)
            if obj_id == 3 or i > 0:  # the second one shows later
                truth[str(i)].append({"obj_id": obj_id, "cam_R_m2c": flat([row[:3] for row in m[:3]]),
                                      "cam_t_m2c": [1000 * row[3] for row in m[:3]]})
        write(root, "rgb/%06d.png" % i, colour_png(i % 4, BOP_WIDTH, BOP_HEIGHT))
        write(root, "depth/%06d.png" % i, depth_png(i % 4, BOP_WIDTH, BOP_HEIGHT, units_per_mm=10))
    write(root, "scene_camera.json", json.dumps(cameras))
    write(root, "scene_gt.json", json.dumps(truth))
    info = {"diameter": 300, "min_x": -50, "min_y": -60, "min_z": -70, "size_x": 100, "size_y": 120, "size_z": 140}
    write(folder, "sample/models/models_info.json", json.dumps({"3": info, "5": dict(info, min_x=-40)}))


LAYOUTS = {f.__name__: f for f in (seven_scenes, tum_rgbd, icl_nuim, ros_bag, kitti_raw, kitti_odometry, scannet_sens, scannet_extracted, scan2cad, visma, scenenn, bop_scene,
                                      kitchen_as_seven_scenes)}

if __name__ == "__main__":
    LAYOUTS[sys.argv[1]](*sys.argv[2:])
