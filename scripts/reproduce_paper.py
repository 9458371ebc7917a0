# SPDX-License-Identifier: Apache-2.0
"""The tables of the paper (Fei and Soatto, Visual-Inertial Object Detection and Mapping, ECCV 2018), ours beside theirs.

Looks under ROOT for VISMA and for the 15 sequences of SceneNN, says what is there and what is missing, converts, maps and
evaluates what is there, and writes into one folder
  tables.md     what is there; Tables 1 and 2 with a row for everything, measured, failed or missing
  results.json  everything that the tables are made of
  sequences/    what was converted, with models and truth; delete a folder and its .json to convert it again
  runs/         a record and a log for each sequence, preset and seed; a second call skips what is done
  figures/      with --figures

Nothing is downloaded. What failed is kept with its log, and tried again by the next call.
"""
import argparse
import concurrent.futures
import dataclasses
import datetime
import hashlib
import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys

from measure import Failure, commit, integers, interval

PROJECT = pathlib.Path(__file__).resolve().parent.parent

# Surface: median, mean, standard deviation, maximum [cm]; pose: mean translation [cm], mean rotation [deg].
# As printed.
TABLE_1 = {name: values.split() for name, values in {
    "clutter1": "1.37 1.99 1.96 17.6 4.39 6.16", "clutter2": "1.11 1.39 1.12 9.88 2.42 4.66",
    "occlusion1": "1.30 1.73 1.45 14.3 3.94 4.86", "occlusion2": "2.01 2.79 2.54 17.9 13.64 9.12"}.items()}
TABLE_2 = {name: values.split() for name, values in {
    "005": "1.84 3.47 3.48 13.7", "025": "0.726 0.756 0.509 3.07", "032": "3.08 6.28 6.95 36.3", "036": "2.25 4.10 5.10 34.3",
    "043": "3.66 4.24 3.11 11.9", "047": "3.10 4.11 3.52 18.5", "073": "2.59 3.04 2.17 8.72", "078": "3.04 3.51 2.60 17.4",
    "080": "2.82 3.15 2.09 13.9", "082": "2.35 3.32 2.99 22.7", "084": "1.29 1.70 1.51 8.33", "096": "0.569 0.684 0.518 4.41",
    "273": "2.06 2.15 1.24 5.75", "522": "1.31 1.69 1.39 5.60", "249": "0.240 0.299 0.217 1.27"}.items()}
WHERE = {
    "VISMA": "https://github.com/feixh/VISMA, section Data of its README: sequences, `RGBD/` and the CAD database",
    "SceneNN": "https://github.com/hkust-vgd/scenenn, README: `NNN.ply`, `NNN.xml`, `trajectory.log` and `oni/NNN.oni`, whose images "
               "its playback tool extracts",
}
# Figure 3 shows streets that the authors did not publish.
FIGURES = [(4, "VISMA", ("clutter2", "occlusion1", "occlusion2"), ("column",)),
           (5, "SceneNN", ("025", "043", "036", "096"), ("column", "truth"))]
# A surfel without a radius, or with a larger one, is drawn with this one [m].
LARGEST_SURFEL = 0.02

# What a file with other contents than expected gives.
UNEXPECTED = (KeyError, IndexError, TypeError, ValueError, StopIteration)


@dataclasses.dataclass
class Found:
    """A sequence of the tables, or another one of VISMA; what is there of it."""
    data_set: str
    name: str
    folder: pathlib.Path | None = None
    lacks: list = dataclasses.field(default_factory=list)  # without these it cannot be measured
    notes: list = dataclasses.field(default_factory=list)
    fragments: pathlib.Path | None = None  # of VISMA, from here on
    alignment: pathlib.Path | None = None
    scan: pathlib.Path | None = None
    cad: pathlib.Path | None = None

    def title(self):
        return f"{self.data_set} {self.name}"

    def stem(self):
        return f"{self.data_set.lower()}-{self.name}"


def first_there(*files):
    return next((file for file in files if file.is_file()), None)


def look(root):
    """What is under ROOT, in the order of the tables; other sequences of VISMA come last."""
    visma, scenes, cads, been = {}, {}, [], set()
    for place, folders, files in os.walk(root, followlinks=True):
        folder = pathlib.Path(place)
        if folder.resolve() in been:  # links may lead in circles
            folders.clear()
            continue
        been.add(folder.resolve())
        if "dataset" in files and any(name.endswith(".png") for name in files):
            visma.setdefault(folder.name.lower(), folder)
        if folder.name.lower().startswith("cad") and any(name.lower().endswith(".obj") for name in files):
            cads.append(folder)
        if folder.name in TABLE_2 and ("image" in folders or folder.name + ".ply" in files or "trajectory.log" in files):
            scenes.setdefault(folder.name, folder)
        folders[:] = sorted(name for name in folders if name not in ("image", "depth"))
    others = sorted(set(visma) - set(TABLE_1))
    return ([look_at_visma(name, visma.get(name), cads) for name in [*TABLE_1, *others]] +
            [look_at_scenenn(root, name, scenes.get(name)) for name in TABLE_2])


