#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Trains the detector (README.md beside this file has the recipe of the one that ships).

  draw.py --out pictures --count 12000 .. &
  train.py --drawn pictures --rooms office/* --steps 10500 --bfloat16 --out build/networks/detector

Writes OUT/detector.pt after every 250 steps (run the same command again to go on), OUT/log.csv and, at the end,
OUT/detector.onnx, its head and its sidecar. Needs python3-torch, python3-torchvision, python3-opencv.
The same options and --threads 1 give the same weights.
"""
import argparse
import os
import sys
from collections import OrderedDict

import cv2
import numpy as np
import torch

import detector_net
import samples

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
import export_torchvision  # noqa: E402
from training import Training  # noqa: E402

EVERY = 250  # steps from one checkpoint to the next
EMA = .998
MOST_DRAWN = 12000
SIZE, EXPORTED = (320, 240), (448, 320)  # of training pictures, of the exported network's input


def rate_at(step, steps, rate):
    """Rises for 200 steps, stays for half, falls as a cosine."""
    share = max(0.0, (step / steps - .5) / .5)
    return rate * min(1.0, (step + 1) / 200) * .5 * (1 + np.cos(np.pi * share))


def drawn_until(step, at_first):
    """More pictures as training goes on, so that it may begin while they are drawn."""
    return min(at_first + 3 * step // 2, MOST_DRAWN)


def batch(rng, folder, drawn, rooms, count, rooms_share):
    """From the first `drawn` pictures of the folder, and from rooms."""
    images, targets = [], []
    for _ in range(count):
        if rooms and rng.random() < rooms_share:
            file, boxes = rooms[rng.integers(len(rooms))]
        else:
            file, boxes = samples.drawn(folder, rng.integers(drawn))
        image, boxes = samples.varied(rng, cv2.imread(file), boxes, SIZE)
        images.append(torch.from_numpy(image[:, :, ::-1].transpose(2, 0, 1).astype(np.float32) / 255))
        labels = [1 + detector_net.CATEGORIES.index(b[0]) for b in boxes]
        targets.append({'boxes': torch.tensor([b[1:] for b in boxes], dtype=torch.float32).reshape(-1, 4),
                        'labels': torch.tensor(labels, dtype=torch.int64)})
    return images, targets


def in_bfloat16(trunk):
    """Convolves in 16 bits, on which processors that know them spend half the time."""
    exact = trunk.forward

    def forward(image):
        with torch.autocast('cpu', torch.bfloat16):
            return OrderedDict((name, features.float()) for name, features in exact(image).items())
    trunk.forward = forward


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--drawn', required=True, help='folder of draw.py: up to 12000 pictures, as training goes on; waits for those that are not there yet')
    parser.add_argument('--drawn-at-first', type=int, default=300, help='pictures that the first step draws from')
    parser.add_argument('--rooms', nargs='*', default=[], help='sequences of plumbline synth')
    parser.add_argument('--rooms-share', type=float, default=.15, help='of the pictures, how many come from rooms')
    parser.add_argument('--steps', type=int, required=True)
    parser.add_argument('--batch', type=int, default=8)
    parser.add_argument('--rate', type=float, default=1.5e-3)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--bfloat16', action='store_true', help='of the trunk, in training')
    parser.add_argument('--threads', type=int, default=1)
    parser.add_argument('--out', required=True)
    args = parser.parse_args()

    torch.set_num_threads(args.threads)
    cv2.setNumThreads(1)
    torch.manual_seed(args.seed)
    os.makedirs(args.out, exist_ok=True)
    rooms = list(samples.rooms(args.rooms))
    print('%d drawn pictures, %d of rooms' % (drawn_until(args.steps, args.drawn_at_first), len(rooms)), flush=True)
    training = Training(detector_net.detector_net, args.rate, 1e-2, os.path.join(args.out, 'detector.pt'))
    training.net.train()
    if args.bfloat16:
        in_bfloat16(training.net.backbone)
    sums = {}
    while training.step < args.steps:
        rng = np.random.default_rng([args.seed, training.step])
        torch.manual_seed(args.seed * 1000003 + training.step)  # which boxes are drawn
        images, targets = batch(rng, args.drawn, drawn_until(training.step, args.drawn_at_first), rooms, args.batch, args.rooms_share)
        losses = training.net(images, targets)
        training.descend(sum(losses.values()), rate_at(training.step, args.steps, args.rate), EMA)
        for name, loss in losses.items():
            sums[name] = sums.get(name, 0) + loss.item()
        if training.step % EVERY == 0 or training.step == args.steps:
            count = (training.step - 1) % EVERY + 1
            means = [sums[name] / count for name in ('loss_objectness', 'loss_rpn_box_reg', 'loss_classifier', 'loss_box_reg')]
            seconds = training.save(os.path.join(args.out, 'log.csv'), means)
            print('step %d of %d: proposals %.4f %.4f, boxes %.4f %.4f, %.0f s' % (training.step, args.steps, *means, seconds), flush=True)
            sums = {}
    export_torchvision.export(training.average.eval(), os.path.join(args.out, 'detector.onnx'), EXPORTED, detector_net.CATEGORIES)


if __name__ == '__main__':
    main()
