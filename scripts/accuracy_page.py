#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes docs/accuracy.md from what scripts/measure.sh measured.

  scripts/accuracy_page.py --commit HASH RESULTS.json .. > docs/accuracy.md

Each results.json (the folder given to `measure.sh --out` has one) gives the rows and tables of its sets. No figure
on that page is written by hand; words about figures are in the pages that it names.
"""
import argparse
import collections
import copy
import json
import pathlib
import statistics
import sys

import measure

COARSE_CM = 3.0  # objects found, but further off than this, are named

# What a set is on that page, in the order of the page.
TITLES = {
    "office": "The office", "office-fastestdet": "The office, boxes of FastestDet", "kitchen": "The kitchen",
    "demo": "The demo room", "rooms-imu": "Synthetic rooms", "own-poses": "Synthetic rooms, own poses",
}
INSTANCES_LISTED = ("office", "office-fastestdet", "kitchen", "demo")


class Part:
    """The runs of one set that were measured alike."""

    def __init__(self, name, arguments, records, variant):
        self.name, self.records, self.variant = name, records, variant
        room_set = next(s for s in measure.all_sets() if s.name == name)
        self.detector = pathlib.PurePath(arguments["detector"] or room_set.detector).name
        self.edges = pathlib.PurePath(arguments["edges"] or room_set.edges).name
        self.settings = arguments["set"]
        words = ["scripts/measure.sh", "--only", name]
        for key in ("seeds", "rooms"):
            if arguments[key]:
                words += ["--" + key, span(arguments[key])]
        for key in ("detector", "edges"):
            if arguments[key]:
                words += ["--" + key, pathlib.PurePath(arguments[key]).name]
        for setting in self.settings:
            words += ["--set", setting]
        if arguments["ablate"] is not None:
            words += ["--ablate"]
        self.command = " ".join(words)

    def found(self):
        return [i for record in self.records for i in record["instances"] if i["found"]]

    def well(self):
        return [i for record in self.records for i in record["instances"] if i["shows_well"]]


def span(numbers):
    whole = list(range(numbers[0], numbers[-1] + 1))
    return f"{numbers[0]}:{numbers[-1] + 1}" if numbers == whole else ",".join(map(str, numbers))


def parts_of(file):
    results = json.loads(pathlib.Path(file).read_text())
    for name, outcome in results["sets"].items():
        for variant, records in measure.by_variant(outcome.get("runs", [])).items():
            yield Part(name, results["arguments"], records, variant)


def share(count, of):
    return f"{100 * count / of:.0f} %" if of else "-"


def mean_median(values, format_="{:.2f}"):
    if not values:
        return "-"
    return f"{format_.format(statistics.fmean(values))}, {format_.format(statistics.median(values))}"


def summary_header():
    return measure.header("measured on", "boxes, edges", "runs", "found of what shows well", "right shape", "false",
                          "turned round", "withdrawn", "position [cm]: mean, median", "rotation [deg]", "truth in 50 %",
                          "in 95 %", "NEES")


def summary_row(what, part):
    found, well = part.found(), part.well()
    levels = [i["credible_level"] for i in found if i["credible_level"] is not None]
    nees = measure.belief(part.records)["nees"]
    return measure.row(
        what, f"{part.detector.removesuffix('.onnx')}, {part.edges}", len(part.records),
        f"{sum(i['found'] for i in well)} of {len(well)} ({share(sum(i['found'] for i in well), len(well))})",
        f"{sum(i['model_right'] for i in found)} of {len(found)}",
        sum(len(record["spurious"]) for record in part.records), sum(i["turned_round"] for i in found),
        sum(len(record["withdrawn"]) for record in part.records),
        mean_median([100 * i["position_m"] for i in found]), mean_median([i["rotation_deg"] for i in found]),
        share(sum(level <= 0.5 for level in levels), len(levels)),
        share(sum(level <= 0.95 for level in levels), len(levels)),
        mean_median(nees, "{:.1f}"))


def category(name):
    return name.rsplit("_", 1)[0].replace("_", " ")


def category_table(part):
    lines = measure.header("category", "found of what shows well", "position [cm]: mean, median", "worst",
                           "rotation [deg]: mean, median", "worst", "truth in 50 %", "in 95 %")
    groups = collections.defaultdict(list)
    for record in part.records:
        for instance in record["instances"]:
            groups[category(instance["id"])].append(instance)
    for name, members in sorted(groups.items(), key=lambda group: -len(group[1])):
        well = [i for i in members if i["shows_well"]]
        found = [i for i in members if i["found"]]
        if not found and not well:
            continue
        positions, rotations = [100 * i["position_m"] for i in found], [i["rotation_deg"] for i in found]
        levels = [i["credible_level"] for i in found if i["credible_level"] is not None]
        lines.append(measure.row(
            name, f"{sum(i['found'] for i in well)} of {len(well)}", mean_median(positions),
            f"{max(positions):.1f}" if found else "-", mean_median(rotations),
            f"{max(rotations):.1f}" if found else "-", share(sum(l <= 0.5 for l in levels), len(levels)),
            share(sum(l <= 0.95 for l in levels), len(levels))))
    return lines


def room_number(record):
    return record["room"].removeprefix("room ")


def named(pairs):
    """How often each (room, instance) is among (record, instance) pairs."""
    return collections.Counter((room_number(record), instance["id"]) for record, instance in pairs)


def outlier_lines(part):
    """What was missed, what is false, what is far off: by name."""
    seeds = collections.Counter(room_number(record) for record in part.records)

    def listed(pairs, extra=None):
        words = []
        for (room, name), count in sorted(named(pairs).items()):
            worst = "" if extra is None else ", " + extra(room, name)
            words.append(f"{name} of {room} ({count} of {seeds[room]}{worst})")
        return ", ".join(words) or "none"
    each = [(record, i) for record in part.records for i in record["instances"]]
    far = [(r, i) for r, i in each if i["found"] and 100 * i["position_m"] > COARSE_CM]

    def worst_of(room, name):
        members = [i for r, i in far if (room_number(r), i["id"]) == (room, name)]
        return f"up to {max(100 * i['position_m'] for i in members):.1f} cm and " \
               f"{max(i['rotation_deg'] for i in members):.0f} deg"
    false = [f"{s['model']} in {room_number(r)} (seed {r['seed']})" for r in part.records for s in r["spurious"]]
    wrong = [(r, i) for r, i in each if i["found"] and not i["model_right"]]
    lines = ["- Missed, of what shows well (runs of its room): "
             + listed([(r, i) for r, i in each if i["shows_well"] and not i["found"]]) + ".",
             "- False: " + (", ".join(false) or "none") + ".",
             f"- Further off than {COARSE_CM:g} cm: " + listed(far, worst_of) + "."]
    if wrong:
        lines.append("- Wrong shape of the right category: " + listed(wrong) + ".")
    return lines


def room_table(part):
    lines = measure.header("room", "shows well", "found, by seed", "false", "position [cm]", "rotation [deg]",
                           "truth in 50 %", "in 95 %")
    rooms = collections.defaultdict(list)
    for record in part.records:
        rooms[room_number(record)].append(record)
    for room, records in rooms.items():
        of = [measure.figures(record) for record in sorted(records, key=lambda record: record["seed"])]

        def mean(key):
            values = [f[key] for f in of if f[key] is not None]
            return measure.number(statistics.fmean(values) if values else None)
        judged = sum(f["judged"] for f in of)
        lines.append(measure.row(room, of[0]["well"], " ".join(str(f["found_well"]) for f in of),
                                 sum(f["spurious"] for f in of), mean("position_cm"), mean("rotation_deg"),
                                 f"{sum(f['in_50'] for f in of)} of {judged}",
                                 f"{sum(f['in_95'] for f in of)} of {judged}"))
    return lines


def listed_instances(part):
    """As measure.sh lists them, without the columns that say nothing here."""
    table = measure.instance_table(part.records)
    drop = {0, 4}  # room, missed
    return ["| " + " | ".join(cell.strip() for k, cell in enumerate(line.strip("|").split("|")) if k not in drop) + " |"
            for line in table]


def section(title, parts):
    lines = [f"## {title}", ""]
    for part in parts:
        of = f"boxes `{part.detector}`, edges `{part.edges}`" + "".join(f", `{s}`" for s in part.settings)
        lines += [f"**{of[0].upper() + of[1:]}** (`{part.command}`)", ""]
        if part.name in INSTANCES_LISTED:
            lines += listed_instances(part) + [""]
        elif len({room_number(record) for record in part.records}) > 1:
            lines += room_table(part) + [""] + category_table(part) + [""]
        lines += outlier_lines(part) + [""] + measure.belief_lines(part.records)
        lines += measure.trajectory_lines(part.records)
    return lines


def stretches(numbers):
    """'101 to 120, 129' of numbers that rise."""
    runs = []
    for number in numbers:
        if runs and runs[-1][1] + 1 == number:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    return ", ".join(f"{first} to {last}" if last > first else str(first) for first, last in runs)


LOOKED_AT = 128  # Synthetic rooms from 101 to this were looked at while rules were made.
INTRODUCTION = """# How accurate its maps are

