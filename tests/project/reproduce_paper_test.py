# SPDX-License-Identifier: Apache-2.0
"""scripts/reproduce_paper.py on sample folders, with a program that only pretends; with the real one where PLUMBLINE_BINARY names it."""
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
PROJECT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(PROJECT / "scripts"), str(PROJECT / "tests/engine/dataset")]
import data_set_samples  # noqa: E402
import reproduce_paper  # noqa: E402

# Answers as plumbline would, and writes down what it was called with. A sequence with a file `fails` fails in the verb that it names.
PRETENDER = """#!/usr/bin/env python3
import json, os, pathlib, sys
words = sys.argv[1:]
with open(os.environ["CALLS"], "a") as calls:
    calls.write(json.dumps(words) + "\\n")
verb = words[0]
value = lambda name: words[words.index(name) + 1]
if os.path.exists(os.environ["CALLS"] + ".fails"):
    wanted, part = open(os.environ["CALLS"] + ".fails").read().split()
    if wanted == verb and part in " ".join(words):
        print("plumbline: it was told to fail", file=sys.stderr)
        sys.exit(1)
if verb == "convert":
    out = pathlib.Path(value("--out"))
    (out / "models").mkdir(parents=True)
    eye = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    (out / "ground_truth.json").write_text(json.dumps({"gravity": [0, 0, -1], "instances": [
        {"id": "swivel_chair_0", "model": "swivel_chair", "category": "chair", "world_from_object": eye}]}))
    if "scenenn" in str(out):
        (out / "models/models.json").write_text("{}")
        (out / "scene.ply").write_text("ply")
    pathlib.Path(value("--json")).write_text(json.dumps({"odd": ["one thing is odd"]}))
elif verb == "models":
    out = pathlib.Path(value("--out"))
    (out / "models.json").write_text(json.dumps({"models": [
        {"name": pathlib.Path(words[2]).stem, "source": {"up": "+y", "front": "+x", "unit": "m"}}]}))
elif verb == "run":
    pathlib.Path(value("--out")).write_text("a run")
    pathlib.Path(value("--json")).write_text(json.dumps({"run": {"end_frame": 4}, "frames": 4, "skipped": 0, "fps": 9.0}))
elif verb == "evaluate":
    cm = lambda k: {"median_m": k / 100, "mean_m": k / 50, "std_m": k / 200, "max_m": k / 10}
    scan = "--scene" in words
    pathlib.Path(value("--json")).write_text(json.dumps({
        "surfaces": {"posed": cm(1), **({"paper": {**cm(9), "to_plane": cm(3), "all": {"mean_translation_m": .04, "mean_rotation_deg": 5}},
                     "visma": cm(2), "scanned": {**cm(4), "share": .5}} if scan else {})},
        "all": {"mean_translation_m": .06, "mean_rotation_deg": 7}, "matched": 1, "missed": 2, "spurious": 0,
        "placement": {"scan2cad": {"right": 1}}, "objects": [], "missed_instances": []}))
elif verb == "render":
    os.makedirs(value("--out"))
    pathlib.Path(value("--out"), "000003.png").write_text("a picture")
"""

# A model as VISMA has them: y up, and its origin neither in its middle nor at its foot.
MODEL = "".join(f"v {x} {y} {z}\n" for x in (1, 1.4) for y in (-0.5, 0.4) for z in (2, 2.6)) + "".join(
    f"f {a} {b} {c}\n" for a, b, c in ((1, 3, 2), (2, 3, 4), (5, 6, 7), (6, 8, 7), (1, 2, 5), (2, 6, 5), (3, 7, 4), (4, 7, 8), (1, 5, 3), (3, 5, 7),
                                       (2, 4, 6), (4, 8, 6)))


