# SPDX-License-Identifier: Apache-2.0
"""Measures the mapper: every figure of README.md, docs/accuracy.md (by accuracy_page.py) and docs/algorithms/smoothing.md.

Runs `plumbline run` and `plumbline evaluate` on real and synthetic rooms, over seeds, and writes into one folder
  tables.md     for each set of rooms: a row for each run, a row for each instance, found or missed
  results.json  everything that the tables are made of, and more
  runs/         one JSON for each finished run; a second call skips what is there

Nothing is chosen: all seeds, all instances and all failures are in the tables.
"""
import argparse
import collections
import concurrent.futures
import csv
import dataclasses
import datetime
import hashlib
import json
import math
import os
import pathlib
import random
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Synthetic rooms. Constants are tuned on the first seeds only and judged on the second.
TUNING_SEEDS = list(range(1, 11))
HELD_OUT_SEEDS = list(range(101, 121))
ROOM_FRAMES = ("--frames", "300")
SCENE_FILM = ("--size", "640x480", "--light-rays", "16")  # larger ones take several minutes each
CLAIM_FILM = ("--frames", "200", "--rate", "20", *SCENE_FILM)
OWN_POSE_SEEDS = HELD_OUT_SEEDS[:10]
OWN_POSE_FILM = ("--imu", "--rest", "2", "--size", "640x480", "--rate", "20", "--light-rays", "16")
CLAIMS = ["occlusion", "clutter", "blur", "lowcontrast", "truncation", "duplicate", "variant"]  # of the paper
SCENES = ["wall", "rows", "revisit", "twins", "office"]  # each with one difficulty, as long as its story takes
SCENE_SEEDS = list(range(201, 206))  # not tuned on either
# Size [px], view from left to right [deg], frames per second. The other rooms are 640x480, 81 degrees and 20 Hz.
SENSORS = {"small": ("320x240", "60", "20"), "portrait": ("480x640", "60", "20"), "odd": ("721x405", "81", "20"),
           "wide": ("640x480", "120", "20"), "large": ("1920x1080", "70", "20"), "slow": ("640x480", "81", "5"),
           "fast": ("640x480", "81", "60")}
SENSOR_SEEDS = list(range(301, 306))  # not tuned on either
SENSOR_FILM_S = 12

# Instances that show for less are listed, but are not among those that should be found.
SHOWS_WELL_S = 2.0

FASTESTDET = "models/fastestdet/FastestDet.onnx"

# One cue off at a time; "as it is" comes first and is what the others are compared with.
ABLATIONS = {
    "as it is": [],
    "no edges": ["beta=0", "evidence_per_edge=0"],
    "no detector": ["alpha=0", "detection_rate=0"],
    "no inner lines": ["inner_lines=false"],
    "no floor prior": ["floor_prior=false"],
    "no key frames": ["key_frames=0"],
    "paper's births": ["prior=paper"],
}

# Filters to compare with (docs/algorithms/paper_filter.md). The authors' thresholds were for another detector and edges.
PRESETS = {
    "paper": {"as the authors had it": [],
              "the same, lower thresholds": ["paper_min_score=0.35", "paper_min_box_share=0", "paper_edge_threshold=32"]},
}


@dataclasses.dataclass
class RoomSet:
    """Sequences that are measured alike and share a table."""
    name: str
    what: str
    seeds: list  # of the mapper
    folder: str = ""  # of a real room, in the data folder
    scene: str = ""  # or of synthetic rooms, filmed when they are needed
    room_seeds: list = dataclasses.field(default_factory=list)
    film: tuple = ()  # more words for `plumbline synth`
    detector: str = "dataset"  # or a network in the data folder
    edges: str = "gradient"  # dataset, builtin, gradient, or a network in the data folder
    scan: bool = False  # measure surfaces against scene.ply
    own_poses: bool = False  # repeat every run with poses of its own images and IMU
    ignored: tuple = ()
    asked_for: bool = False  # measured only when asked for by name