def look_at_visma(name, folder, cads):
    found = Found("VISMA", name, folder)
    if folder is None:
        found.lacks.append("not under ROOT")
        return found
    # The places where the reader looks (visma_sequence.cc).
    for place in (folder, folder.parent / "RGBD" / folder.name, folder.parent.parent / "RGBD" / folder.name):
        if (place / "fragments/alignment.json").is_file():
            found.fragments = place / "fragments"
            found.alignment = first_there(place / "fragments/result_alignment.json", place / "result_alignment.json")
            found.scan = first_there(place / "test.klg.ply")
            break
    if found.fragments is None:
        found.lacks.append(f"no RGBD/{folder.name}/fragments/alignment.json")
    elif found.alignment is None:
        found.lacks.append("no result_alignment.json, which brings the truth into the frame of the poses; the authors' evaluation writes it")
    if found.fragments is not None and found.scan is None:
        found.notes.append("no test.klg.ply: nothing is measured against a scan")
    if not cads:
        found.lacks.append("no folder CAD* with *.obj")
    else:
        found.cad = cads[0]
    return found


def look_at_scenenn(root, name, folder):
    found = Found("SceneNN", name, folder)
    if folder is None:
        found.lacks.append("not under ROOT")
        return found
    if not (folder / "image").is_dir():
        oni = next((place / "oni" / f"{name}.oni" for place in (folder, folder.parent, root)
                    if (place / "oni" / f"{name}.oni").is_file()), None)
        found.lacks.append("no image/" + (": extract it from oni/" + oni.name if oni else ""))
    if not first_there(folder / "trajectory.log", folder.parent / "trajectory" / f"{name}_trajectory.log"):
        found.lacks.append("no trajectory.log")
    for ending in ("ply", "xml"):
        if not (folder / f"{name}.{ending}").is_file():
            found.lacks.append(f"no {name}.{ending}, which models and truth are cut out of")
    return found


# VISMA: its models stand in a frame of their own, its scans are clouds in the frame of the scan.