class Samples(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = pathlib.Path(folder.name)
        self.root, self.out, self.calls = self.top / "data", self.top / "out", self.top / "calls"
        data_set_samples.visma(str(self.root / "visma"))  # the sequence clutter1
        (self.root / "visma/CAD_database").mkdir()
        (self.root / "visma/CAD_database/swivel_chair.obj").write_text(MODEL)
        data_set_samples.scenenn(str(self.root / "scenenn"))
        for ending in ("ply", "xml"):
            (self.root / f"scenenn/123/123.{ending}").rename(self.root / f"scenenn/123/025.{ending}")
        (self.root / "scenenn/123").rename(self.root / "scenenn/025")
        program = self.top / "pretender"
        program.write_text(PRETENDER)
        program.chmod(0o755)
        self.environment = {**os.environ, "PLUMBLINE": str(program), "CALLS": str(self.calls)}

    def reproduce(self, *words, rc=0):
        process = subprocess.run([str(PROJECT / "scripts/reproduce_paper.sh"), str(self.root), "--out", str(self.out), *words],
                                 env=self.environment, capture_output=True, text=True, check=False)
        self.assertEqual(process.returncode, rc, process.stdout + process.stderr)
        tables = (self.out / "tables.md").read_text()
        self.results = {one["name"]: one for one in json.loads((self.out / "results.json").read_text())["sequences"]}
        return tables

    def called(self):
        """The verbs that were called since the last time."""
        words = [json.loads(line) for line in self.calls.read_text().splitlines()] if self.calls.exists() else []
        self.calls.unlink(missing_ok=True)
        self.words = words
        return [one[0] for one in words]

    def rows(self, tables, start):
        """The rows of a sequence: from the paper's to the next sequence's."""
        lines = tables.splitlines()
        first = next(index for index, line in enumerate(lines) if line.startswith(f"| {start} | the paper |"))
        last = next((index for index in range(first + 1, len(lines)) if not lines[index].startswith("|  |")), len(lines))
        return lines[first:last]

    def test_a_dry_run_calls_nothing_and_leaves_no_sequence_out(self):
        tables = self.reproduce("--dry-run")
        self.assertEqual(self.called(), [])
        for name in [*reproduce_paper.TABLE_1, *reproduce_paper.TABLE_2]:
            self.assertEqual(len(self.rows(tables, name)), 2, name)
            self.assertIn("planned" if name in ("clutter1", "025") else "**missing**: not under ROOT", self.rows(tables, name)[1])
        self.assertIn("| VISMA | clutter1 | there |", tables)
        self.assertIn("github.com/feixh/VISMA", tables)
        self.assertIn("github.com/hkust-vgd/scenenn", tables)

    def test_ours_stands_beside_the_papers_by_both_rules(self):
        tables = self.reproduce("--seeds", "0:2", "--figures")
        table_2 = self.rows(tables, "025")
        self.assertEqual(table_2[0], "| 025 | the paper | 0.726 | 0.756 | 0.509 | 3.07 | - | - | - | - | - |")
        self.assertEqual(table_2[1], "|  | ours, preset default: by the paper's rule | 3.00 ± 0.00 | 6.00 ± 0.00 | 1.50 ± 0.00 | 30.00 ± 0.00 | "
                         "4.00 ± 0.00 | 5.00 ± 0.00 | - | - | - |")
        self.assertIn("scanned (50 ± 0 %) | 4.00 ± 0.00 |", table_2[2])
        self.assertIn("| 6.00 ± 0.00 | 7.00 ± 0.00 | 1.0 ± 0.0 of 3 | 1.0 ± 0.0 | 0.0 ± 0.0 |", table_2[2])
        self.assertEqual(len(table_2), 1 + 2 * 3)
        # This sample of VISMA has no scan: no number stands for the paper's rule.
        table_1 = self.rows(tables, "clutter1")
        self.assertIn("by the paper's rule" + " | -" * 9, table_1[1])
        self.assertIn("posed truth | 1.00 ± 0.00 |", table_1[4])
        self.assertIn("no test.klg.ply", tables)
        self.assertIn("figures/figure5-scenenn-025-truth/000003.png", tables)
        self.assertIn("Figure 4, VISMA occlusion1: missing; not under ROOT", tables)
        self.assertIn("seeds 0, 1;", tables)
        # Of all run files that of the figure is kept.
        self.assertEqual([path.name.rsplit("-", 1)[0] for path in (self.out / "runs").glob("*.plb")], ["scenenn-025-default-s0"])
        self.called()
        self.assertIn(["--frames", "3:4"], [one[i:i + 2] for one in self.words for i in range(len(one)) if one[0] == "render"])

    def test_what_is_done_is_not_done_again(self):
        self.reproduce("--seeds", "0:1")
        self.assertEqual(sorted(self.called()), sorted(["convert"] * 2 + ["models"] + ["run", "evaluate"] * 4))
        self.reproduce("--seeds", "0:2", "--preset", "default")
        self.assertEqual(sorted(self.called()), sorted(["run", "evaluate"] * 2))
        self.assertIn("ours, preset default (2 of 3 seeds): by", "\n".join(self.rows(self.reproduce("--dry-run"), "025")))
        self.assertIn("ours, preset default: by", "\n".join(self.rows(self.reproduce("--dry-run", "--seeds", "0:2", "--preset", "default"), "025")))
        self.assertEqual(self.called(), [])

    def test_a_failure_is_told_with_its_log_and_the_rest_goes_on(self):
        fails = pathlib.Path(str(self.calls) + ".fails")
        fails.write_text("run visma-clutter1-paper")
        tables = self.reproduce("--seeds", "0:1", rc=1)
        rows = "\n".join(self.rows(tables, "clutter1"))
        self.assertIn("ours, preset default: by the paper's rule", rows)
        self.assertIn("ours, preset paper, seed 0: **failed**: plumbline: it was told to fail (log: runs/", rows)
        self.assertNotIn("**failed**", "\n".join(self.rows(tables, "025")))
        failed = next(run for run in self.results["clutter1"]["runs"] if "failed" in run)
        self.assertIn("it was told to fail", (self.out / failed["log"]).read_text())
        # Tried again, alone.
        fails.unlink()
        self.called()
        self.assertNotIn("**failed**", self.reproduce("--seeds", "0:1"))
        self.assertEqual(self.called(), ["run", "evaluate"])

    def test_a_sequence_that_cannot_be_converted_is_a_row(self):
        pathlib.Path(str(self.calls) + ".fails").write_text("convert scenenn/025")
        tables = self.reproduce("--seeds", "0:1", rc=1)
        self.assertIn("ours: **failed**: plumbline: it was told to fail (log: sequences/scenenn-025.log)", "\n".join(self.rows(tables, "025")))
        self.assertFalse((self.out / "sequences/scenenn-025.json").exists())
        self.assertIn("by the paper's rule", "\n".join(self.rows(tables, "clutter1")))

    def test_a_damaged_file_fails_its_sequence_alone(self):
        (self.root / "visma/RGBD/clutter1/test.klg.ply").write_text("no PLY")
        (self.root / "visma/RGBD/clutter1/fragments/result_alignment.json").write_text("[1]")
        tables = self.reproduce("--seeds", "0:1", rc=1)
        self.assertIn("ours: **failed**: a file was not understood", "\n".join(self.rows(tables, "clutter1")))
        self.assertIn("by the paper's rule", "\n".join(self.rows(tables, "025")))

    def test_what_a_sequence_lacks_is_named(self):
        (self.root / "visma/RGBD/clutter1/fragments/result_alignment.json").unlink()
        (self.root / "scenenn/025/025.xml").unlink()
        tables = self.reproduce()
        self.assertEqual(self.called(), [])
        self.assertIn("| VISMA | clutter1 | incomplete | no result_alignment.json", tables)
        self.assertIn("ours: **missing**: no 025.xml", "\n".join(self.rows(tables, "025")))

    def test_models_of_visma_are_posed_as_they_were_built(self):
        tables = self.reproduce("--seeds", "0:1", "--only", "clutter1")
        self.assertIn("Not asked for (`--only`): clutter2, occlusion1, occlusion2.", tables)
        truth = json.loads((self.out / "sequences/visma-clutter1/ground_truth.json").read_text())
        # The model's foot is at (1.2, -0.5, 2.3) of its file, y up; z up that is (1.2, -2.3, -0.5).
        pose = truth["instances"][0]["world_from_object"]
        for row, wanted in zip(pose, ([1, 0, 0, 1.2], [0, 1, 0, -2.3], [0, 0, 1, -0.5])):
            for value, number in zip(row, wanted):
                self.assertAlmostEqual(value, number)
        mesh = self.root / "visma/CAD_database/swivel_chair.obj"
        # Had it been built upside down, its foot would be the other end, and down the truth's gravity.
        upside_down = {"instances": [{"id": "a", "model": "m", "world_from_object": [[float(r == c) for c in range(4)] for r in range(4)]}]}
        self.assertEqual(reproduce_paper.pose_as_built(upside_down, {"m": reproduce_paper.cad_from_built(mesh, "-y")}), [])
        self.assertEqual([round(value, 9) + 0 for value in upside_down["gravity"]], [0, 0, 1])
        self.assertAlmostEqual(upside_down["instances"][0]["world_from_object"][2][3], 0.4)

    def test_a_cloud_becomes_squares_in_the_world(self):
        cloud, mesh = self.top / "cloud.ply", self.top / "mesh.ply"
        header = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz", "radius"))
        cloud.write_bytes(f"ply\nformat binary_little_endian 1.0\nelement vertex 2\n{header}end_header\n".encode() +
                          struct.pack("<14f", 1, 2, 3, 0, 0, 1, 0.01, 0, 0, 0, 0, 0, 0, 0.01))
        moved = [[0.0, -1.0, 0.0, 10.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
        self.assertIn("1 surfels", reproduce_paper.mesh_of_scan(cloud, mesh, moved))
        names, rows, triangles = reproduce_paper.read_ply(mesh)
        self.assertEqual((names, len(rows), len(triangles)), (["x", "y", "z"], 4, 2))
        for row in rows:
            self.assertAlmostEqual(math.dist(row, (8, 1, 3)), 0.01 * math.sqrt(2), places=6)
            self.assertAlmostEqual(row[2], 3)
        # A mesh stays one; what is cut short is refused.
        self.assertEqual(reproduce_paper.mesh_of_scan(mesh, self.top / "again.ply", reproduce_paper.rigid_inverse(moved)), "")
        self.assertEqual(reproduce_paper.read_ply(self.top / "again.ply")[2], triangles)
        mesh.write_bytes(mesh.read_bytes()[:-1])
        with self.assertRaisesRegex(reproduce_paper.Failure, "cut short"):
            reproduce_paper.read_ply(mesh)

    @unittest.skipUnless(os.environ.get("PLUMBLINE_BINARY"), "PLUMBLINE_BINARY names no program")
    def test_the_program_takes_all_that_it_is_told(self):
        """No box shows a chair here and nothing is found: the tables say so, by both rules."""
        self.environment["PLUMBLINE"] = os.environ["PLUMBLINE_BINARY"]
        tables = self.reproduce("--seeds", "0:1", "--samples", "1000", "--edges", "gradient", "--only", "clutter1", "--preset", "default")
        self.assertIn("| 0.0 of 1 | 0.0 | 0.0 |", "\n".join(self.rows(tables, "clutter1")))
        self.assertIn("left out of the truth", tables)
        # The foot of the model that was built stands where the middle of its file's underside is posed: in the scan, chair * (1.2, -.5, 2.3).
        truth = json.loads((self.out / "sequences/visma-clutter1/ground_truth.json").read_text())["instances"]
        self.assertEqual([one["id"] for one in truth], ["swivel_chair_0"])
        c, s = math.cos(0.5), math.sin(0.5)
        in_scan = (1 + 1.2 * c + 2.3 * s, 2 + 1.2 * s - 2.3 * c, 3 - 0.5)
        world_from_scan = reproduce_paper.rigid_inverse(data_set_samples.VISMA_SCAN_FROM_WORLD)
        for row, of_truth in zip(world_from_scan[:3], truth[0]["world_from_object"]):
            self.assertAlmostEqual(of_truth[3], sum(row[k] * in_scan[k] for k in range(3)) + row[3], places=5)


if __name__ == "__main__":
    unittest.main()