def all_sets():
    sets = [
        RoomSet("demo", "the built-in demo room: synthetic, seed 1", list(range(10)), scene="room", room_seeds=[1],
                film=("--frames", "150")),
        RoomSet("office", "a real office that nothing was tuned on, boxes of PicoDet", list(range(10)),
                folder="data/office", edges="builtin", scan=True),
        RoomSet("office-fastestdet", "the same office, boxes of FastestDet", list(range(10)), folder="data/office",
                detector=FASTESTDET, edges="builtin", scan=True),
        RoomSet("kitchen", "a real kitchen, boxes of FastestDet", list(range(10)), folder="data/kitchen",
                detector=FASTESTDET, edges="builtin", scan=True, ignored=("container", "game controller")),
        RoomSet("kitchen-own-poses", "the same kitchen; poses given, then estimated from images and IMU and aligned by the trajectories",
                list(range(6)), folder="data/kitchen", detector=FASTESTDET, edges="builtin", own_poses=True,
                ignored=("container", "game controller"), asked_for=True),
        RoomSet("rooms", "synthetic rooms that nothing was tuned on, edges of the images", list(range(3)), scene="room",
                room_seeds=HELD_OUT_SEEDS, film=ROOM_FRAMES),
        RoomSet("rooms-given", "the same rooms, edges given", list(range(3)), scene="room", room_seeds=HELD_OUT_SEEDS,
                film=ROOM_FRAMES, edges="dataset"),
        RoomSet("rooms-flawless", "the same rooms, boxes and edges without a flaw", list(range(3)), scene="room",
                room_seeds=HELD_OUT_SEEDS, film=(*ROOM_FRAMES, "--flawless"), edges="dataset", asked_for=True),
        RoomSet("own-poses", "rooms filmed with an IMU after 2 s of rest, edges of the images; poses given, then estimated from images and IMU "
                "and aligned by the trajectories", [0], scene="room", room_seeds=OWN_POSE_SEEDS, film=OWN_POSE_FILM, own_poses=True,
                asked_for=True),
        RoomSet("rooms-imu", "the rooms of own-poses and ten more, poses given, edges of the images", list(range(3)), scene="room",
                room_seeds=HELD_OUT_SEEDS, film=OWN_POSE_FILM, asked_for=True),
        RoomSet("tuning", "synthetic rooms for tuning, edges of the images", [0], scene="room", room_seeds=TUNING_SEEDS,
                film=ROOM_FRAMES, asked_for=True),
    ]
    for scene in CLAIMS:
        sets.append(RoomSet("claim-" + scene, f"synthetic scenes '{scene}', edges of the images", [0], scene=scene,
                            room_seeds=SCENE_SEEDS, film=CLAIM_FILM))
    for scene in SCENES:
        sets.append(RoomSet("scene-" + scene, f"synthetic scenes '{scene}', edges of the images", [0], scene=scene,
                            room_seeds=SCENE_SEEDS, film=SCENE_FILM))
    for rate in ("5", "10", "30", "60"):
        sets.append(RoomSet("scene-rates-" + rate, f"one walk at {rate} Hz, edges of the images", [0], scene="rates",
                            room_seeds=SCENE_SEEDS, film=("--rate", rate, *SCENE_FILM)))
    for name, (size, fov, rate) in SENSORS.items():
        sets.append(RoomSet("sensor-" + name, f"the same rooms by a camera of {size} pixels and {fov} degrees at {rate} Hz, edges of the "
                            "images", [0], scene="room", room_seeds=SENSOR_SEEDS,
                            film=("--size", size, "--fov", fov, "--rate", rate, "--frames", str(SENSOR_FILM_S * int(rate)),
                                  "--light-rays", "16"), asked_for=True))
    return sets


@dataclasses.dataclass
class Job:
    """One run: a sequence, a seed, settings."""
    set: RoomSet
    sequence: pathlib.Path
    room: str
    seed: int
    variant: str
    preset: str
    settings: list
    poses: str = ""  # instead of the sequence's own


class Failure(Exception):
    pass


def integers(text):
    """'3', '0:5' (5 not included), '1,4,7'."""
    values = []
    for part in text.split(","):
        first, colon, last = part.partition(":")
        values += range(int(first), int(last)) if colon else [int(first)]
    return values


def turned(by, rotation):
    """Exp(by) times a quaternion (x, y, z, w)."""
    angle = math.sqrt(sum(value * value for value in by))
    scale = math.sin(angle / 2) / angle if angle > 0 else 0.5
    ax, ay, az, aw = by[0] * scale, by[1] * scale, by[2] * scale, math.cos(angle / 2)
    bx, by_, bz, bw = rotation
    return [aw * bx + ax * bw + ay * bz - az * by_, aw * by_ - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by_ - ay * bx + az * bw, aw * bw - ax * bx - ay * by_ - az * bz]


def pose_noise(text):
    """'0.01,0.3' or '0.01,0.3,untold'."""
    parts = text.split(",")
    if len(parts) not in (2, 3) or parts[2:] not in ([], ["untold"]):
        raise argparse.ArgumentTypeError(f"'{text}' is not METRES,DEGREES[,untold]")
    return [float(parts[0]), float(parts[1]), len(parts) == 2]


def last_line(process):
    lines = [line for line in (process.stderr + "\n" + process.stdout).splitlines() if line.strip()]
    return lines[-1] if lines else f"ended with {process.returncode} without a word"