def multiply(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def rigid_inverse(m):
    turned = [[m[c][r] for c in range(3)] for r in range(3)]
    return [[*turned[r], -sum(turned[r][k] * m[k][3] for k in range(3))] for r in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def angle_deg(a, b):
    """Between two unit vectors [deg]."""
    return math.degrees(math.acos(max(-1.0, min(1.0, sum(x * y for x, y in zip(a, b))))))


def cad_from_built(mesh, up):
    """From the frame of a model that `models build --up y --front +x` has built to that of its file. The built one stands on the
    middle of its footprint; which of +y and -y is up is what the builder has found."""
    sign = {"+y": 1.0, "-y": -1.0}[up]
    points = [tuple(map(float, line.split()[1:4])) for line in mesh.read_text(errors="replace").splitlines() if line.startswith("v ")]
    low = [min(point[k] for point in points) for k in range(3)]
    high = [max(point[k] for point in points) for k in range(3)]
    foot = low[1] if sign > 0 else high[1]
    return [[1.0, 0.0, 0.0, (low[0] + high[0]) / 2], [0.0, 0.0, sign, foot], [0.0, -sign, 0.0, (low[2] + high[2]) / 2],
            [0.0, 0.0, 0.0, 1.0]]


# `convert` turns the models' y up, and does not know where their file has its origin.
CONVERTED_FROM_CAD = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]


def pose_as_built(truth, built):
    """Changes the truth that was converted so that it poses the models as they were built; `built` has cad_from_built by name.
    Up is that of the models. Returns what is odd."""
    up, odd = [0.0, 0.0, 0.0], []
    for instance in truth["instances"]:
        model_from_built = multiply(CONVERTED_FROM_CAD, built[instance["model"]])
        instance["world_from_object"] = multiply(instance["world_from_object"], model_from_built)
        up = [up[k] + instance["world_from_object"][k][2] for k in range(3)]
    length = math.sqrt(sum(value * value for value in up))
    if length < 1e-9:
        raise Failure("the aligned models agree on no direction of up")
    truth["gravity"] = [-value / length for value in up]
    for instance in truth["instances"]:
        leaning = angle_deg([-instance["world_from_object"][k][2] for k in range(3)], truth["gravity"])
        if leaning > 20:
            odd.append(f"{instance['id']} leans by {leaning:.0f} degrees against the others")
    return odd


def read_ply(file):
    """Vertices as dicts of rows by property, and triangles, of an ASCII or a little-endian PLY file."""
    types = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H", "int": "i",
             "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d"}
    header, end, body = file.read_bytes().partition(b"end_header")
    body = body[body.find(b"\n") + 1:]
    elements, layout = [], ""
    for line in header.decode("latin-1").splitlines():
        words = line.split()
        if words[:1] == ["format"]:
            layout = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append(words[1:])
    if not end or layout not in ("ascii", "binary_little_endian") or not elements or elements[0][0] != "vertex":
        raise Failure(f"'{file}' is no PLY file, ASCII or little-endian, that begins with vertices")
    _, count, properties = elements[0]
    names = [words[-1] for words in properties]
    if any(words[0] == "list" for words in properties) or not {"x", "y", "z"} <= set(names):
        raise Failure(f"'{file}' has no vertices with x, y and z")
    faces = elements[1] if len(elements) > 1 and elements[1][0] == "face" else ("face", 0, [])
    if faces[1] and (len(faces[2]) != 1 or faces[2][0][0] != "list"):
        raise Failure(f"'{file}' has faces with more than their vertices")
    try:
        if layout == "ascii":
            lines = body.decode("latin-1").splitlines()
            rows = [tuple(map(float, line.split())) for line in lines[:count]]
            lists = [list(map(int, line.split()))[1:] for line in lines[count:count + faces[1]]]
            if len(rows) != count or any(len(row) != len(names) for row in rows) or len(lists) != faces[1]:
                raise ValueError("too few rows")
        else:
            row = struct.Struct("<" + "".join(types[words[0]] for words in properties))
            if len(body) < count * row.size:
                raise ValueError("too few bytes")
            rows = list(row.iter_unpack(body[:count * row.size]))
            at, lists = count * row.size, []
            for _ in range(faces[1]):
                length = struct.unpack_from("<" + types[faces[2][0][1]], body, at)[0]
                at += struct.calcsize(types[faces[2][0][1]])
                numbers = struct.Struct(f"<{length}" + types[faces[2][0][2]])
                lists.append(numbers.unpack_from(body, at))
                at += numbers.size
    except (ValueError, KeyError, struct.error) as error:
        raise Failure(f"'{file}' is cut short or damaged: {error}") from error
    triangles = [(polygon[0], polygon[k], polygon[k + 1]) for polygon in lists for k in range(1, len(polygon) - 1)]
    if any(not 0 <= vertex < count for triangle in triangles for vertex in triangle):
        raise Failure(f"'{file}' has triangles of vertices that it has not")
    return names, rows, triangles


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def mesh_of_scan(source, target, world_from_scan):
    """Writes a scan as triangles in the world. A mesh stays one; of a cloud every point with a normal becomes a square of its
    surfel's radius, as ElasticFusion's clouds mean it. Returns what was done."""
    names, rows, triangles = read_ply(source)
    column = {name: index for index, name in enumerate(names)}
    surfels = not triangles
    if surfels and not {"nx", "ny", "nz"} <= set(column):
        raise Failure(f"'{source}' has neither triangles nor normals")
    turn = [row[:3] for row in world_from_scan[:3]]

    def turned(vector):
        return [sum(turn[r][k] * vector[k] for k in range(3)) for r in range(3)]

    vertices = bytearray()
    kept = 0
    for row in rows:
        point = turned([row[column[axis]] for axis in "xyz"])
        point = [point[k] + world_from_scan[k][3] for k in range(3)]
        if not surfels:
            vertices += struct.pack("<3f", *point)
            continue
        normal = turned([row[column[axis]] for axis in ("nx", "ny", "nz")])
        length = math.sqrt(sum(value * value for value in normal))
        if not 0.5 < length < 2 or not all(map(math.isfinite, point)):
            continue
        radius = row[column["radius"]] if "radius" in column else LARGEST_SURFEL / 2
        radius = min(radius, LARGEST_SURFEL) if radius > 0 else LARGEST_SURFEL / 2
        normal = [value / length for value in normal]
        axis = [float(k == min(range(3), key=lambda j: abs(normal[j]))) for k in range(3)]
        across = cross(axis, normal)
        norm = math.sqrt(sum(value * value for value in across))
        across = [radius * value / norm for value in across]
        along = cross(normal, across)
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            vertices += struct.pack("<3f", *(point[k] + a * across[k] + b * along[k] for k in range(3)))
        triangles += [(4 * kept, 4 * kept + 1, 4 * kept + 2), (4 * kept, 4 * kept + 2, 4 * kept + 3)]
        kept += 1
    if not triangles:
        raise Failure(f"'{source}' has no point with a normal")
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices) // 12}\nproperty float x\nproperty float y\n"
              f"property float z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    with open(target, "wb") as file:
        file.write(header.encode())
        file.write(vertices)
        file.write(b"".join(struct.pack("<B3i", 3, *triangle) for triangle in triangles))
    return f"its scan is a cloud: {kept} surfels were drawn as squares" if surfels else ""


