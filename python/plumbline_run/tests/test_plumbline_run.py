#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The package against what the program itself says of the same files.

ctest sets PLUMBLINE_BINARY and PLUMBLINE_RECORDED_ROOM (a program that writes a small run); exit
code 77 says that the test was skipped."""

import json
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import numpy as np
except ImportError:
    print('skipped: this Python (%s) has no numpy; python3-numpy is the package' % sys.executable)
    sys.exit(77)

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import plumbline_run as pr  # noqa: E402

PROGRAM, ROOM = os.environ.get('PLUMBLINE_BINARY'), os.environ.get('PLUMBLINE_RECORDED_ROOM')
if not PROGRAM or not ROOM:
    print('skipped: PLUMBLINE_BINARY and PLUMBLINE_RECORDED_ROOM are not set; run it through ctest')
    sys.exit(77)


def plumbline(folder, *arguments):
    return subprocess.run([PROGRAM, *arguments], cwd=folder, check=True, capture_output=True).stdout


def setUpModule():
    """One room for all tests; they add files to it and change none."""
    RecordedRoom.folder = Path(tempfile.mkdtemp())
    subprocess.run([ROOM, str(RecordedRoom.folder)], check=True)
    told = plumbline(RecordedRoom.folder, 'export', 'room.plb', '--format', 'json', '--out', '-')
    RecordedRoom.told = json.loads(told)


def tearDownModule():
    shutil.rmtree(RecordedRoom.folder)


class RecordedRoom(unittest.TestCase):
    folder, told = None, None

    def close(self, a, b, tolerance=1e-12):  # JSON has doubles to the last digit
        np.testing.assert_allclose(a, b, rtol=0, atol=tolerance)


class RunTest(RecordedRoom):
    def setUp(self):
        self.run_file = pr.Run(self.folder / 'room.plb')
        self.addCleanup(self.run_file.close)

    def test_the_run_as_a_whole(self):
        run = self.run_file
        self.assertEqual(len(run), self.told['frames'])
        self.assertTrue(run.finished)
        self.assertEqual(run.models, ['chair', 'table'])
        self.assertEqual(run.camera['width'], 64)
        frames = run.frames()
        self.assertEqual(frames.frame.tolist(), [0, 1, 2, 3])
        self.assertEqual(frames.stamp_ns.tolist(), [0, 100000000, 200000000, 300000000])
        self.assertEqual(frames.used.tolist(), [True, True, False, True])
        self.assertEqual(int((~frames.used).sum()), self.told['skipped'])
        numbers, poses = run.trajectory()
        self.assertEqual(numbers.tolist(), [0, 1, 2, 3])
        self.close(poses[:, :3, 3], [[i, 0, 1] for i in range(4)])
        event, = run.events()
        self.assertEqual((event.frame, event.kind, event.object, event.other), (0, 'spawned', 1, None))
        self.assertEqual(run.object_ids(), [1, 4, 5])

    def test_objects_are_those_of_the_json_export(self):
        run, models = self.run_file, pr.Models(self.folder / 'models')
        objects = run.objects(run.last_used())
        self.assertEqual([o.id for o in objects], [o['id'] for o in self.told['objects']])
        for ours, told in zip(objects, self.told['objects']):
            self.assertEqual((ours.model, ours.category), (told['model'], told['category']))
            self.assertEqual(ours.state == 'confirmed', told['confirmed'])
            self.assertEqual(ours.confirmed_frame, told['confirmed_frame'])
            self.assertEqual((ours.first_frame, ours.last_frame), (told['first_frame'], told['last_frame']))
            self.close(ours.world_from_object, told['world_from_object'])
            self.close(np.degrees(pr.azimuth_of(ours.world_from_object, run.gravity)), told['azimuth_deg'])
            self.assertEqual(ours.label_probability, told['label_probability'])
            self.assertEqual(len(ours.modes), len(told['modes']))
            for mode, told_mode in zip(ours.modes, told['modes']):
                self.close(mode.world_from_object, told_mode['world_from_object'])
                self.close([mode.weight, mode.position_std, np.degrees(mode.azimuth_std)],
                           [told_mode[k] for k in ('weight', 'position_std_m', 'azimuth_std_deg')])
            mixture = ours.mixture_covariance(run.gravity, models[ours.model].symmetry_order)
            self.close(mixture, told['covariance'], 1e-9)  # sums over 40 particles
            self.close(np.sqrt(np.trace(mixture[:3, :3])), told['position_std_m'], 1e-9)
        table = objects[1]
        self.assertGreater(np.sqrt(np.trace(table.mixture_covariance(run.gravity, 2)[:3, :3])),
                           10 * np.sqrt(np.trace(table.covariance[:3, :3])))

    def test_the_mixture_without_particles_is_that_of_the_smoothed_export(self):
        smoothed, = self.run_file.smoothed()
        told, = self.told['smoothed']['objects']
        self.assertEqual(smoothed.belief.world_from_object[0, 3], 0.125)
        self.assertEqual((smoothed.looks, smoothed.views, smoothed.refined), (told['looks'], told['views'], True))
        self.close(smoothed.belief.probability, told['probability'])
        self.close(smoothed.belief.mixture_covariance(self.run_file.gravity, 2), told['covariance'])

    def test_particles_are_what_was_written_bit_by_bit(self):
        written = json.loads((self.folder / 'particles.json').read_text())
        table = self.run_file.frame(3).object(4)
        self.assertEqual(len(table.particles), 40)
        for name in table.particles.table.dtype.names:
            self.assertEqual(table.particles.table[name].tolist(), written[name], name)
        self.close(table.particles.weights.sum(), 1)
        z = np.exp(np.array(written['rho']))
        self.close(table.particles.centers, np.stack([z * written['x_c'], z * written['y_c'], z + 1], axis=1))
        self.assertEqual(table.particles.label_probability().keys(), {'table'})
        # Those of the chair did not change: they are stored once, and read wherever they count.
        chairs = [self.run_file.frame(i).object(1).particles.table for i in (0, 1, 3)]
        self.assertEqual(chairs[0].tobytes(), chairs[2].tobytes())

    def test_a_frame(self):
        frame = self.run_file.frame(-1)
        self.assertEqual((frame.frame, frame.timings), (3, {'score': 5.0}))
        self.assertEqual(frame.proposals.boxes.tolist(), [[1, 2, 30, 40], [5, 6, 7, 8]])
        self.assertEqual(frame.proposals.fates, ['explained', 'unknown_category'])
        self.assertEqual(frame.proposals.objects.tolist(), [1, -1])
        self.assertEqual(frame.object(1).visible_box.tolist(), [1, 2, 20, 30])
        self.assertTrue(self.run_file.thumbnail(0).startswith(b'\xff\xd8'))
        self.assertEqual(self.run_file.thumbnail(2), b'')
        self.assertEqual(self.run_file.frame(2).skipped, 'color/000002.jpg is truncated')
        with self.assertRaises(IndexError):
            self.run_file.frame(4)
        self.assertEqual(self.run_file.position_of(3), 3)
        with self.assertRaises(KeyError):
            self.run_file.position_of(17)

    def test_a_history(self):
        positions, objects = self.run_file.history(4)
        self.assertEqual(positions.tolist(), [1, 3])
        self.assertEqual([o.model for o in objects], ['table', 'table'])

    def test_nothing_is_written(self):
        before = {p.name: p.read_bytes() for p in self.folder.glob('room.plb*')}
        with pr.Run(self.folder / 'room.plb') as run:
            run.frame(0)
            with self.assertRaises(sqlite3.OperationalError):
                run._connection.execute('DELETE FROM frames')
        self.assertEqual({p.name: p.read_bytes() for p in self.folder.glob('room.plb*')}, before)

    def test_what_is_no_run_is_named(self):
        with self.assertRaises(FileNotFoundError):
            pr.Run(self.folder / 'none.plb')
        (self.folder / 'text.plb').write_text('no database' * 100)
        with self.assertRaisesRegex(pr.FormatError, 'text.plb.*is not a run file'):
            pr.Run(self.folder / 'text.plb')
        with sqlite3.connect(self.folder / 'other.plb') as other:
            other.execute('CREATE TABLE a (b)')
        with self.assertRaisesRegex(pr.FormatError, 'is not a run file'):
            pr.Run(self.folder / 'other.plb')
        shutil.copy(self.folder / 'room.plb', self.folder / 'newer.plb')
        with sqlite3.connect(self.folder / 'newer.plb') as newer:
            newer.execute('PRAGMA user_version = 99')
        with self.assertRaisesRegex(pr.FormatError, 'format 99'):
            pr.Run(self.folder / 'newer.plb')
        with sqlite3.connect(self.folder / 'newer.plb') as cut_off:
            cut_off.execute('PRAGMA user_version = 2')
            cut_off.execute("UPDATE run SET value = '0' WHERE key = 'finished'")
        with pr.Run(self.folder / 'newer.plb') as run:
            self.assertFalse(run.finished)
        shutil.copy(self.folder / 'room.plb', self.folder / 'damaged.plb')
        with sqlite3.connect(self.folder / 'damaged.plb') as damaged:
            damaged.execute("UPDATE objects SET details = x'0011223344'")
        with pr.Run(self.folder / 'damaged.plb') as run:
            with self.assertRaisesRegex(pr.FormatError, 'damaged'):
                run.objects()


class ModelsTest(RecordedRoom):
    def test_meshes_are_those_of_the_program(self):
        models = pr.Models(self.folder / 'models')
        self.assertEqual(models.names, ['chair', 'table'])
        self.assertEqual([m.symmetry_order for m in models], [1, 2])
        told = json.loads(plumbline(self.folder, 'info', 'models', '--json', '-'))['models']
        for model, entry in zip(models, told):
            self.assertEqual(len(model.mesh.triangles), entry['faces'])
            self.close(model.bounds[1] - model.bounds[0], entry['size_m'], 1e-3)
        self.assertEqual(models['table'].mesh.colors[0].tolist(), [120, 80, 40])
        self.assertIsNone(models['chair'].mesh.colors)
        with self.assertRaises(KeyError):
            models['sofa']

    def test_ply_of_every_kind(self):
        ascii_ply = ('ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n'
                     'element face 1\nproperty list uchar int vertex_indices\nend_header\n'
                     '0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n4 0 1 2 3\n')
        file = self.folder / 'quad.ply'
        file.write_text(ascii_ply)
        from plumbline_run.ply import read_ply
        self.assertEqual(read_ply(file).triangles.tolist(), [[0, 1, 2], [0, 2, 3]])
        header = ascii_ply[:ascii_ply.index('end_header')].replace('ascii', 'binary_big_endian') + 'end_header\n'
        body = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, .5]], '>f4').tobytes() + b'\x04' + \
            np.arange(4, dtype='>i4').tobytes()
        file.write_bytes(header.encode() + body)
        big = read_ply(file)
        self.assertEqual(big.vertices[3].tolist(), [0, 1, .5])
        self.assertEqual(big.triangles.tolist(), [[0, 1, 2], [0, 2, 3]])
        file.write_bytes(header.encode() + body[:20])
        with self.assertRaisesRegex(pr.FormatError, 'quad.ply.*damaged'):
            read_ply(file)


class AnnotationTest(RecordedRoom):
    def test_a_project_and_its_ground_truth(self):
        edits = [{'edit': 'inputs', 'scan': '', 'models': 'models', 'sequence': 'walk'},
                 {'edit': 'add', 'instance': {'id': 'a', 'model': 'table', 'category': 'dining table', 'scale': 2, 'quality': 'coarse',
                                              'scan_from_object': [[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]}}]
        (self.folder / 'edits.json').write_text(json.dumps(edits))
        plumbline(self.folder, 'annotate', 'apply', 'room.json', 'edits.json', '--create', '--annotator', 'Ada')
        plumbline(self.folder, 'annotate', 'export', 'room.json', '--format', 'ground_truth', '--out', 'truth.json')
        project, truth = pr.Annotation(self.folder / 'room.json'), pr.Annotation(self.folder / 'truth.json')
        self.assertEqual((project.ids, project.instances[0].annotator), (['a'], 'Ada'))
        self.assertFalse(project.instances[0].fine)
        self.close(project.poses, truth.poses)
        self.close(project.scan_from_world, np.eye(4))
        corners = project.boxes()[0]
        # Twice a table of 1.3 x 0.7 x 0.74 m, turned by a quarter.
        self.close(corners.max(axis=0) - corners.min(axis=0), [1.4, 2.6, 1.48], 1e-6)
        self.close(corners.min(axis=0)[2], 7, 1e-6)
        with self.assertRaisesRegex(pr.FormatError, 'no annotation project'):
            pr.Annotation(self.folder / 'particles.json')


class ExamplesTest(RecordedRoom):
    def test_examples_draw(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest('this Python has no matplotlib')
        environment = dict(os.environ, MPLBACKEND='Agg', PYTHONPATH=str(HERE.parent), MPLCONFIGDIR=str(self.folder))
        for name, arguments in (('map_from_above.py', []), ('particles.py', ['--object', '4']), ('uncertainty.py', [])):
            out = self.folder / (name + '.png')
            subprocess.run([sys.executable, '-B', str(HERE.parent / 'examples' / name), str(self.folder / 'room.plb'), '--out', str(out),
                            *arguments], check=True, env=environment)
            self.assertGreater(out.stat().st_size, 5000, name)


class GeometryTest(unittest.TestCase):
    def test_angles(self):
        np.testing.assert_allclose(pr.wrap_angle([np.pi, -np.pi, 3 * np.pi / 2]), [np.pi, np.pi, -np.pi / 2], atol=1e-12)
        turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
        self.assertAlmostEqual(float(pr.azimuth_of(turn, [0, 0, -9.81])), np.pi / 2)

    def test_projection(self):
        camera = {'fx': 60, 'fy': 50, 'cx': 31.5, 'cy': 23.5}
        np.testing.assert_allclose(pr.project(camera, [[0, 0, 2], [1, 1, 2]]), [[31.5, 23.5], [61.5, 48.5]])
        self.assertTrue(np.isnan(pr.project(camera, [0, 0, -1])).all())


if __name__ == '__main__':
    unittest.main()