class Measurement:
    def __init__(self, arguments):
        self.arguments = arguments
        self.data = pathlib.Path(os.environ.get("PLUMBLINE_DATA", ROOT.parent / "shared")).resolve()
        self.out = pathlib.Path(arguments.out).resolve()
        cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME", pathlib.Path.home() / ".cache"))
        self.rooms = cache / "plumbline" / "measure"
        (self.out / "runs").mkdir(parents=True, exist_ok=True)
        program = pathlib.Path(os.environ.get("PLUMBLINE", ROOT / "build/bin/plumbline"))
        if not program.exists():
            sys.exit(f"measure: there is no {program}; run ./dev build first, or set PLUMBLINE")
        # A copy, so that the program may be built again meanwhile.
        self.program_hash = hashlib.sha256(program.read_bytes()).hexdigest()[:12]
        self.program = self.out / f"plumbline-{self.program_hash}"
        if not self.program.exists():
            shutil.copy2(program, self.program)

    def call(self, *words):
        return subprocess.run([str(self.program), *map(str, words)], capture_output=True, text=True, check=False)

    def film(self, room_set, room_seed):
        """The folder of a synthetic room; filmed once, whatever the program (delete the cache to film it anew)."""
        folder = self.rooms / "-".join([room_set.scene, str(room_seed), *room_set.film[1:]])
        done = self.rooms / (folder.name + ".complete")
        if not done.exists():
            print(f"filming {folder.name}", flush=True)
            self.rooms.mkdir(parents=True, exist_ok=True)
            process = self.call("synth", "--out", folder, "--scene", room_set.scene, "--seed", room_seed,
                                *room_set.film)
            if process.returncode != 0:
                raise Failure(last_line(process))
            done.write_text("complete\n")
        return folder

    def jobs_of(self, room_set):
        """All runs of a set. Raises Failure where its data is absent."""
        arguments = self.arguments
        sequences = []
        if room_set.folder:
            folder = self.data / room_set.folder
            if not folder.exists():
                raise Failure(f"{room_set.folder} is not in the data folder (PLUMBLINE_DATA)")
            sequences.append((folder, folder.name))
        for seed in (arguments.rooms or room_set.room_seeds) if room_set.scene else []:
            sequences.append((self.film(room_set, seed), f"{room_set.scene} {seed}"))
        if arguments.backwards:
            if room_set.own_poses:
                raise Failure("own poses need the IMU, which --backwards leaves out")
            sequences = [(self.backwards(folder), room + " backwards") for folder, room in sequences]
        variants = {"as it is": ("default", [])}
        if arguments.ablate is not None:
            names = [name.strip() for name in arguments.ablate.split(",") if name.strip()] or list(ABLATIONS)
            variants.update({name: ("default", ABLATIONS[name]) for name in names})
        if arguments.preset:
            variants.update({name: (arguments.preset, settings)
                             for name, settings in PRESETS[arguments.preset].items()})
        jobs = [Job(room_set, folder, room, seed, variant, preset, arguments.set + settings)
                for variant, (preset, settings) in variants.items() for folder, room in sequences
                for seed in arguments.seeds or room_set.seeds]
        if room_set.own_poses:
            jobs += [dataclasses.replace(job, poses="vio",
                                         variant="own poses" + ("" if job.variant == "as it is" else ", " + job.variant))
                     for job in jobs]
        return jobs

    def noisy(self, sequence, room, seed):
        """The sequence with errors of its poses, independent from frame to frame, told or not; its images are links."""
        metres, degrees, told = self.arguments.pose_noise
        folder = self.out / "noisy" / f"{room.replace(' ', '-')}-{metres:g}-{degrees:g}-{'told' if told else 'untold'}-{seed}"
        folder.mkdir(parents=True, exist_ok=True)
        for entry in sequence.iterdir():
            if entry.name.startswith("trajectory") or (folder / entry.name).exists():
                continue
            (folder / entry.name).symlink_to(entry.resolve())
        random_numbers = random.Random(seed)
        poses, covariances = [], ["# independent errors: t[s], then the 6x6 covariance; x y z [m] rx ry rz [rad]"]
        diagonal = [metres**2] * 3 + [math.radians(degrees) ** 2] * 3
        for line in (sequence / "trajectory.txt").read_text().splitlines():
            fields = line.split()
            if line.startswith("#") or len(fields) != 8:
                poses.append(line)
                if "world_from_body" in line:
                    covariances[0] += ", world_from_body"
                continue
            place = [float(number) + random_numbers.gauss(0, metres) for number in fields[1:4]]
            turn = [random_numbers.gauss(0, math.radians(degrees)) for _ in range(3)]
            poses.append(" ".join([fields[0], *map(repr, place), *map(repr, turned(turn, list(map(float, fields[4:]))))]))
            rows = [[diagonal[r] if r == c else 0.0 for c in range(6)] for r in range(6)]
            covariances.append(",".join([fields[0], *(repr(value) for row in rows for value in row)]))
        (folder / "trajectory.txt").write_text("\n".join(poses) + "\n")
        if told:
            (folder / "trajectory.covariance.csv").write_text("\n".join(covariances) + "\n")
        return folder

    def backwards(self, sequence):
        """The sequence with its last image first, at the first one's time; images are links. Without an IMU."""
        for name in ("color", "trajectory.txt", "ground_truth.json"):
            if not (sequence / name).exists():
                raise Failure(f"{sequence} has no {name}, which --backwards needs")
        folder = self.out / "backwards" / sequence.name
        folder.mkdir(parents=True, exist_ok=True)
        stems = sorted(image.stem for image in (sequence / "color").iterdir() if image.stem.isdigit())
        stem_then = dict(zip(stems, reversed(stems)))

        def link(name, target):
            if not (folder / name).exists():
                (folder / name).symlink_to(target.resolve())

        for entry in sequence.iterdir():
            if entry.name in ("color", "edges", "proposals"):
                (folder / entry.name).mkdir(exist_ok=True)
                for file in entry.iterdir():
                    name = f"{entry.name}/{stem_then.get(file.stem, file.stem)}{file.suffix}"
                    if file.suffix != ".json":
                        link(name, file)
                        continue
                    views = json.loads(file.read_text())
                    for view in views:
                        image = pathlib.Path(view["image"])
                        view["image"] = stem_then[image.stem] + image.suffix
                    (folder / name).write_text(json.dumps(views))
            elif entry.name in ("camera.json", "gravity.json", "models", "scene.ply"):
                link(entry.name, entry)
        lines = (sequence / "trajectory.txt").read_text().splitlines()
        poses = [line.split() for line in lines if line.strip() and not line.startswith("#")]
        if len(poses) != len(stems):
            raise Failure(f"{sequence} has {len(stems)} images and {len(poses)} poses; --backwards needs one for each")
        (folder / "trajectory.txt").write_text("\n".join(
            [line for line in lines if line.startswith("#")] +
            [" ".join([there[0], *then[1:]]) for there, then in zip(poses, reversed(poses))]) + "\n")
        truth = json.loads((sequence / "ground_truth.json").read_text())
        ends = int(stems[0]) + int(stems[-1])
        for instance in truth["instances"]:
            instance["visible_frames"] = [[ends - last, ends - first]
                                          for first, last in reversed(instance.get("visible_frames", []))]
        (folder / "ground_truth.json").write_text(json.dumps(truth))
        if (sequence / "visibility.csv").exists():
            header, *rows = (sequence / "visibility.csv").read_text().splitlines()
            rows = [row.split(",", 1) for row in rows]
            (folder / "visibility.csv").write_text("\n".join(
                [header] + [f"{ends - int(frame)},{rest}" for frame, rest in rows]) + "\n")
        return folder

    def input_of(self, choice):
        """A network in the data folder, or the choice itself."""
        if not choice.endswith(".onnx"):
            return choice
        path = pathlib.Path(choice) if pathlib.Path(choice).exists() else self.data / choice
        if not path.exists():
            raise Failure(f"{choice} is not in the data folder (PLUMBLINE_DATA)")
        return path

    def options_of(self, job):
        words = ["--seed", job.seed, "--detector", self.input_of(self.arguments.detector or job.set.detector),
                 "--edges", self.input_of(self.arguments.edges or job.set.edges)]
        if self.arguments.frames:
            words += ["--frames", self.arguments.frames]
        if job.preset != "default":
            words += ["--preset", job.preset]
        for setting in job.settings:
            words += ["--set", setting]
        if job.poses:
            words += ["--poses", job.poses]
        if self.arguments.smooth:
            words.append("--smooth")
        return words

    def run(self, job):
        """The record of a run, from its file if it is done. A failure is a record too."""
        words = self.options_of(job)
        key = json.dumps([job.set.name, job.room, self.program_hash, *map(str, words), *(self.arguments.pose_noise or [])])
        stem = f"{job.set.name}-{job.room.replace(' ', '')}-s{job.seed}-{hashlib.sha256(key.encode()).hexdigest()[:8]}"
        file = self.out / "runs" / (stem + ".json")
        if file.exists():
            record = json.loads(file.read_text())
            if "failed" not in record:
                return record
        record = {"set": job.set.name, "room": job.room, "seed": job.seed, "variant": job.variant,
                  "preset": job.preset, "settings": job.settings, "program": self.program_hash, "commit": commit(),
                  "at_once": self.arguments.jobs}
        run_file = self.out / "runs" / (stem + ".plb")
        work = self.out / "runs" / (stem + ".work")
        work.mkdir(exist_ok=True)
        summary_file, judged_file = work / "run.json", work / "evaluation.json"
        sequence = self.noisy(job.sequence, job.room, job.seed) if self.arguments.pose_noise else job.sequence
        process = self.call("run", sequence, "--out", run_file, "--json", summary_file, *words)
        if process.returncode == 0:
            judge = ["evaluate", run_file, "--ground-truth", job.sequence / "ground_truth.json", "--models",
                     job.sequence / "models", "--json", judged_file, "--samples", 100_000, "--single-frames", 0]
            if job.set.scan and (job.sequence / "scene.ply").exists():
                judge += ["--scene", job.sequence / "scene.ply"]
            for category in job.set.ignored:
                judge += ["--ignore-category", category]
            process = self.call(*judge)
        if process.returncode == 0:
            process = self.call("export", run_file, "--format", "csv", "--models", job.sequence / "models", "--out",
                                work)
        if process.returncode != 0:
            record["failed"] = last_line(process)
        else:
            fill(record, job, self.arguments.frames, json.loads(summary_file.read_text()),
                 json.loads(judged_file.read_text()), withdrawn_objects(work))
        shutil.rmtree(work)
        if not self.arguments.keep:
            run_file.unlink(missing_ok=True)
        file.write_text(json.dumps(record, indent=1))
        return record