def write_whole(file, text):
    part = file.with_name(file.name + ".part")
    part.write_text(text)
    part.replace(file)


class Reproduction:
    def __init__(self, arguments):
        self.arguments = arguments
        self.out = pathlib.Path(arguments.out).resolve()
        self.sequences, self.runs, self.figures = self.out / "sequences", self.out / "runs", self.out / "figures"
        for folder in (self.sequences, self.runs):
            folder.mkdir(parents=True, exist_ok=True)
        program = pathlib.Path(os.environ.get("PLUMBLINE", PROJECT / "build/bin/plumbline"))
        if not program.exists():
            sys.exit(f"reproduce_paper: there is no {program}; run ./dev build first, or set PLUMBLINE")
        # A copy, so that the program may be built again meanwhile.
        self.program_hash = hashlib.sha256(program.read_bytes()).hexdigest()[:12]
        self.program = self.out / f"plumbline-{self.program_hash}"
        if not self.program.exists():
            part = self.out / f"plumbline-{os.getpid()}.part"
            shutil.copy2(program, part)
            part.replace(self.program)

    def call(self, log, *words):
        """Runs the program; what it says goes into the log, and the last of it into the failure."""
        with open(log, "a", encoding="utf-8") as file:
            file.write("plumbline " + " ".join(map(str, words)) + "\n")
            process = subprocess.run([str(self.program), *map(str, words)], capture_output=True, text=True, errors="replace", check=False)
            file.write(process.stdout + process.stderr + f"ended with {process.returncode}\n")
        if process.returncode != 0:
            lines = [line for line in (process.stderr or process.stdout).splitlines() if line.strip()]
            raise Failure(lines[-1].strip() if lines else f"'{words[0]}' ended with {process.returncode} without a word")

    def prepare(self, found):
        """The folder of a sequence in our layout, with models and truth, and what is odd about it; made once."""
        folder = self.sequences / found.stem()
        done = self.sequences / (found.stem() + ".json")
        inputs = [str(path) for path in (found.folder, found.fragments, found.alignment, found.scan, found.cad)]
        if done.exists():
            made = json.loads(done.read_text())
            if made["of"] == inputs and folder.exists():
                return folder, made
        if self.arguments.dry_run:
            raise Failure("not converted yet (dry run)")
        done.unlink(missing_ok=True)
        shutil.rmtree(folder, ignore_errors=True)
        log, said = self.sequences / (found.stem() + ".log"), self.sequences / (found.stem() + ".said")
        log.unlink(missing_ok=True)
        print(f"{found.title()}: converting", flush=True)
        try:
            self.call(log, "convert", found.folder, "--out", folder, "--json", said)
            odd = json.loads(said.read_text()).get("odd", [])  # names files by their full paths
            odd = [line.replace(str(found.folder.parent) + "/", "").replace(str(self.arguments.root) + "/", "") for line in odd]
            if found.data_set == "VISMA":
                # Of gravity, build_visma speaks once it is known which end of the models is up.
                odd = [line for line in odd if "tells a gravity" not in line] + self.build_visma(found, folder, log)
            if not (folder / "ground_truth.json").exists() or not (folder / "models/models.json").exists():
                raise Failure("no instance of a category that is mapped was found: there is no truth to measure against")
        except Failure as failure:
            raise Failure(f"{failure} (log: {log.relative_to(self.out)})") from failure
        except UNEXPECTED as error:
            raise Failure(f"a file was not understood: {error!r} (log: {log.relative_to(self.out)})") from error
        finally:
            said.unlink(missing_ok=True)
        made = {"of": inputs, "program": self.program_hash, "odd": odd, "made": datetime.datetime.now().isoformat(timespec="seconds")}
        write_whole(done, json.dumps(made, indent=1))
        return folder, made

    def build_visma(self, found, folder, log):
        """Models from the CAD database, y up; the truth as they were built; the scan as triangles in the world."""
        truth_file = folder / "ground_truth.json"
        truth = json.loads(truth_file.read_text())
        categories = {instance["model"]: instance["category"] for instance in truth["instances"]}
        built, odd = {}, []
        for mesh in sorted(path for path in found.cad.iterdir() if path.suffix.lower() == ".obj"):
            words = ["--category", categories[mesh.stem]] if mesh.stem in categories else []
            try:
                self.call(log, "models", "build", mesh, "--out", folder / "models", "--unit", "m", "--up", "y", "--front", "+x", *words)
            except Failure as failure:
                if words:
                    raise
                odd.append(f"{mesh.name} is not in the database: {failure}")
                continue
            entry = next(model for model in json.loads((folder / "models/models.json").read_text())["models"] if model["name"] == mesh.stem)
            built[mesh.stem] = cad_from_built(mesh, entry["source"]["up"])
        absent = sorted(set(categories) - set(built))
        if absent:
            odd.append("the CAD database has no " + ", ".join(absent) + "; their instances are left out of the truth")
            truth["instances"] = [instance for instance in truth["instances"] if instance["model"] in built]
        if not truth["instances"]:
            raise Failure(f"'{found.cad}' has none of the models that are aligned: " + ", ".join(absent))
        odd += pose_as_built(truth, built)
        gravity = json.loads((folder / "gravity.json").read_text())["gravity"] if (folder / "gravity.json").exists() else None
        if gravity:
            apart = angle_deg(gravity, truth["gravity"])
            if apart > 5:
                odd.append(f"'dataset' tells a gravity {apart:.0f} degrees off the up axes of the aligned models")
        truth_file.write_text(json.dumps(truth, indent=1))
        if found.scan:
            rows = json.loads(found.alignment.read_text())["T_ef_corvis"]
            scan_from_world = [list(map(float, rows[4 * r:4 * r + 4])) for r in range(3)]
            try:
                told = mesh_of_scan(found.scan, folder / "scene.ply", rigid_inverse(scan_from_world))
                odd += [told] if told else []
            except Failure as failure:
                odd.append(f"{failure}: nothing is measured against a scan")
        return odd

    def options_of(self, preset, seed):
        arguments = self.arguments
        words = ["--preset", preset, "--seed", seed]
        for option in ("detector", "edges", "frames"):
            if getattr(arguments, option):
                words += ["--" + option, getattr(arguments, option)]
        return words

    def record_of(self, found, made, preset, seed):
        words = [str(word) for word in self.options_of(preset, seed)]
        key = json.dumps([found.title(), self.program_hash, words, self.arguments.samples, made])
        return self.runs / f"{found.stem()}-{preset}-s{seed}-{hashlib.sha256(key.encode()).hexdigest()[:8]}.json"

    def run(self, found, folder, made, preset, seed):
        """The record of one run, from its file if it is done. A failure is a record too, and tried again."""
        file = self.record_of(found, made, preset, seed)
        if file.exists():
            record = json.loads(file.read_text())
            if "failed" not in record or self.arguments.dry_run:
                return record
        words = self.options_of(preset, seed)
        record = {"data_set": found.data_set, "sequence": found.name, "preset": preset, "seed": seed, "options": list(map(str, words)),
                  "samples": self.arguments.samples, "program": self.program_hash, "commit": commit()}
        if self.arguments.dry_run:
            return {**record, "planned": True}
        run_file, log = file.with_suffix(".plb"), file.with_suffix(".log")
        summary, judged = file.with_suffix(".run"), file.with_suffix(".judged")
        # What a killed call left: a run file comes with a journal and a lock.
        for old in (log, *run_file.parent.glob(run_file.name + "*")):
            old.unlink(missing_ok=True)
        judge = ["--ground-truth", folder / "ground_truth.json", "--models", folder / "models", "--samples", self.arguments.samples,
                 "--single-frames", 0]
        if (folder / "scene.ply").exists():
            judge += ["--scene", folder / "scene.ply"]
        try:
            self.call(log, "run", folder, "--out", run_file, "--models", folder / "models", "--json", summary, *words)
            self.call(log, "evaluate", run_file, *judge, "--json", judged)
            said, told = json.loads(summary.read_text()), json.loads(judged.read_text())
            record.update(end_frame=said["run"]["end_frame"], frames=said["frames"], skipped=said["skipped"],
                          fps=said["fps"], **{key: told[key] for key in ("surfaces", "all", "matched", "missed", "spurious", "placement",
                                                                         "objects", "missed_instances")})
            # Run files are large: one of each sequence that a figure shows stays.
            shown = any(found.data_set == data_set and found.name in names for _, data_set, names, _ in FIGURES)
            if self.arguments.keep or (shown and (preset, seed) == (self.arguments.preset[0], self.arguments.seeds[0])):
                record["run_file"] = run_file.name
            else:
                run_file.unlink(missing_ok=True)
        except Failure as failure:
            record.update(failed=str(failure), log=str(log.relative_to(self.out)))
        except UNEXPECTED as error:
            record.update(failed=f"the program's answer was not understood: {error!r}", log=str(log.relative_to(self.out)))
        for part in (summary, judged):
            part.unlink(missing_ok=True)
        write_whole(file, json.dumps(record, indent=1))
        return record

    def measure(self, found):
        """What became of a sequence: {missing} or {failed}, or its runs and what was odd."""
        if found.lacks:
            return {"missing": "; ".join(found.lacks)}
        try:
            folder, made = self.prepare(found)
        except Failure as failure:
            return {"planned" if self.arguments.dry_run else "failed": str(failure)}
        jobs = [(preset, seed) for preset in self.arguments.preset for seed in self.arguments.seeds]
        runs = []
        with concurrent.futures.ThreadPoolExecutor(self.arguments.jobs) as pool:
            for record in pool.map(lambda job: self.run(found, folder, made, *job), jobs):
                runs.append(record)
                said = (record.get("failed") or ("not run yet (dry run)" if "planned" in record else
                                                 "{matched} found, {missed} missed, {spurious} spurious".format(**record)))
                print(f"{found.title()}, {record['preset']}, seed {record['seed']}: {said}", flush=True)
        return {"odd": made["odd"], "runs": runs}

    def draw(self, results):
        """The pictures of figures 4 and 5 of the first run that is done of each sequence; lines that say what there is."""
        outcomes = {(found.data_set, found.name): outcome for found, outcome in results}
        lines = ["- Figure 3 (streets): missing; the authors' recordings were not published. `plumbline render RUN.plb --layout insets` "
                 "draws a run of your own so."]
        for number, data_set, names, layouts in FIGURES:
            for name in names:
                outcome = outcomes.get((data_set, name), {"missing": "not asked for"})
                record = next((run for run in outcome.get("runs", []) if "run_file" in run), None)
                if record is None:
                    lines.append(f"- Figure {number}, {data_set} {name}: missing; {why_not(outcome)}.")
                    continue
                for layout in layouts:
                    folder = self.figures / f"figure{number}-{data_set.lower()}-{name}-{layout}"
                    run_file, frame = self.runs / record["run_file"], record["end_frame"] - 1
                    of = f"{record['run_file']} frame {frame}"
                    mark = folder / "of.txt"
                    if not (mark.exists() and mark.read_text() == of):
                        shutil.rmtree(folder, ignore_errors=True)
                        self.figures.mkdir(exist_ok=True)
                        try:
                            self.call(self.figures / (folder.name + ".log"), "render", run_file, "--layout", layout, "--frames",
                                      f"{frame}:{frame + 1}", "--size", "1600x1000", "--light", "--out", folder)
                            mark.write_text(of)
                        except Failure as failure:
                            lines.append(f"- Figure {number}, {data_set} {name}, {layout}: **failed**; {failure}.")
                            continue
                    pictures = ", ".join(str(path.relative_to(self.out)) for path in sorted(folder.glob("*.png")))
                    lines.append(f"- Figure {number}, {data_set} {name}, {layout}: {pictures} ({record['preset']}, seed {record['seed']}, "
                                 "last frame).")
        return lines


