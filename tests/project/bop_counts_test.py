#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a BOP export counts, against docs/exports.md's formulas in numpy: from the files alone, with another way to draw.

ctest sets PLUMBLINE_BINARY and PLUMBLINE_RECORDED_ROOM; exit code 77 says that the test was skipped."""

import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

try:
    import numpy as np
except ImportError:
    print('skipped: this Python (%s) has no numpy; python3-numpy is the package' % sys.executable)
    sys.exit(77)

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'python' / 'plumbline_run'))

from plumbline_run.ply import read_ply  # noqa: E402

PROGRAM, ROOM = os.environ.get('PLUMBLINE_BINARY'), os.environ.get('PLUMBLINE_RECORDED_ROOM')
if not PROGRAM or not ROOM:
    print('skipped: PLUMBLINE_BINARY and PLUMBLINE_RECORDED_ROOM are not set; run it through ctest')
    sys.exit(77)

DELTA_MM = 15
# Both draw pixels by their centres; a centre on an edge to rounding may fall to either side.
ON_AN_EDGE_PX = 4


def write_depth(file, depth):
    """A 16-bit grey PNG."""
    rows = b''.join(b'\0' + row.astype('>u2').tobytes() for row in depth)

    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    header = struct.pack('>IIBBBBB', depth.shape[1], depth.shape[0], 16, 0, 0, 0, 0)
    file.write_bytes(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header) + chunk(b'IDAT', zlib.compress(rows)) + chunk(b'IEND', b''))


def read_grey(file):
    """A grey PNG of 8 or 16 bits."""
    data, at, packed = file.read_bytes(), 8, b''
    while at < len(data):
        size, kind = struct.unpack('>I4s', data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        if kind == b'IHDR':
            width, height, bits = struct.unpack('>IIB', body[:9])
        packed += body if kind == b'IDAT' else b''
        at += 12 + size
    step = bits // 8
    plain, stride = zlib.decompress(packed), width * step
    image, before = np.zeros((height, stride), np.int64), np.zeros(stride, np.int64)
    for y in range(height):
        line = np.frombuffer(plain, np.uint8, stride, y * (stride + 1) + 1).astype(np.int64)
        kind = plain[y * (stride + 1)]
        for x in range(stride):  # the filters of the PNG specification
            left, corner = (image[y, x - step], before[x - step]) if x >= step else (0, 0)
            guess = left + before[x] - corner
            paeth = min((left, before[x], corner), key=lambda v: abs(guess - v))
            image[y, x] = (line[x] + (0, left, before[x], (left + before[x]) // 2, paeth)[kind]) & 255
        before = image[y]
    return image if step == 1 else image[:, ::2] * 256 + image[:, 1::2]


def draw(mesh, pose, camera, width, height):
    """Depth [mm] at the pixels' centres, 0 where there is nothing; triangle by triangle."""
    points = mesh.vertices @ pose[:, :3].T + pose[:, 3]
    fx, cx, fy, cy = camera
    nearest = np.full((height, width), np.inf)
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    for triangle in mesh.triangles:
        p = points[triangle]
        if (p[:, 2] <= 0).any():
            raise AssertionError('this test draws what is before the camera')
        u, v = fx * p[:, 0] / p[:, 2] + cx, fy * p[:, 1] / p[:, 2] + cy
        area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0])
        if abs(area) < 1e-12:
            continue
        b = ((columns - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (rows - v[0])) / area
        c = ((u[1] - u[0]) * (rows - v[0]) - (columns - u[0]) * (v[1] - v[0])) / area
        inside = (b >= 0) & (c >= 0) & (b + c <= 1)
        inverse = (1 - b - c) / p[0, 2] + b / p[1, 2] + c / p[2, 2]  # of depth is linear in the image
        nearest[inside] = np.minimum(nearest[inside], 1 / inverse[inside])
    return np.where(np.isinf(nearest), 0, nearest)


class BopCounts(unittest.TestCase):
    def test_every_count_and_mask(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            subprocess.run([ROOM, name], check=True)
            (folder / 'walk' / 'depth').mkdir()
            measured = np.full((48, 64), 2080)  # among the furniture, which is 2 m away and more
            measured[:, :20] = 0
            measured[:10] = 5000
            write_depth(folder / 'walk' / 'depth' / '000000.png', measured)
            subprocess.run([PROGRAM, 'export', 'room.plb', '--format', 'bop', '--out', 'bop', '--frames', '0:1'], cwd=name,
                           check=True, stdout=subprocess.DEVNULL)
            self.check(folder / 'bop', measured)

    def check(self, bop, measured):
        scene = bop / 'test' / '000000'
        truth, info, camera = (json.loads((scene / file).read_text())['0'] for file in
                               ('scene_gt.json', 'scene_gt_info.json', 'scene_camera.json'))
        np.testing.assert_array_equal(read_grey(scene / 'depth' / '000000.png'), measured)
        height, width = measured.shape
        fx, _, cx, _, fy, cy = camera['cam_K'][:6]
        columns, rows = np.meshgrid(np.arange(width), np.arange(height))
        rays = np.sqrt(((columns - cx) / fx)**2 + ((rows - cy) / fy)**2 + 1)
        distance = rays * measured * camera['depth_scale']
        hidden = 0
        for i, (posed, counted) in enumerate(zip(truth, info)):
            mesh = read_ply(bop / 'models' / ('obj_%06d.ply' % posed['obj_id']))
            pose = np.column_stack([np.reshape(posed['cam_R_m2c'], (3, 3)), posed['cam_t_m2c']])
            large = draw(mesh, pose, (fx, cx + width, fy, cy + height), 3 * width, 3 * height)
            depth = large[height:2 * height, width:2 * width]
            visible = (depth > 0) & ((distance == 0) | (rays * depth - distance <= DELTA_MM))
            hidden += int(((depth > 0) & ~visible).sum())
            expected = {'px_count_all': (large > 0).sum(), 'px_count_visib': visible.sum(),
                        'px_count_valid': ((depth > 0) & (distance > 0)).sum()}
            for key, count in expected.items():
                self.assertLessEqual(abs(counted[key] - int(count)), ON_AN_EDGE_PX, key)
            self.assertAlmostEqual(counted['visib_fract'], counted['px_count_visib'] / counted['px_count_all'])
            for key, shape, corner in (('bbox_obj', large > 0, (width, height)), ('bbox_visib', visible, (0, 0))):
                y, x = np.nonzero(shape)
                box = [x.min() - corner[0], y.min() - corner[1], x.max() - x.min(), y.max() - y.min()]
                self.assertLessEqual(np.abs(np.array(box) - counted[key]).max(), 1, key)
            for kind, shape in (('mask', depth > 0), ('mask_visib', visible)):
                mask = read_grey(scene / kind / ('000000_%06d.png' % i))
                self.assertLessEqual(int(((mask > 0) != shape).sum()), ON_AN_EDGE_PX, kind)
        self.assertGreater(hidden, 50, 'the measured depth hides something, or this tests nothing')


if __name__ == '__main__':
    unittest.main()
