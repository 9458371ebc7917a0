# SPDX-License-Identifier: Apache-2.0
"""The statistics of scripts/measure.py against values by hand."""
import math
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import accuracy_page  # noqa: E402
import measure  # noqa: E402


def instance(name, found=True, position_m=0.02, level=0.4):
    one = {"id": name, "found": found, "quality": "fine", "shown_frames": 90, "shows_well": True, "why": "hidden",
           "cause": "never_boxed"}
    if found:
        one.update(model_right=True, position_m=position_m, rotation_deg=1.0, turned_round=False, confirmed_frame=30,
                   credible_level=level)
    return one


def record(room, seed, instances, objects=()):
    return {"set": "rooms", "room": room, "seed": seed, "variant": "as it is", "instances": instances, "spurious": [],
            "withdrawn": [], "fps": 10.0,
            "belief": {"objects": list(objects), "confirmation": {"truths": 2},
                       "along_the_run": {"poses": 10, "truth_in_50_percent": 0.5, "truth_in_95_percent": 0.9}}}


def believed(probability, truth, confirmed=True, claimed=0.95, right=True):
    return {"id": 1, "confirmed": confirmed, "probability": probability, "ground_truth": truth, "nees": 4,
            "degrees_of_freedom": 4, "label": {"probability": claimed, "right": right, "several_models": True}}


class Statistics(unittest.TestCase):
    def test_an_interval_is_students(self):
        mean, half = measure.mean_and_half([1.0, 2.0, 3.0, 4.0, 5.0])
        self.assertAlmostEqual(mean, 3)
        self.assertAlmostEqual(half, 2.776 * math.sqrt(2.5 / 5))
        self.assertEqual(measure.mean_and_half([7.0]), (7.0, None))
        self.assertEqual(measure.interval([None, None]), "-")

    def test_rooms_are_the_trials_where_there_are_several(self):
        one_room = [record("a", seed, [instance("x", seed > 0)]) for seed in range(3)]
        self.assertEqual(measure.by_unit(one_room, "found_well"), {0: 0, 1: 1, 2: 1})
        rooms = one_room + [record("b", seed, [instance("x")]) for seed in range(3)]
        self.assertEqual(measure.by_unit(rooms, "found_well"), {"a": 2 / 3, "b": 1})

    def test_a_pooled_share_weighs_units_by_their_trials(self):
        self.assertEqual(measure.pooled([(1, 2), (9, 18), (0, 0)]), "50 ± 0")
        self.assertEqual(measure.pooled([(0, 10), (10, 10)]), f"50 ± {12.706 * 50:.0f}")
        self.assertEqual(measure.pooled([]), "-")

    def test_causes_of_misses_are_counted(self):
        lines = measure.missed_lines([record("a", seed, [instance("x", False), instance("y")]) for seed in range(3)])
        self.assertEqual(lines[0], "**Missed** of those that show well: never boxed 3.")
        self.assertIn("- a, seed 2, x: hidden", lines)
        self.assertEqual(measure.missed_lines([record("a", 0, [instance("y")])]), [])

    def test_labels_are_calibrated_in_bins(self):
        objects = [believed(1, "x", claimed=0.95, right=False), believed(1, "y", claimed=1.0),
                   believed(1, "z", claimed=0.6), believed(1, "z", claimed=0.1, confirmed=False)]
        table, error = measure.label_bins([record("a", 0, [], objects)])
        self.assertEqual([b["count"] for b in table], [1, 2])
        self.assertAlmostEqual(error, (0.4 + 2 * abs(0.975 - 0.5)) / 3)

    def test_a_true_object_counts_once_in_each_run(self):
        runs = [record("a", 0, [], [believed(0.9, "x"), believed(0.8, "x"), believed(0.7, None)]),
                record("a", 1, [], [believed(0.85, "x")])]
        points, area = measure.precision_recall(runs)
        self.assertEqual([p[1:] for p in points], [(1, 0.25), (1, 0.5), (2 / 3, 0.5), (0.5, 0.5)])
        self.assertAlmostEqual(area, 0.5)

    def test_a_missed_instance_is_a_row(self):
        lines = measure.instance_table([record("a", 0, [instance("x")]), record("a", 1, [instance("x", False)])])
        self.assertIn("| a | x | 90 | 1 of 2 | 1 | 1 |", lines[2])

    def test_an_ablation_is_paired(self):
        # The far one is found by the reference alone: the means say -1.5 cm, the pairs +.5 cm.
        first = [record("a", seed, [instance("x", position_m=0.01), instance("far", position_m=0.05)])
                 for seed in range(3)]
        other = [record("a", seed, [instance("x", position_m=0.015), instance("far", False)]) for seed in range(3)]
        line = measure.ablation_table({"as it is": first, "no edges": other})[3]
        self.assertIn("| 1.00 ± 0.00 | -1.00 ± 0.00 |", line)
        self.assertIn("| 1.50 ± 0.00 | +0.50 ± 0.00 |", line)

    def test_what_is_smoothed_stands_beside_the_causal_result(self):
        runs = []
        for seed in range(2):
            runs.append(record("a", seed, [instance("x", position_m=0.02), instance("late", False)]))
            runs[-1]["smoothed"] = record("a", seed, [instance("x", position_m=0.01), instance("late")])
        lines = measure.smoothed_tables(runs)
        paired = [line for line in lines if line.startswith("| smoothed |")]
        self.assertIn("| 2.00 ± 0.00 | +1.00 ± 0.00 |", paired[0])
        self.assertIn("| -1.00 ± 0.00 |", paired[0])
        self.assertEqual(measure.smoothed_tables([record("a", 0, [instance("x")])]), [])

    def test_only_frames_that_are_mapped_count_as_shown(self):
        with tempfile.TemporaryDirectory() as folder:
            sequence = pathlib.Path(folder)
            (sequence / "color").mkdir()
            for number in (3, 4, 5, 6):
                (sequence / "color" / f"{number:06d}.jpg").touch()
            (sequence / "ground_truth.json").write_text('{"instances": [{"id": "x", "visible_frames": [[4, 6]]}]}')
            self.assertEqual(measure.shown_frames(sequence, None), {"x": 3})
            self.assertEqual(measure.shown_frames(sequence, "0:2"), {"x": 1})
            (sequence / "visibility.csv").write_text("frame,instance_id,pixels\n3,x,2000\n4,x,1999\n6,x,2500\n")
            self.assertEqual(measure.shown_frames(sequence, None), {"x": 2})