def why_not(outcome):
    failed = [run["failed"] for run in outcome.get("runs", []) if "failed" in run]
    done = any("surfaces" in run for run in outcome.get("runs", []))
    return outcome.get("missing") or outcome.get("failed") or outcome.get("planned") or (
        "no run file of it was kept: delete its records in runs/ and call again with --keep" if done else failed[0] if failed else "not run yet")


def cell(text):
    return str(text).replace("|", "\\|").replace("\n", " ")


def inventory(results):
    lines = ["| data set | sequence | | |", "|---|---|---|---|"]
    for found, outcome in results:
        state = "there" if not found.lacks else "missing" if found.folder is None else "incomplete"
        told = found.lacks + found.notes + outcome.get("odd", [])
        lines.append(f"| {found.data_set} | {found.name} | {state} | {cell('; '.join(told))} |")
    others = [found for found, _ in results if found.data_set == "VISMA" and found.name not in TABLE_1]
    lines += ["", f"VISMA has 8 sequences; the paper measures 4, and names no others. {len(others)} other(s) under ROOT.", ""]
    return lines + [f"- {data_set}: {place}." for data_set, place in WHERE.items()]


def statistics_cells(runs, value):
    """Median, mean, standard deviation, maximum [cm] over runs; `value` takes the statistics out of a record."""
    return [interval([100 * one[key] for one in map(value, runs) if one and one.get(key) is not None])
            for key in ("median_m", "mean_m", "std_m", "max_m")]