Written by `scripts/accuracy_page.py` from results of `scripts/measure.sh`, all of one program (commit {commit}); no figure here is put in by hand.
What each setting is, what was tuned on what, and what fails: [the semantic filter](algorithms/semantic_filter_measured.md). What the columns mean: [evaluation](algorithms/evaluation.md).

Means are over all objects found, turned round or not, of all runs together. *Found*: confirmed within 50 cm of an instance of its category. *Shows well*: for 2 s or more (in synthetic pictures with 2000 pixels).
*Truth in 50 %*: in the highest-density region of the belief, at the end of the run; 50 % of the objects is honest. NEES: a mean of 4 and a median of 2.0 are ([tails](algorithms/semantic_filter.md#tails)). `dataset`: boxes that come with the data (of the office PicoDet's; of synthetic rooms drawn with errors). `builtin`: our own networks; `gradient`: no network.
± is half of the 95 % confidence interval. Synthetic rooms 101 to {looked_at} were looked at while rules were made ([which, and when](algorithms/semantic_filter_measured.md)), 101 to 120 with seeds 0 to 5, the others with 0 to 2 (125 with 3, too); later ones were not.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commit", required=True, help="of the program that was measured")
    parser.add_argument("results", nargs="+", help="results.json of scripts/measure.sh")
    arguments = parser.parse_args()
    try:
        parts = [part for file in arguments.results for part in parts_of(file)]
    except (OSError, ValueError, KeyError) as error:
        return f"accuracy_page: these are no results of scripts/measure.sh: {error}"
    plain = [part for part in parts if part.variant == "as it is" or part.name == "own-poses"]
    lines = [INTRODUCTION.format(commit=arguments.commit, looked_at=LOOKED_AT), "## At a glance", "", *summary_header()]
    for name in [*TITLES, *sorted({p.name for p in plain} - TITLES.keys())]:
        for part in (p for p in plain if p.name == name):
            title = TITLES.get(name, name)
            if part.variant != "as it is":
                title += ": " + part.variant
            if part.settings:
                title += ", " + ", ".join(f"`{s}`" for s in part.settings)
            rooms = sorted({room_number(r) for r in part.records})
            seeds = sorted({r["seed"] for r in part.records})
            if name in ("rooms-imu", "own-poses"):
                title += ", " + stretches([int(room) for room in rooms])
            title += f", seed {seeds[0]}" if len(seeds) == 1 else f", seeds {seeds[0]} to {seeds[-1]}"
            lines.append(summary_row(title, part))
            held_out = [r for r in part.records if name == "rooms-imu" and int(room_number(r)) > LOOKED_AT]
            if held_out and len(held_out) < len(part.records):
                only = copy.copy(part)
                only.records = held_out
                numbers = sorted(int(room_number(r)) for r in held_out)
                lines.append(summary_row(f"of these, {numbers[0]} to {numbers[-1]} (held out)", only))
    lines += [""]
    for name, title in TITLES.items():
        of = [part for part in plain if part.name == name]
        if of:
            lines += section(title, of)
    scenes = [p for p in plain if p.name.startswith(("claim-", "scene-"))]
    if scenes:
        lines += ["## Claims and scenes", "", "Synthetic scenes with one difficulty each, rooms 201 to 205.", ""]
        for part in scenes:
            lines += [f"**{part.name}**", "", *outlier_lines(part), ""]
    by_set = collections.defaultdict(dict)
    for part in parts:
        by_set[part.command][part.variant] = part
    for command, variants in by_set.items():
        if "--ablate" in command:
            lines += ["## Which cue carries what", "", f"`{command}`; the difference is paired over seeds.", "",
                      *measure.ablation_table({v: p.records for v, p in variants.items()}), ""]
    print("\n".join(lines).rstrip())
    return 0


if __name__ == "__main__":
    sys.exit(main())