def withdrawn_objects(folder):
    """Objects that had been confirmed and were given up; merged ones live on in another."""
    with open(folder / "events.csv", newline="") as file:
        events = list(csv.DictReader(file))
    confirmed = {event["id"] for event in events if event["event"] == "confirmed"}
    return sorted(event["id"] for event in events if event["event"] == "retired" and event["id"] in confirmed)


def fill(record, job, frames, summary, judged, withdrawn):
    """Puts into the record what a run found, instance by instance; what its second pass found beside it."""
    shown = shown_frames(job.sequence, frames)
    rate_hz = json.loads((job.sequence / "camera.json").read_text())["rate_hz"]

    def instances_of(result, evaluation):
        confirmed = {str(entry["id"]): entry["confirmed_frame"] for entry in result["objects"]}
        believed = {str(entry["id"]): entry for entry in evaluation["belief"]["objects"]}
        instances = []
        for found in evaluation["objects"]:
            instances.append({
                "id": found["ground_truth"], "found": True, "quality": found["quality"], "object": found["id"],
                "model": found["model"], "model_right": found["model_correct"],
                "position_m": found["translation_m"], "rotation_deg": found["rotation_deg"],
                "turned_round": abs(found["azimuth_deg"] or 0) > 90, "confirmed_frame": confirmed.get(found["id"]),
                "credible_level": believed[found["id"]].get("credible_level")})
        for missed in evaluation["missed_instances"]:
            instances.append({"id": missed["ground_truth"], "found": False, "quality": missed["quality"],
                              "cause": missed.get("why", {}).get("cause", "unknown"),
                              "why": missed.get("why", {}).get("text", "")})
        for instance in instances:
            instance["shown_frames"] = shown.get(instance["id"], 0)
            instance["shows_well"] = instance["shown_frames"] >= SHOWS_WELL_S * rate_hz
        return sorted(instances, key=lambda instance: -instance["shown_frames"])

    record.update(fps=summary["fps"], frames=summary["frames"], skipped=summary["skipped"],
                  stages_ms={stage: cost["mean"] for stage, cost in summary["timings_ms"].items()},
                  instances=instances_of(summary, judged), spurious=judged["spurious_objects"],
                  trajectory=judged.get("trajectory"), withdrawn=withdrawn, surface_mean_m=judged["surface"]["mean_m"], surfaces=judged["surfaces"],
                  belief=judged["belief"])
    if "smoothed" in judged:
        smoothed = judged["smoothed"]
        record["smoothed"] = {
            **{key: record[key] for key in ("set", "room", "seed", "variant", "fps")},
            "instances": instances_of(summary["smoothed"], smoothed), "spurious": smoothed["spurious_objects"],
            "withdrawn": [], "surface_mean_m": smoothed["surface"]["mean_m"], "surfaces": smoothed["surfaces"],
            "belief": smoothed["belief"]}