def pose_cells(runs, value):
    poses = [one for one in map(value, runs) if one]
    return [interval([scale * one[key] for one in poses if one.get(key) is not None])
            for key, scale in (("mean_translation_m", 100), ("mean_rotation_deg", 1))]


def rows_of(found, paper, outcome, presets):
    """A sequence in a table: the paper's row, ours by each rule, and what is missing."""
    rows = [[found.name, "the paper", *paper, *["-"] * (9 - len(paper))] if paper else
            [found.name, "not in the paper's tables", *["-"] * 9]]
    if "runs" not in outcome:
        kind = next(key for key in ("missing", "failed", "planned") if key in outcome)
        rows.append(["", f"ours: **{kind}**: {outcome[kind]}", *["-"] * 9])
        return rows
    for preset in presets:
        runs = [run for run in outcome["runs"] if run["preset"] == preset]
        done = [run for run in runs if "surfaces" in run]
        for run in runs:
            if "failed" in run:
                rows.append(["", f"ours, preset {preset}, seed {run['seed']}: **failed**: {run['failed']} (log: {run['log']})", *["-"] * 9])
        if not done:
            if any("planned" in run for run in runs):
                rows.append(["", f"ours, preset {preset}: **planned**: not run yet (dry run)", *["-"] * 9])
            continue
        surface = {name: (lambda run, name=name: run["surfaces"].get(name)) for name in ("paper", "visma", "scanned", "posed")}
        ours = f"ours, preset {preset}" + (f" ({len(done)} of {len(runs)} seeds)" if len(done) < len(runs) else "")
        share = interval([100 * one["share"] for one in map(surface["scanned"], done)
                          if one and one["mean_m"] is not None], "{:.0f}")
        placed = [interval([run["matched"] for run in done], "{:.1f}") + f" of {done[0]['matched'] + done[0]['missed']}",
                  interval([run["placement"]["scan2cad"]["right"] for run in done], "{:.1f}"),
                  interval([run["spurious"] for run in done], "{:.1f}")]
        rows.append(["", f"{ours}: by the paper's rule",
                     *statistics_cells(done, lambda run: (surface["paper"](run) or {}).get("to_plane")),
                     *pose_cells(done, lambda run: (surface["paper"](run) or {}).get("all")), *["-"] * 3])
        if found.data_set == "VISMA":
            rows.append(["", f"{ours}: as VISMA's code", *statistics_cells(done, surface["visma"]), *["-"] * 5])
        rows.append(["", f"{ours}: honest, to the scan where it was scanned ({share} %)", *statistics_cells(done, surface["scanned"]),
                     *pose_cells(done, lambda run: run["all"]), *placed])
        rows.append(["", f"{ours}: honest, to the posed truth", *statistics_cells(done, surface["posed"]), *["-"] * 5])
    return rows


