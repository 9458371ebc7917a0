#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Says how often an edge of a given raw score is one: the `calibration` of a network's sidecar.

  calibrate.py --program build/bin/plumbline --network edge.onnx --evaluator eval_edges.py --bsds bsds500

Of the pixels that `plumbline edges --raw` leaves after thinning, by their score: the share that an annotator's boundary
matches, one to one, within 0.75 % of the diagonal. On pictures that the network has not seen: train it on `train` for this.
The evaluator is a BSDS evaluation whose class GT(boundaries, distance).match(rows, columns) says which pixels of an edge map
match an annotator's.
"""
import argparse
import glob
import importlib.util
import json
import os
import subprocess
import tempfile

import cv2
import numpy as np

BOUNDS = [.1, .15, .2, .25, .3, .35, .4, .45, .5, .55, .6, .65, .7, .75, .8, .85, .9, .95, 1.0001]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ('program', 'network', 'evaluator', 'bsds'):
        parser.add_argument('--' + name, required=True)
    parser.add_argument('--split', default='val')
    args = parser.parse_args()
    spec = importlib.util.spec_from_file_location('evaluator', args.evaluator)
    evaluator = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(evaluator)
    files = sorted(glob.glob(os.path.join(args.bsds, 'images', args.split, '*.jpg')))
    scores, hits = [], []
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([args.program, 'edges', '--raw', '--network', args.network, '--out', out] + files, check=True)
        for file in files:
            name = os.path.basename(file)[:-4]
            edges = cv2.imread(os.path.join(out, name + '.png'), 0)
            rows, columns = np.nonzero(edges)
            distance = .0075 * np.hypot(*edges.shape)
            hit = np.zeros(len(rows), bool)
            for truth in glob.glob(os.path.join(args.bsds, 'gt', args.split, name + '_*.png')):
                hit |= evaluator.GT(cv2.imread(truth, 0) > 0, distance).match(rows, columns)[0]
            scores.append(edges[rows, columns] / 255)
            hits.append(hit)
    scores, hits = np.concatenate(scores), np.concatenate(hits)
    curve, last = [[0, 0]], 0.0
    for low, high in zip(BOUNDS, BOUNDS[1:]):
        inside = (scores >= low) & (scores < high)
        if inside.sum() < 200:
            continue
        last = max(last, float(hits[inside].mean()))
        curve.append([round(float(scores[inside].mean()), 3), round(last, 3)])
    if curve[-1][0] < 1:
        curve.append([1, curve[-1][1]])
    print(json.dumps(curve))


if __name__ == '__main__':
    main()