def shown_frames(sequence, frames):
    """In how many of the frames A:B[:S] each instance shows: 2000 pixels of a synthetic one, else as the truth says."""
    files = sorted(int(image.stem) for image in (sequence / "color").iterdir() if image.stem.isdigit())
    chosen = set(files[slice(*(int(bound) for bound in frames.split(":")))] if frames else files)
    shown = {}
    visibility = sequence / "visibility.csv"
    if visibility.exists():
        for line in visibility.read_text().splitlines()[1:]:
            frame, instance, pixels = line.split(",")
            shown[instance] = shown.get(instance, 0) + (int(frame) in chosen and int(pixels) >= 2000)
        return shown
    for instance in json.loads((sequence / "ground_truth.json").read_text())["instances"]:
        shown[instance["id"]] = sum(frame in chosen for first, last in instance.get("visible_frames", [])
                                    for frame in range(first, last + 1))
    return shown


def commit():
    def git(*words):
        process = subprocess.run(["git", "-C", ROOT, *words], capture_output=True, text=True, check=False)
        return process.stdout.strip()
    return git("rev-parse", "--short", "HEAD") + (" with changes" if git("status", "--porcelain", "-uno") else "")


# Student's t at 97.5 %, by degrees of freedom.
T975 = [math.inf, 12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145,
        2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045]


def student(degrees):
    return T975[degrees] if degrees < len(T975) else 1.96 + 2.5 / degrees


def mean_and_half(values):
    """Mean and half of its 95 % confidence interval (None with fewer than two values)."""
    if not values:
        return None, None
    if len(values) == 1:
        return values[0], None
    return statistics.fmean(values), student(len(values) - 1) * statistics.stdev(values) / math.sqrt(len(values))


def interval(values, format_="{:.2f}", sign=""):
    mean, half = mean_and_half([value for value in values if value is not None])
    if mean is None:
        return "-"
    return format_.replace(":", ":" + sign).format(mean) + ("" if half is None else " ± " + format_.format(half))


def figures(record):
    """One run as numbers; None where there is nothing to average."""
    instances = record["instances"]
    well = [i for i in instances if i["shows_well"]]
    found = [i for i in instances if i["found"]]
    levels = [i["credible_level"] for i in found if i["credible_level"] is not None]
    return {
        "well": len(well), "found_well": sum(i["found"] for i in well),
        "right_well": sum(i["found"] and i["model_right"] for i in well),
        "all": len(instances), "found": len(found), "right": sum(i["model_right"] for i in found),
        "spurious": len(record["spurious"]), "turned": sum(i["turned_round"] for i in found),
        "withdrawn": len(record["withdrawn"]),
        "position_cm": statistics.fmean(100 * i["position_m"] for i in found) if found else None,
        "rotation_deg": statistics.fmean(i["rotation_deg"] for i in found) if found else None,
        "judged": len(levels), "in_50": sum(level <= 0.5 for level in levels),
        "in_95": sum(level <= 0.95 for level in levels), "fps": record["fps"],
    }


def pooled(units):
    """Share of trials that succeed [%] and half of its 95 % interval, from (successes, trials) of independent units."""
    units = [unit for unit in units if unit[1]]
    trials = sum(n for _, n in units)
    if not trials:
        return "-"
    share = sum(x for x, _ in units) / trials
    if len(units) == 1:
        return f"{100 * share:.0f}"
    spread = sum((x - share * n) ** 2 for x, n in units) * len(units) / (len(units) - 1)
    return f"{100 * share:.0f} ± {100 * student(len(units) - 1) * math.sqrt(spread) / trials:.0f}"


def units_of(records):
    """Independent trials: the records of a room where there are several rooms, else those of a seed."""
    several = len({record["room"] for record in records}) > 1
    units = {}
    for record in records:
        units.setdefault(record["room"] if several else record["seed"], []).append(record)
    return units


def by_unit(records, key):
    """Means over the records of each unit; None where there is nothing to average."""
    means = {}
    for unit, members in units_of(records).items():
        values = [value for value in (figures(record)[key] for record in members) if value is not None]
        means[unit] = statistics.fmean(values) if values else None
    return means


def counts_by_unit(records, part, of):
    return [(sum(figures(r)[part] for r in members), sum(figures(r)[of] for r in members))
            for members in units_of(records).values()]


def number(value, format_="{:.2f}"):
    return "-" if value is None else format_.format(value)


def row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def header(*cells):
    return [row(*cells), "|" + "---|" * len(cells)]