def table(results, data_set, paper, presets):
    head = ["sequence", "", "median [cm]", "mean [cm]", "std [cm]", "max [cm]", "trans. [cm]", "rot. [deg]", "found", "right", "spurious"]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for found, outcome in results:
        if found.data_set == data_set:
            lines += ["| " + " | ".join(map(cell, row)) + " |" for row in rows_of(found, paper.get(found.name), outcome, presets)]
    absent = sorted(set(paper) - {found.name for found, _ in results if found.data_set == data_set})
    return lines + (["", "Not asked for (`--only`): " + ", ".join(absent) + "."] if absent else [])


def tables(reproduction, results, figures):
    arguments = reproduction.arguments
    options = [f"{name} {getattr(arguments, name) or default}" for name, default in
               (("detector", "as the program chooses"), ("edges", "as the program chooses"), ("frames", "all"))]
    lines = ["# The paper's tables", "",
             f"Commit {commit()}, program {reproduction.program_hash}, {datetime.date.today().isoformat()}; presets "
             f"{', '.join(arguments.preset)}; seeds {', '.join(map(str, arguments.seeds))}; {'; '.join(options)}; {arguments.samples} points.",
             "Command: `scripts/reproduce_paper.sh " + " ".join(sys.argv[1:]) + "`.", "",
             "± is half of the 95 % confidence interval over seeds (Student's t). *By the paper's rule*: the map is brought onto the scan by "
             "a rigid ICP, distances are along the normal, poses come after it. *Honest*: no ICP; only what was scanned is measured, poses "
             "of all that were found. *Found*: within 50 cm. *Right*: within 20 cm, 20 degrees and 20 % of size. What is missed raises no "
             "error, and a seed in which nothing was found has none, so look at *found* first. Definitions: docs/algorithms/evaluation.md.", "", "## What is there", "",
             *inventory(results), "", "## Table 1: VISMA", "", *table(results, "VISMA", TABLE_1, arguments.preset), "",
             "## Table 2: SceneNN", "", *table(results, "SceneNN", TABLE_2, arguments.preset), ""]
    return "\n".join(lines + ["## Figures", "", *figures, ""] if figures else lines) + "\n"


