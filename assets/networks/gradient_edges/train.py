#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fits the weights of engine/vision/edge_gradient_model.h on BSDS500 and prints them (docs/algorithms/edges.md).

  train.py --tool build/bin/edge_candidates --evaluator eval_edges.py --data bsds500 > model.txt

The tool is built with -DPLUMBLINE_BENCHMARKS=ON. The evaluator is a BSDS evaluation whose class GT(boundaries,
distance).match(rows, columns) says which pixels of an edge map match an annotator's. `bsds500` holds
images/SPLIT/ID.jpg and gt/SPLIT/ID_k.png. Trains on `train`, chooses among three seeds by average precision on `val`.
"""
import argparse, glob, importlib.util, os, subprocess, sys, tempfile
import numpy as np, cv2

NOISES = (0, 2, 4)  # grey levels added to the training images
FEATURES, HIDDEN = 8, 8


def candidates(tool, files, noise):
    with tempfile.NamedTemporaryFile() as out:
        subprocess.run([tool, str(noise), out.name] + files, check=True)
        data = np.fromfile(out.name, np.float32)
    at = 0
    for _ in files:
        n = int(data[at:at + 1].view(np.int32)[0])
        yield data[at + 1:at + 1 + n * (2 + FEATURES)].reshape(n, 2 + FEATURES)
        at += 1 + n * (2 + FEATURES)


def labels(evaluator, data, split, file, found):
    """Whether some annotator has a boundary there, matched one to one within 0.75 % of the image's diagonal."""
    distance = .0075 * np.hypot(*cv2.imread(file).shape[:2])
    rows, columns = found[:, 1].astype(int), found[:, 0].astype(int)
    hit = np.zeros(len(found), bool)
    for truth in glob.glob(os.path.join(data, 'gt', split, os.path.basename(file)[:-4] + '_*.png')):
        hit |= evaluator.GT(cv2.imread(truth, 0) > 0, distance).match(rows, columns)[0]
    return hit


def dataset(args, evaluator, split, noises):
    files = sorted(glob.glob(os.path.join(args.data, 'images', split, '*.jpg')))
    x, y = [], []
    for noise in noises:
        for file, found in zip(files, candidates(args.tool, files, noise)):
            x.append(found[:, 2:])
            y.append(labels(evaluator, args.data, split, file, found))
    return np.vstack(x), np.concatenate(y).astype(np.float32)


def average_precision(score, y):
    hits = np.cumsum(y[np.argsort(-score)])
    recall = hits / hits[-1]
    return np.sum(np.diff(np.r_[0, recall]) * hits / np.arange(1, len(y) + 1))


def log_odds(p, x):
    return np.maximum(x @ p[0] + p[1], 0) @ p[2] + p[3]


def fit(x, y, seed, epochs=6, rate=.01, batch=4096):
    """Adam with a cosine schedule on the cross entropy."""
    rng = np.random.default_rng(seed)
    p = [rng.normal(0, FEATURES**-.5, (FEATURES, HIDDEN)).astype(np.float32), np.zeros(HIDDEN, np.float32),
         rng.normal(0, HIDDEN**-.5, HIDDEN).astype(np.float32), np.float32(0)]
    m, s, t = [0 * v for v in p], [0 * v for v in p], 0
    steps = len(y) // batch * epochs
    for _ in range(epochs):
        order = rng.permutation(len(y))
        for b in range(0, len(y) - batch + 1, batch):
            k = order[b:b + batch]
            t += 1
            hidden = np.maximum(x[k] @ p[0] + p[1], 0)
            d = (1 / (1 + np.exp(-(hidden @ p[2] + p[3]))) - y[k]) / batch
            back = np.outer(d, p[2]) * (hidden > 0)
            gradients = [x[k].T @ back, back.sum(0), hidden.T @ d, d.sum()]
            step = rate * .5 * (1 + np.cos(np.pi * t / steps))
            for q, g in enumerate(gradients):
                g = g + 1e-5 * p[q]
                m[q] = .9 * m[q] + .1 * g
                s[q] = .999 * s[q] + .001 * g * g
                p[q] = p[q] - step * (m[q] / (1 - .9**t)) / (np.sqrt(s[q] / (1 - .999**t)) + 1e-8)
    return p


def row(values):
    return '{' + ', '.join('%#.5gf' % v for v in values) + '}'


def main():
    parser = argparse.ArgumentParser()
    for name in ('tool', 'evaluator', 'data'):
        parser.add_argument('--' + name, required=True)
    args = parser.parse_args()
    spec = importlib.util.spec_from_file_location('evaluator', args.evaluator)
    evaluator = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(evaluator)
    x, y = dataset(args, evaluator, 'train', NOISES)
    xv, yv = dataset(args, evaluator, 'val', (0,))
    keep = np.random.default_rng(0).permutation(len(y))[:2000000]
    x, y = x[keep], y[keep]
    mean, deviation = x.mean(0), x.std(0)
    best = None
    for seed in range(3):
        p = fit((x - mean) / deviation, y, seed)
        score = average_precision(log_odds(p, (xv - mean) / deviation), yv)
        print('seed %d: average precision on val %.4f' % (seed, score), file=sys.stderr)
        if best is None or score > best[0]:
            best = score, p
    p = best[1]
    hidden = p[0] / deviation[:, None]
    print('.hidden = {%s},' % ', '.join(row(r) for r in hidden))
    print('.hidden_bias = %s,' % row(p[1] - mean @ hidden))
    print('.output = %s,' % row(p[2]))
    print('.output_bias = %#.5gf' % p[3])


if __name__ == '__main__':
    main()