def run_table(records):
    lines = header("room", "seed", "found of those that show well", "right model", "found of all", "spurious",
                   "turned round", "withdrawn", "position [cm]", "rotation [deg]", "truth in 50 %", "in 95 %",
                   "frames/s")
    for record in records:
        f = figures(record)
        lines.append(row(record["room"], record["seed"], f"{f['found_well']} of {f['well']}", f["right_well"],
                         f"{f['found']} of {f['all']}", f["spurious"], f["turned"], f["withdrawn"],
                         number(f["position_cm"]), number(f["rotation_deg"]), f"{f['in_50']} of {f['judged']}",
                         f"{f['in_95']} of {f['judged']}", number(f["fps"], "{:.1f}")))

    def over(key, format_="{:.2f}"):
        return interval(by_unit(records, key).values(), format_)

    def mean_of(key):
        return number(statistics.fmean(by_unit(records, key).values()), "{:.1f}")
    lines.append(row("**mean**", "", f"{over('found_well')} of {mean_of('well')}", over("right_well"),
                     f"{over('found')} of {mean_of('all')}", over("spurious"), over("turned"), over("withdrawn"),
                     over("position_cm"), over("rotation_deg"),
                     pooled(counts_by_unit(records, "in_50", "judged")) + " %",
                     pooled(counts_by_unit(records, "in_95", "judged")) + " %", over("fps", "{:.1f}")))
    return lines


def instance_table(records):
    lines = header("room", "instance", "shows in frames", "found", "missed", "right model", "turned round",
                   "position [cm]", "rotation [deg]", "truth in 50 %", "in 95 %", "confirmed at frame")
    of_instance = {}
    for record in records:
        for instance in record["instances"]:
            of_instance.setdefault((record["room"], instance["id"]), []).append(instance)
    for (room, name), trials in of_instance.items():
        found = [trial for trial in trials if trial["found"]]
        confirmed = sorted(trial["confirmed_frame"] for trial in found if trial["confirmed_frame"] is not None)
        levels = [trial["credible_level"] for trial in found if trial["credible_level"] is not None]
        lines.append(row(
            room, name + ("" if trials[0]["quality"] == "fine" else " (coarse)"), trials[0]["shown_frames"],
            f"{len(found)} of {len(trials)}", len(trials) - len(found) or "", sum(t["model_right"] for t in found),
            sum(t["turned_round"] for t in found) or "", interval([100 * t["position_m"] for t in found], "{:.1f}"),
            interval([t["rotation_deg"] for t in found], "{:.1f}"),
            f"{sum(level <= 0.5 for level in levels)} of {len(levels)}",
            f"{sum(level <= 0.95 for level in levels)} of {len(levels)}",
            f"{confirmed[0]} to {confirmed[-1]}" if confirmed else "-"))
    return lines


def trajectory_lines(records):
    """How far estimated poses are from those that came with the sequences."""
    own = [record for record in records if record.get("trajectory")]
    if not own:
        return []
    lines = header("room", "seed", "frames with a pose", "ATE [cm]", "ATE [deg]", "tilt [deg]", "scale", "path [m]")
    for record in own:
        t = record["trajectory"]
        lines.append(row(record["room"], record["seed"], f"{t['matched']} of {record['frames'] + record['skipped']}",
                         number(100 * t["ate_m"]), number(t["ate_deg"]), number(t["tilt_deg"]), number(t["scale"], "{:.4f}"),
                         number(t["path_m"], "{:.1f}")))
    return ["**Trajectories**, of the camera:", "", *lines, ""]


def missed_lines(records):
    """What kept those out that show well (docs/algorithms/why_missed.md): how often each cause, then each of them."""
    missed = [(record, instance) for record in records for instance in record["instances"]
              if not instance["found"] and instance["shows_well"]]
    if not missed:
        return []
    causes = collections.Counter(instance["cause"].replace("_", " ") for _, instance in missed)
    return ["**Missed** of those that show well: "
            + ", ".join(f"{cause} {count}" for cause, count in causes.most_common()) + ".", "",
            *(f"- {record['room']}, seed {record['seed']}, {instance['id']}: {instance['why']}"
              for record, instance in missed), ""]


def label_bins(records):
    """Of every confirmed object whose category has several models: ten bins of equal width, and the expected
    calibration error (docs/algorithms/evaluation.md)."""
    bins = {}
    for record in records:
        for entry in record["belief"]["objects"]:
            if entry["confirmed"] and "label" in entry and entry["label"]["several_models"]:
                claimed, right = entry["label"]["probability"], entry["label"]["right"]
                bins.setdefault(min(9, int(10 * claimed)), []).append((claimed, right))
    table = [{"from": i / 10, "to": (i + 1) / 10, "count": len(members),
              "claimed": statistics.fmean(p for p, _ in members), "right": statistics.fmean(r for _, r in members)}
             for i, members in sorted(bins.items())]
    count = sum(b["count"] for b in table)
    return table, sum(b["count"] * abs(b["claimed"] - b["right"]) for b in table) / count if count else None


def precision_recall(records):
    """(threshold, precision, recall) over the objects of all runs, tentative or confirmed, and the area."""
    candidates = sorted(((entry["probability"], (i, entry["ground_truth"])) for i, record in enumerate(records)
                         for entry in record["belief"]["objects"]), key=lambda candidate: -candidate[0])
    truths = sum(record["belief"]["confirmation"]["truths"] for record in records)
    points, found, area = [], set(), 0.0
    for i, (probability, truth) in enumerate(candidates):
        if truth[1] is not None:
            found.add(truth)
        if i + 1 < len(candidates) and candidates[i + 1][0] == probability:
            continue
        point = (probability, len(found) / (i + 1), len(found) / truths if truths else 0.0)
        area += point[1] * (point[2] - (points[-1][2] if points else 0.0))
        points.append(point)
    return points, area


