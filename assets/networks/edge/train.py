#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Trains the edge network (README.md beside this file has the recipe of the one that ships).

  train.py --bsds bsds500 --split train --steps 12000 --out build/networks/edge

Writes OUT/edge.pt after every 500 steps (run the same command again to go on), OUT/log.csv and, at the end, OUT/edge.onnx.
Needs python3-torch and python3-opencv. The same options and --threads 1 give the same weights.
"""
import argparse
import os
import sys

import numpy as np
import torch
from torch.nn import functional as F

import edge_net
import samples

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
from training import Training  # noqa: E402

EVERY = 500  # steps from one checkpoint to the next
EMA = .999
POSITIVE, NEGATIVE = .3, .05  # agreements from which on, and up to which, a pixel is one or the other


def side_loss(logits, agreement):
    """Cross entropy in which all edges of a crop weigh as much as all else of it."""
    positive, negative = (agreement >= POSITIVE).float(), (agreement < NEGATIVE).float()
    edges, rest = positive.sum((1, 2, 3), keepdim=True), negative.sum((1, 2, 3), keepdim=True)
    balance = rest / (edges + rest).clamp(min=1)
    weight = positive * (.4 + .6 * agreement) * balance + negative * 1.1 * (1 - balance)
    each = F.binary_cross_entropy_with_logits(logits, positive, weight, reduction='none')
    return each.sum() / weight.sum().clamp(min=1)


def loss_of(output, agreement):
    """The full-size map, and the maps at 1/8, 1/4 and 1/2."""
    last, sides = output
    loss = side_loss(last, agreement)
    for weight, side in zip((.3, .3, .4), sides):
        loss = loss + weight * side_loss(side, F.max_pool2d(agreement, agreement.shape[-1] // side.shape[-1]))
    return loss


def rate_at(step, steps, rate):
    """Rises for 50 steps, stays for 60 %, falls as a cosine."""
    share = max(0.0, (step / steps - .6) / .4)
    return rate * min(1.0, (step + 1) / 50) * .5 * (1 + np.cos(np.pi * share))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--bsds', required=True, help='folder with images/SPLIT/ID.jpg and gt/SPLIT/ID_k.png')
    parser.add_argument('--split', nargs='+', default=['train'], help='train, or train val')
    parser.add_argument('--rooms', nargs='*', default=[], help='sequences of plumbline synth')
    parser.add_argument('--rooms-share', type=float, default=.4, help='of the crops, how many come from rooms')
    parser.add_argument('--start', help='weights to begin with (.pt)')
    parser.add_argument('--steps', type=int, required=True)
    parser.add_argument('--batch', type=int, default=8)
    parser.add_argument('--crop', type=int, default=256)
    parser.add_argument('--scales', type=float, nargs=2, default=(.5, 1.5))
    parser.add_argument('--rate', type=float, default=3e-3)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--threads', type=int, default=1)
    parser.add_argument('--out', required=True)
    args = parser.parse_args()

    torch.set_num_threads(args.threads)
    torch.manual_seed(args.seed)
    pictures = [s for split in args.split for s in samples.bsds(args.bsds, split)]
    room_pictures = list(samples.rooms(args.rooms))
    print('%d pictures of BSDS500 (%s), %d of rooms' % (len(pictures), ' '.join(args.split), len(room_pictures)), flush=True)
    os.makedirs(args.out, exist_ok=True)
    training = Training(edge_net.EdgeNet, args.rate, 1e-3, os.path.join(args.out, 'edge.pt'), args.start)
    sum_of_loss = 0.0
    mean = np.array(edge_net.MEAN, np.float32)
    while training.step < args.steps:
        rng = np.random.default_rng([args.seed, training.step])
        images, maps = [], []
        for _ in range(args.batch):
            source = room_pictures if rng.random() < args.rooms_share and room_pictures else pictures
            _, image, agreement = source[rng.integers(len(source))]
            image, agreement = samples.crop(rng, image, agreement, args.crop, args.scales)
            images.append(((image - mean) * edge_net.SCALE).transpose(2, 0, 1))
            maps.append(agreement[None])
        training.net.train()
        loss = loss_of(training.net(torch.from_numpy(np.stack(images))), torch.from_numpy(np.stack(maps)))
        training.descend(loss, rate_at(training.step, args.steps, args.rate), EMA)
        sum_of_loss += loss.item()
        if training.step % EVERY == 0 or training.step == args.steps:
            mean_loss = sum_of_loss / ((training.step - 1) % EVERY + 1)
            seconds = training.save(os.path.join(args.out, 'log.csv'), [mean_loss])
            print('step %d of %d: loss %.4f, %.0f s' % (training.step, args.steps, mean_loss, seconds), flush=True)
            sum_of_loss = 0.0
    edge_net.export(training.average, os.path.join(args.out, 'edge.onnx'))


if __name__ == '__main__':
    main()
