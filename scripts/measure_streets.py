# SPDX-License-Identifier: Apache-2.0
"""Measures the mapper on synthetic streets: every figure of docs/algorithms/outdoors.md.

Films `plumbline synth --scene street` (or pavement), maps each street with the very shapes that park there and with generic ones
alone, judges both, and writes into one folder
  tables.md     a row for each street, and their means
  results.json  the same, car by car
  runs/         what each run found; a second call skips what is there

A parked car counts if it shows so much within so many metres for so long as the constants below say; moving ones must not be mapped.
"""
import argparse
import hashlib
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

WITHIN_M = 30.0  # cars that show from no farther
SHOWS_PX = 600  # pixels of a car in an image of 1242x375: what shows of one that is hidden for its greater part
SHOWS_S = 0.5
MATCH_M = 1.0  # half the width of a car: farther, an object is not it

SHAPES = {
    # The database, the truth that names its models, settings of the run.
    "right": ("right/models", "right/ground_truth.json", []),
    # Cars of a class differ by some per cent in size.
    "generic": ("models", "ground_truth.json", ["scale_std=0.04"]),
}


def integers(text):
    """'3', '0:5' (5 not included), '1,4,7'."""
    values = []
    for part in text.split(","):
        first, colon, last = part.partition(":")
        values += range(int(first), int(last)) if colon else [int(first)]
    return values


def last_line(process):
    lines = [line for line in (process.stderr + "\n" + process.stdout).splitlines() if line.strip()]
    return lines[-1] if lines else f"ended with {process.returncode} without a word"


def call(program, *words):
    process = subprocess.run([str(program), *map(str, words)], capture_output=True, text=True, check=False)
    if process.returncode != 0:
        sys.exit(f"measure: {' '.join(map(str, words[:2]))}: {last_line(process)}")


def film(arguments, seed):
    """The folder of a street; filmed once, whatever the program (delete the cache to film it anew)."""
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME", pathlib.Path.home() / ".cache")) / "plumbline" / "measure"
    folder = cache / "-".join([arguments.scene, str(seed)] + (["frames", str(arguments.frames)] if arguments.frames else []))
    done = cache / (folder.name + ".complete")
    if not done.exists():
        print(f"filming {folder.name}", flush=True)
        cache.mkdir(parents=True, exist_ok=True)
        words = ["--frames", arguments.frames] if arguments.frames else []
        call(arguments.program, "synth", "--out", folder, "--scene", arguments.scene, "--seed", seed, *words)
        done.write_text("complete\n")
    return folder


def cars_that_count(folder):
    """Parked cars that show well within reach, with the least distance at which each shows."""
    truth = json.loads((folder / "ground_truth.json").read_text())
    camera = json.loads((folder / "camera.json").read_text())
    path = [list(map(float, line.split()[1:4])) for line in (folder / "trajectory.txt").read_text().splitlines()
            if line.strip() and not line.startswith("#")]
    places = {car["id"]: [row[3] for row in car["world_from_object"][:3]] for car in truth["instances"]}
    least_px = SHOWS_PX * camera["width"] * camera["height"] / (1242 * 375)
    frames, nearest = {}, {}
    for line in (folder / "visibility.csv").read_text().splitlines()[1:]:
        frame, car, pixels = line.split(",")
        if car not in places or int(pixels) < least_px:
            continue
        distance = math.dist(path[int(frame)], places[car])
        nearest[car] = min(nearest.get(car, math.inf), distance)
        frames[car] = frames.get(car, 0) + (distance <= WITHIN_M)
    return {car: nearest[car] for car, count in frames.items() if count >= SHOWS_S * camera["rate_hz"]}, truth


def measure(arguments, seed, shapes):
    """What a run found, from its file if it is done."""
    models, truth_file, settings = SHAPES[shapes]
    folder = film(arguments, seed)
    settings = settings + arguments.set
    key = hashlib.sha256(json.dumps([arguments.program_hash, str(folder), shapes, arguments.edges, settings]).encode()).hexdigest()[:8]
    stem = arguments.out / "runs" / f"{folder.name}-{shapes}-{key}"
    judged_file, run_file = stem.with_suffix(".json"), stem.with_suffix(".plb")
    if not judged_file.exists():
        words = [word for setting in settings for word in ("--set", setting)]
        call(arguments.program, "run", folder, "--out", run_file, "--models", folder / models, "--edges", arguments.edges,
             "--detector", "dataset", *words)
        call(arguments.program, "evaluate", run_file, "--ground-truth", folder / truth_file, "--models", folder / models,
             "--match-distance", MATCH_M, "--samples", 20000, "--single-frames", 0, "--json", judged_file)
        if not arguments.keep:
            run_file.unlink(missing_ok=True)
    judged = json.loads(judged_file.read_text())
    near, truth = cars_that_count(folder)
    overlaps = {pair["ground_truth"]: pair for pair in judged["kitti"]["pairs"]}
    cars = []
    for found in judged["objects"]:
        if found["ground_truth"] not in near:
            continue
        pair = overlaps.get(found["ground_truth"], {})
        cars.append({"id": found["ground_truth"], "nearest_m": near[found["ground_truth"]], "found": True,
                     "model_right": found["model_correct"], "position_m": found["translation_m"],
                     "azimuth_deg": abs(found["azimuth_deg"]), "iou_3d": pair.get("iou_3d"),
                     "iou_birds_eye": pair.get("iou_birds_eye"), "orientation": pair.get("orientation_similarity")})
    known = {car["id"] for car in cars}
    cars += [{"id": car, "nearest_m": distance, "found": False} for car, distance in near.items() if car not in known]
    spurious = judged["spurious_objects"]
    return {"scene": arguments.scene, "seed": seed, "shapes": shapes, "settings": settings, "cars": cars,
            "moving": len(truth.get("moving", [])), "moving_mapped": [o["moving"] for o in spurious if "moving" in o],
            "spurious": sum("moving" not in o for o in spurious), "mapped": judged["matched"], "kitti": judged["kitti"]}