def belief(records):
    """The beliefs of all runs together."""
    nees = [entry["nees"] * 4 / entry["degrees_of_freedom"] for record in records
            for entry in record["belief"]["objects"] if entry["confirmed"] and "nees" in entry]
    bins, error = label_bins(records)
    points, area = precision_recall(records)
    return {"nees": nees, "label_bins": bins, "expected_calibration_error": error, "precision_recall": points,
            "average_precision": area}


def belief_lines(records):
    of = belief(records)
    along = {}
    for region in ("50", "95"):
        units = []
        for members in units_of(records).values():
            parts = [record["belief"]["along_the_run"] for record in members]
            units.append((sum(p["poses"] * (p[f"truth_in_{region}_percent"] or 0) for p in parts),
                          sum(p["poses"] for p in parts)))
        along[region] = pooled(units)
    end = {region: pooled(counts_by_unit(records, "in_" + region, "judged")) for region in ("50", "95")}
    words = [f"Truth in the 50 % region: {end['50']} % at the end, {along['50']} % along the runs; "
             f"in the 95 % region: {end['95']} % and {along['95']} %."]
    if of["nees"]:
        words.append(f"NEES of {len(of['nees'])} objects: mean {statistics.fmean(of['nees']):.1f} (4 is honest), "
                     f"median {statistics.median(of['nees']):.1f} (2.0 is).")
    words.append(f"Being there: average precision {of['average_precision']:.2f}.")
    if of["label_bins"]:
        words.append(f"Labels: expected calibration error {of['expected_calibration_error']:.3f}: " + "; ".join(
            f"believed at {100 * b['claimed']:.0f} %, right in {100 * b['right']:.0f} % of {b['count']}"
            for b in of["label_bins"]) + ".")
    else:
        words.append("Labels: no category has several models.")
    return ["**Beliefs.** " + " ".join(words), ""]


def differences(records, reference, key):
    """By unit: how much more than in the reference, over instances that both found in the same room and seed."""
    before = {(r["room"], r["seed"]): {i["id"]: i for i in r["instances"] if i["found"]} for r in reference}
    means = []
    for members in units_of(records).values():
        values = [i[key] - before[r["room"], r["seed"]][i["id"]][key] for r in members for i in r["instances"]
                  if i["found"] and i["id"] in before.get((r["room"], r["seed"]), {})]
        if values:
            means.append(statistics.fmean(values))
    return means


def ablation_table(variants):
    """Every variant against the first, paired: the same rooms and seeds, and for errors the same instances."""
    lines = header("", "found of those that show well", "difference", "spurious", "difference", "position [cm]",
                   "difference", "rotation [deg]", "difference", "truth in 50 % [%]", "in 95 % [%]")
    first = next(iter(variants.values()))
    for name, records in variants.items():
        def cells(key, pairs):
            return [interval(by_unit(records, key).values()), "" if records is first else interval(pairs, sign="+")]

        def counted(key):
            reference = by_unit(first, key)
            return cells(key, [value - reference[unit] for unit, value in by_unit(records, key).items()
                               if unit in reference])
        lines.append(row(name, *counted("found_well"), *counted("spurious"),
                         *cells("position_cm", [100 * d for d in differences(records, first, "position_m")]),
                         *cells("rotation_deg", differences(records, first, "rotation_deg")),
                         pooled(counts_by_unit(records, "in_50", "judged")),
                         pooled(counts_by_unit(records, "in_95", "judged"))))
    return lines


def smoothed_tables(records):
    """What the second pass made of the same runs, beside what they found frame by frame; nothing without one."""
    records = [record for record in records if "smoothed" in record]
    smoothed = [record["smoothed"] for record in records]
    if not smoothed:
        return []
    spurious = [f"{s['model']} ({r['room']}, seed {r['seed']})" for r in smoothed for s in r["spurious"]]
    return (["**Smoothed**, beside the causal results above:", ""] +
            ablation_table({"causal": records, "smoothed": smoothed}) + [""] + run_table(smoothed) + [""] +
            instance_table(smoothed) + ["", "**Spurious**: " + (", ".join(spurious) or "none") + ".", ""] +
            belief_lines(smoothed))


def by_variant(records):
    """The runs that did not fail."""
    variants = {}
    for record in records:
        if "failed" not in record:
            variants.setdefault(record["variant"], []).append(record)
    return variants


