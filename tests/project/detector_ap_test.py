#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Average precision where it can be counted by hand (scripts/detector_ap.py)."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'scripts'))
import detector_ap  # noqa: E402

BOX, FAR = [10, 10, 30, 50], [100, 100, 140, 120]


class AveragePrecision(unittest.TestCase):
    def one(self, boxes, truth, iou=.5):
        return detector_ap.average_precision(boxes, truth, iou)

    def test_a_right_box_for_each_object_is_one(self):
        boxes = [(0, .9, BOX), (1, .3, FAR)]
        self.assertAlmostEqual(self.one(boxes, {0: [(BOX, True)], 1: [(FAR, True)]}), 1)

    def test_a_better_scored_wrong_box_halves_precision_and_a_missed_object_recall(self):
        truth = {0: [(BOX, True)]}
        self.assertAlmostEqual(self.one([(0, .9, FAR), (0, .8, BOX)], truth), .5)
        # Recall ends at 1/2: 51 of the 101 points.
        self.assertAlmostEqual(self.one([(0, .8, BOX)], {0: [(BOX, True), (FAR, True)]}), 51 / 101)

    def test_a_second_box_of_an_object_is_wrong(self):
        truth = {0: [(BOX, True), (FAR, True)]}
        # Hit, double, hit: precision 1 to recall 1/2, then 2/3.
        self.assertAlmostEqual(self.one([(0, .9, BOX), (0, .8, BOX), (0, .7, FAR)], truth), (51 + 50 * 2 / 3) / 101)

    def test_overlap_decides(self):
        shifted = [10, 10, 30, 40]  # IoU .75
        self.assertAlmostEqual(self.one([(0, 1, shifted)], {0: [(BOX, True)]}, .7), 1)
        self.assertAlmostEqual(self.one([(0, 1, shifted)], {0: [(BOX, True)]}, .8), 0)

    def test_what_hardly_shows_counts_neither_way(self):
        self.assertIsNone(self.one([(0, 1, BOX)], {0: [(BOX, False)]}))
        self.assertAlmostEqual(self.one([(0, .9, FAR), (0, .8, BOX)], {0: [(BOX, True), (FAR, False)]}), 1)

    def test_nothing_found_is_zero(self):
        self.assertAlmostEqual(self.one([], {0: [(BOX, True)]}), 0)

    def test_files_of_the_program_are_read(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, 'bop', 'test', '000000')
            os.makedirs(scene)
            os.makedirs(os.path.join(folder, 'bop', 'models'))
            visible = {'bbox_visib': [10, 10, 19, 39], 'px_count_visib': 800, 'visib_fract': .9}
            for file, content in ((os.path.join(scene, 'scene_gt.json'), {'6': [{'obj_id': 2}]}),
                                  (os.path.join(scene, 'scene_gt_info.json'), {'6': [visible]}),
                                  (os.path.join(folder, 'bop', 'models', 'plumbline_models.json'), {'2': {'category': 'chair'}}),
                                  (os.path.join(folder, 'boxes.json'), {
                                      'images': [{'id': 1, 'file_name': 'color/000006.jpg'}], 'categories': [{'id': 62, 'name': 'chair'}],
                                      'annotations': [{'image_id': 1, 'category_id': 62, 'score': .5, 'bbox': [10, 10, 20, 40]}]})):
                with open(file, 'w') as out:
                    json.dump(content, out)
            command = [sys.executable, detector_ap.__file__, os.path.join(folder, 'boxes.json'), '--bop', os.path.join(folder, 'bop'),
                       '--json', os.path.join(folder, 'table.json')]
            self.assertEqual(subprocess.run(command, stdout=subprocess.DEVNULL).returncode, 0)
            with open(os.path.join(folder, 'table.json')) as table:
                self.assertEqual(json.load(table), [{'category': 'chair', 'objects': 1, 'ap': 1.0, 'ap50': 1.0}])

    def test_what_cannot_be_read_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            files = {'damaged.json': '{', 'other.json': '[]'}
            for name, content in files.items():
                pathlib.Path(folder, name).write_text(content)
            for name in [*files, 'missing.json']:
                file = os.path.join(folder, name)
                told = subprocess.run([sys.executable, detector_ap.__file__, file, '--bop', folder], capture_output=True, text=True)
                self.assertNotEqual(told.returncode, 0)
                self.assertIn(file, told.stderr)
                self.assertEqual(len(told.stderr.splitlines()), 1, told.stderr)


if __name__ == '__main__':
    unittest.main()