def figures(record):
    found = [car for car in record["cars"] if car["found"]]
    turned = [car for car in found if car["azimuth_deg"] > 90]
    upright = [car for car in found if car["azimuth_deg"] <= 90]

    def mean(values):
        values = [value for value in values if value is not None]
        return statistics.fmean(values) if values else None
    kitti = record["kitti"]
    return {"cars": len(record["cars"]), "found": len(found), "model_right": sum(car["model_right"] for car in found),
            "turned": len(turned), "moving_mapped": len(record["moving_mapped"]), "moving": record["moving"],
            "spurious": record["spurious"], "position_cm": mean(100 * car["position_m"] for car in found),
            "median_cm": statistics.median(100 * car["position_m"] for car in found) if found else None,
            "azimuth_deg": mean(car["azimuth_deg"] for car in upright),
            "iou_3d": mean(car["iou_3d"] for car in found), "iou_birds_eye": mean(car["iou_birds_eye"] for car in found),
            "ap_70": 100 * kitti["box_3d"]["iou_70"]["easy"]["ap_40"],
            "ap_50": 100 * kitti["box_3d"]["iou_50"]["easy"]["ap_40"],
            "bev_70": 100 * kitti["birds_eye"]["iou_70"]["easy"]["ap_40"],
            "aos_50": 100 * kitti["box_3d"]["iou_50"]["easy"]["aos_40"]}


COLUMNS = [("turned", "turned round", "{:.0f}"), ("moving_mapped", "moving, mapped", "{:.0f}"), ("spurious", "spurious", "{:.0f}"),
           ("position_cm", "position [cm]", "{:.1f}"), ("median_cm", "its median", "{:.1f}"), ("azimuth_deg", "azimuth [deg]", "{:.1f}"),
           ("iou_3d", "IoU 3-D", "{:.2f}"), ("iou_birds_eye", "from above", "{:.2f}"), ("ap_70", "AP 3-D .7", "{:.0f}"),
           ("ap_50", "AP 3-D .5", "{:.0f}"), ("bev_70", "AP above .7", "{:.0f}"), ("aos_50", "AOS .5", "{:.0f}")]


def table(records):
    """A row for each street and one for all of them together."""
    def row(*cells):
        return "| " + " | ".join(map(str, cells)) + " |"

    def number(value, form):
        return "-" if value is None else form.format(value)
    lines = [row("seed", "found", "right model", *(title for _, title, _ in COLUMNS)), "|" + "---|" * (3 + len(COLUMNS))]
    all_figures = []
    for record in records:
        f = figures(record)
        all_figures.append(f)
        lines.append(row(record["seed"], f"{f['found']} of {f['cars']}", f["model_right"],
                         *(number(f[key], form) for key, _, form in COLUMNS)))
    means = []
    for key, _, form in COLUMNS:
        values = [f[key] for f in all_figures if f[key] is not None]
        whole = key in ("turned", "moving_mapped", "spurious")
        means.append("-" if not values else str(sum(values)) if whole else form.format(statistics.fmean(values)))
    lines.append(row("**all**", f"{sum(f['found'] for f in all_figures)} of {sum(f['cars'] for f in all_figures)}",
                     sum(f["model_right"] for f in all_figures), *means))
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", default=str(ROOT / "build/measure/streets"), help="folder of the results (default: %(default)s)")
    parser.add_argument("--scene", choices=["street", "pavement"], default="street")
    parser.add_argument("--seeds", type=integers, default=integers("301:311"), help="of the streets, as 301:311 (default) or 1,4")
    parser.add_argument("--shapes", choices=[*SHAPES, "both"], default="both", help="which shapes the mapper has")
    parser.add_argument("--frames", type=int, help="of each street; if not given, the scene's")
    parser.add_argument("--edges", default="dataset", help="gradient, dataset or builtin (default: %(default)s)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="an option of the filter")
    parser.add_argument("--keep", action="store_true", help="keep the run files")
    arguments = parser.parse_args()
    arguments.out = pathlib.Path(arguments.out).resolve()
    (arguments.out / "runs").mkdir(parents=True, exist_ok=True)
    arguments.program = pathlib.Path(os.environ.get("PLUMBLINE", ROOT / "build/bin/plumbline"))
    if not arguments.program.exists():
        sys.exit(f"measure: there is no {arguments.program}; run ./dev build first, or set PLUMBLINE")
    arguments.program_hash = hashlib.sha256(arguments.program.read_bytes()).hexdigest()[:12]
    records, lines = [], [f"# Streets: {arguments.scene}, program {arguments.program_hash}", ""]
    chosen = list(SHAPES) if arguments.shapes == "both" else [arguments.shapes]
    for seed in arguments.seeds:
        for shapes in chosen:
            records.append(measure(arguments, seed, shapes))
            f = figures(records[-1])
            print(f"{arguments.scene} {seed}, {shapes}: {f['found']} of {f['cars']} found, {f['moving_mapped']} moving, "
                  f"{f['spurious']} spurious", flush=True)
    for shapes in chosen:
        lines += [f"## Shapes: {shapes}", "", *table([record for record in records if record["shapes"] == shapes]), ""]
    (arguments.out / "tables.md").write_text("\n".join(lines))
    (arguments.out / "results.json").write_text(json.dumps(records, indent=1))
    print(arguments.out / "tables.md")


if __name__ == "__main__":
    main()