def tables(measurement, results):
    arguments = measurement.arguments
    lines = ["# Measured", "",
             f"Commit {commit()}, program {measurement.program_hash}, {datetime.date.today().isoformat()}; "
             f"{arguments.jobs} run(s) at once on {os.cpu_count()} cores.",
             "Command: `scripts/measure.sh " + " ".join(sys.argv[1:]) + "`.",
             f"Synthetic rooms for tuning: seeds {TUNING_SEEDS[0]} to {TUNING_SEEDS[-1]}; held out: "
             f"{HELD_OUT_SEEDS[0]} to {HELD_OUT_SEEDS[-1]}; of claims and scenes, held out too: {SCENE_SEEDS[0]} to "
             f"{SCENE_SEEDS[-1]}, of sensors {SENSOR_SEEDS[0]} to {SENSOR_SEEDS[-1]}.",
             "± is half of the 95 % confidence interval (Student's t), over rooms where there are several and over "
             "seeds otherwise. Means are over all found instances, turned round or not. *Withdrawn*: confirmed "
             "once and given up. *Shows well*: "
             f"for {SHOWS_WELL_S:g} s or more (in synthetic rooms with 2000 pixels). *Truth in 50 %*: at the end, in "
             "the highest-density region of the belief; definitions in docs/algorithms/evaluation.md.", ""]
    for room_set, outcome in results:
        lines += [f"## {room_set.name}", "", f"{room_set.what}; detector `{arguments.detector or room_set.detector}`, "
                  f"edges `{arguments.edges or room_set.edges}`" +
                  (f", frames {arguments.frames}" if arguments.frames else "") +
                  "".join(f", `--set {setting}`" for setting in arguments.set) +
                  (f"; ignored: {', '.join(room_set.ignored)}" if room_set.ignored else "") +
                  ".", ""]
        if isinstance(outcome, str):
            lines += [f"**Skipped**: {outcome}.", ""]
            continue
        lines += [f"**Failed**: {record['variant']}, {record['room']}, seed {record['seed']}: {record['failed']}\n"
                  for record in outcome if "failed" in record]
        variants = by_variant(outcome)
        if len(variants) > 1:
            lines += ablation_table(variants) + [""]
        for variant, records in variants.items():
            if len(variants) > 1:
                lines += [f"### {variant}", ""]
            lines += run_table(records) + [""] + trajectory_lines(records) + instance_table(records) + [""]
            spurious = [f"{s['model']} ({r['room']}, seed {r['seed']})" for r in records for s in r["spurious"]]
            lines += ["**Spurious**: " + (", ".join(spurious) or "none") + ".", ""] + belief_lines(records)
            lines += missed_lines(records)
            lines += smoothed_tables(records)
    return "\n".join(lines)


def parse():
    names = [room_set.name for room_set in all_sets()]
    parser = argparse.ArgumentParser(prog="measure.sh", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="SET,..",
                        help="sets to measure (default: all but tuning, rooms-flawless, rooms-imu, own-poses and sensors; 'claims', "
                        "'scenes' and 'sensors' mean all of these): "
                        + ", ".join(names))
    parser.add_argument("--seeds", type=integers, metavar="A:B", help="seeds of the mapper, B not included")
    parser.add_argument("--rooms", type=integers, metavar="A:B", help="seeds of the synthetic rooms")
    parser.add_argument("--frames", metavar="A:B", help="of every sequence (default: all)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="an option of the filter")
    parser.add_argument("--detector", metavar="NETWORK|dataset", help="instead of the set's own")
    parser.add_argument("--edges", metavar="NETWORK|builtin|gradient|dataset", help="instead of the set's own")
    parser.add_argument("--ablate", nargs="?", const="", metavar="CUE,..",
                        help="repeat with one cue off at a time: " + ", ".join(list(ABLATIONS)[1:]))
    parser.add_argument("--preset", choices=list(PRESETS),
                        help="repeat with another filter, to compare with: as the authors of the paper had it")
    parser.add_argument("--smooth", action="store_true",
                        help="smooth every run too, and give what that finds beside it")
    parser.add_argument("--pose-noise", type=pose_noise, metavar="METRES,DEGREES[,untold]",
                        help="give every pose an error of its own, of that standard deviation on each axis, and tell the "
                        "mapper unless 'untold'")
    parser.add_argument("--backwards", action="store_true",
                        help="the last image first: the same pictures, found in another order and from other places")
    parser.add_argument("--out", default=str(ROOT / "build/measure"), metavar="DIR")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at once (default 2)")
    parser.add_argument("--keep", action="store_true", help="keep the run files (.plb), to look at in the window")
    arguments = parser.parse_args()
    chosen = []
    for name in filter(None, arguments.only.split(",")):
        wanted = [n for n in names
                  if n == name or (name in ("claims", "scenes", "sensors") and n.startswith(name[:-1] + "-"))]
        if not wanted:
            parser.error(f"there is no set '{name}'; there are {', '.join(names)}")
        chosen += wanted
    for name in filter(None, (arguments.ablate or "").split(",")):
        if name.strip() not in ABLATIONS:
            parser.error(f"there is no cue '{name}'; there are {', '.join(list(ABLATIONS)[1:])}")
    sets = [s for s in all_sets() if (s.name in chosen if chosen else not s.asked_for)]
    return arguments, sets


def main():
    arguments, sets = parse()
    measurement = Measurement(arguments)
    results = []
    for room_set in sets:
        try:
            jobs = measurement.jobs_of(room_set)
            records = []
            with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
                for record in pool.map(measurement.run, jobs):
                    records.append(record)
                    said = record.get("failed") or (
                        "{found_well} of {well} found, {spurious} spurious, {turned} turned".format(**figures(record)))
                    print(f"{room_set.name}: {record['room']}, seed {record['seed']}, {record['variant']}: {said}",
                          flush=True)
            results.append((room_set, records))
        except Failure as failure:
            print(f"{room_set.name}: skipped: {failure}", flush=True)
            results.append((room_set, str(failure)))
        (measurement.out / "tables.md").write_text(tables(measurement, results))
        (measurement.out / "results.json").write_text(json.dumps(
            {"commit": commit(), "program": measurement.program_hash, "arguments": vars(arguments),
             "sets": {s.name: {"skipped": outcome} if isinstance(outcome, str) else {
                 "beliefs": {variant: belief(records) for variant, records in by_variant(outcome).items()},
                 "runs": outcome} for s, outcome in results}}, indent=1))
    print(f"wrote {measurement.out / 'tables.md'}")
    return any(isinstance(outcome, list) and any("failed" in record for record in outcome) for _, outcome in results)


if __name__ == "__main__":
    sys.exit(main())