def parse():
    parser = argparse.ArgumentParser(prog="reproduce_paper.sh", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", metavar="ROOT", help="folder that VISMA and SceneNN are somewhere under")
    parser.add_argument("--only", default="", metavar="NAME,..", help="VISMA, SceneNN, or names of sequences (default: all)")
    parser.add_argument("--seeds", type=integers, default=[0, 1, 2], metavar="A:B", help="seeds of the mapper, B not included (default 0:3)")
    parser.add_argument("--preset", default="default,paper", metavar="NAME,..", help="default, paper or both (default)")
    parser.add_argument("--detector", metavar="NETWORK", help="as of `plumbline run`")
    parser.add_argument("--edges", metavar="NETWORK|builtin|gradient", help="as of `plumbline run`")
    parser.add_argument("--frames", metavar="A:B", help="of every sequence (default: all)")
    parser.add_argument("--samples", type=int, default=500_000, metavar="N", help="points drawn on each surface (default 500000)")
    parser.add_argument("--figures", action="store_true", help="draw figures 4 and 5, too")
    parser.add_argument("--keep", action="store_true", help="keep all run files, which are large (default: one of each sequence of the figures)")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="runs at once (default 1)")
    parser.add_argument("--dry-run", action="store_true", help="convert, run and draw nothing: what is there, and the tables so far")
    parser.add_argument("--out", default=str(PROJECT / "build/reproduce_paper"), metavar="DIR")
    arguments = parser.parse_args()
    root = pathlib.Path(arguments.root).expanduser()
    if not root.is_dir():
        parser.error(f"there is no folder '{arguments.root}'")
    arguments.preset = [name.strip() for name in arguments.preset.split(",") if name.strip()]
    if not arguments.preset or not set(arguments.preset) <= {"default", "paper"}:
        parser.error("--preset is default, paper or default,paper")
    if not arguments.seeds or min(arguments.seeds) < 0 or arguments.jobs < 1 or arguments.samples < 1:
        parser.error("--seeds must name whole numbers from 0, and --jobs and --samples be at least 1")
    arguments.root = str(root.resolve())
    return arguments


def chosen(names, everything):
    """The sequences that were asked for by data set or name."""
    wanted = {name.strip().lower() for name in names.split(",") if name.strip()}
    known = {name.lower() for found in everything for name in (found.data_set, found.name)}
    for name in sorted(wanted - known):
        sys.exit(f"reproduce_paper: there is no sequence '{name}'; there are {', '.join(sorted(known))}")
    return [found for found in everything if not wanted or {found.data_set.lower(), found.name} & wanted]


def main():
    arguments = parse()
    asked_for = chosen(arguments.only, look(pathlib.Path(arguments.root)))
    reproduction = Reproduction(arguments)
    print("\n".join(inventory([(found, {}) for found in asked_for])) + "\n", flush=True)

    def write(results, figures):
        text = tables(reproduction, results, figures)
        write_whole(reproduction.out / "tables.md", text)
        write_whole(reproduction.out / "results.json", json.dumps(
            {"commit": commit(), "program": reproduction.program_hash, "arguments": vars(arguments), "figures": figures,
             "sequences": [{"data_set": found.data_set, "name": found.name, "folder": found.folder and str(found.folder),
                            "notes": found.notes, "paper": (TABLE_1 | TABLE_2).get(found.name), **outcome}
                           for found, outcome in results]}, indent=1))
        return text

    results = []
    for index, found in enumerate(asked_for):
        results.append((found, reproduction.measure(found)))
        write(results + [(later, {"planned": "not reached yet"}) for later in asked_for[index + 1:]], [])
    figures = reproduction.draw(results) if arguments.figures and not arguments.dry_run else []
    text = write(results, figures)
    print(re.sub(r"(?s).*?(?=^## Table 1)", "", text, count=1, flags=re.M))
    print(f"wrote {reproduction.out / 'tables.md'}")
    return any("failed" in outcome or any("failed" in run for run in outcome.get("runs", [])) for _, outcome in results) or any(
        "**failed**" in line for line in figures)


if __name__ == "__main__":
    sys.exit(main())