class AccuracyPage(unittest.TestCase):
    def part(self, records):
        arguments = {"detector": None, "edges": "gradient", "set": [], "seeds": [0, 1], "rooms": None, "ablate": None}
        return accuracy_page.Part("rooms-imu", arguments, records, "as it is")

    def test_means_are_over_objects_and_misses_are_named(self):
        records = [record("room 101", 0, [instance("chair_1", position_m=0.01), instance("couch_1", False)],
                          [believed(.9, "chair_1")]),
                   record("room 101", 1, [instance("chair_1", position_m=0.01), instance("couch_1", position_m=0.07)],
                          [believed(.9, "chair_1")])]
        part = self.part(records)
        row = accuracy_page.summary_row("rooms", part)
        self.assertIn("| dataset, gradient | 2 | 3 of 4 (75 %) | 3 of 3 | 0 | 0 | 0 | 3.00, 1.00 |", row)
        lines = "\n".join(accuracy_page.outlier_lines(part))
        self.assertIn("couch_1 of 101 (1 of 2).", lines)
        self.assertIn("couch_1 of 101 (1 of 2, up to 7.0 cm and 1 deg)", lines)
        self.assertIn("False: none.", lines)
        self.assertEqual(part.command, "scripts/measure.sh --only rooms-imu --seeds 0:2 --edges gradient")

    def test_results_of_something_else_are_told(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "results.json"
            file.write_text("{}")
            sys.argv = ["accuracy_page.py", "--commit", "x", str(file)]
            self.assertIn("no results of scripts/measure.sh", accuracy_page.main())

    def test_rooms_are_named_by_stretches(self):
        self.assertEqual(accuracy_page.stretches([101, 102, 103, 129, 131, 132]), "101 to 103, 129, 131 to 132")
        self.assertEqual(accuracy_page.stretches([7]), "7")


if __name__ == "__main__":
    unittest.main()
