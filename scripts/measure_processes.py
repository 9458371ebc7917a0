#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Maps a sequence in one process and in the five of the paper's graph, by turns, and tells throughput, processor time
and how old images are when they are mapped. What networks make of an image is computed every time, not read from the cache.
Usage: measure_processes.py PLUMBLINE SEQUENCE [--turns N] [-- OPTIONS OF RUN]"""
import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time


def cpu_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def use_cache_in(folder):
    """From now on programs keep things there; views of models are taken over, as they take long to make."""
    theirs = os.path.join(os.environ.get("XDG_CACHE_HOME", os.path.expanduser("~/.cache")), "plumbline")
    ours = os.path.join(folder, "cache", "plumbline")
    os.makedirs(ours)
    for name in os.listdir(theirs) if os.path.isdir(theirs) else []:
        if name.startswith("viewpoints-"):
            shutil.copy(os.path.join(theirs, name), ours)
    os.environ["XDG_CACHE_HOME"] = os.path.join(folder, "cache")
    return os.path.join(ours, "networks")


def measure(words, networks, looking=None):
    """(seconds, processor seconds) of a command; `looking` is called while it works."""
    shutil.rmtree(networks, ignore_errors=True)
    before, began = cpu_s(), time.monotonic()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    looked = began
    while looking and process.poll() is None:
        time.sleep(0.1)
        if time.monotonic() - looked > 3:  # looking costs processor time, too
            looking()
            looked = time.monotonic()
    if process.wait() != 0:
        sys.exit("failed: " + " ".join(words))
    return time.monotonic() - began, cpu_s() - before


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plumbline")
    parser.add_argument("sequence")
    parser.add_argument("--turns", type=int, default=3)
    arguments, options = parser.parse_known_args()
    options = [word for word in options if word != "--"]
    plumbline = arguments.plumbline
    with tempfile.TemporaryDirectory() as folder:
        networks = use_cache_in(folder)
        run = os.path.join(folder, "run.plb")
        result = os.path.join(folder, "result.json")
        state = os.path.join(folder, "state.json")
        for turn in range(arguments.turns):
            common = [arguments.sequence, "--out", run, "--json", result] + options
            seconds, cpu = measure([plumbline, "run"] + common, networks)
            one = json.load(open(result))
            live = one.get("live")
            print(f"one process:    {one['frames'] / seconds:6.2f} frames/s, {1000 * cpu / one['frames']:6.0f} ms of processor a frame"
                  + (f", images {live['mapped_age_ms']:.0f} ms old when mapped, {live['passed_over']} passed over" if live else ""))
            graph = os.path.join(folder, f"graph{turn}")
            seen = {}

            def look():
                asked = subprocess.run([plumbline, "graph", graph, "--patience", "0.3", "--json", state],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                if asked.returncode == 0:
                    nodes = {node["name"]: node for node in json.load(open(state))["nodes"] if node["answers"]}
                    seen.update(nodes)

            seconds, cpu = measure([plumbline, "up", "paper", "--folder", graph] + common, networks, look)
            five = json.load(open(result))
            mapper, player = seen.get("mapper", {}), seen.get("player", {})
            copied = sum(node["served"]["copied_bytes"] for node in seen.values()) / 1e6
            print(f"five processes: {five['frames'] / seconds:6.2f} frames/s, {1000 * cpu / five['frames']:6.0f} ms of processor a frame, "
                  f"{copied:.0f} MB copied, {player.get('served', {}).get('images_shared', 0)} images shared; the mapper: {mapper.get('state', '')}; "
                  + ", ".join(f"{s['name']} {s['latency_ms']:.0f} ms" for n in seen.values() for s in n["streams"]))


if __name__ == "__main__":
    main()
