# SPDX-License-Identifier: Apache-2.0
"""How far the objects of a run have moved when they are seen again: the table "Objects seen again" of docs/algorithms/vio.md.

  scripts/seen_again.py RUN.plb [--gap FRAMES]

A visit ends when an object was not weighed for GAP frames. Of each object that is confirmed in the end: where its centre stood when a
visit ended, against when the visit before had ended, in the world of the map. Needs python3-numpy.
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "python" / "plumbline_run"))
import numpy  # noqa: E402
import plumbline_run  # noqa: E402


def visits(run, number, gap):
    """(first, last, centre at the end) of each visit, in positions of the run."""
    found = []
    for position, seen in zip(*run.history(number)):
        if not seen.weighed:
            continue
        if not found or position - found[-1][1] > gap:
            found.append([position, position, None])
        found[-1][1:] = [position, seen.world_from_object[:3, 3]]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run")
    parser.add_argument("--gap", type=int, default=100)
    arguments = parser.parse_args()
    with plumbline_run.Run(arguments.run) as run:
        for seen in run.frame(run.last_used()).objects:
            if seen.state != "confirmed":
                continue
            found = visits(run, seen.id, arguments.gap)
            moved = [f"{first}-{last}: {100 * numpy.linalg.norm(centre - before[2]):.1f} cm"
                     for before, (first, last, centre) in zip(found, found[1:])]
            print(f"{seen.id:5d} {seen.category:14s} {', '.join(moved) or 'one visit'}")


if __name__ == "__main__":
    main()
