#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Trains the edge network (README.md beside this file has the recipe of the one that ships).

  train.py --bsds bsds500 --split train --steps 12000 --out build/networks/edge

Writes OUT/edge.pt after every 500 steps (run the same command again to go on), OUT/log.csv and, at the end, OUT/edge.onnx.
Needs python3-torch and python3-pil; takes a GPU where torch finds one. The same options, --device cpu and --threads 1 give the
same weights.
"""
import argparse
import math
import os
import sys

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
    return rate * min(1.0, (step + 1) / 50) * .5 * (1 + math.cos(math.pi * share))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--bsds', required=True, help='folder with images/SPLIT/ID.jpg and gt/SPLIT/ID_k.png')
    parser.add_argument('--split', nargs='+', default=['train'], help='train, or train val')
    parser.add_argument('--width', type=float, default=1, help='the channels, in those of the network that ships')
    parser.add_argument('--steps', type=int, required=True)
    parser.add_argument('--batch', type=int, default=8)
    parser.add_argument('--crop', type=int, default=256)
    parser.add_argument('--scales', type=float, nargs=2, default=(.5, 1.5))
    parser.add_argument('--rate', type=float, default=3e-3)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--threads', type=int, default=1)
    parser.add_argument('--device', default='cuda' if torch.cuda.is_available() else 'cpu')
    parser.add_argument('--out', required=True)
    args = parser.parse_args()

    torch.set_num_threads(args.threads)
    torch.manual_seed(args.seed)
    pictures = [pair for split in args.split for pair in samples.bsds(args.bsds, split)]
    print('%d pictures of BSDS500 (%s)' % (len(pictures), ' '.join(args.split)), flush=True)
    crops = samples.Crops(pictures, args.device)
    mean = torch.tensor(edge_net.MEAN, device=args.device)[None, :, None, None]
    generator = torch.Generator(args.device)
    os.makedirs(args.out, exist_ok=True)
    training = Training(lambda: edge_net.EdgeNet(args.width).to(args.device), args.rate, 1e-3, os.path.join(args.out, 'edge.pt'))
    sum_of_loss = 0.0
    while training.step < args.steps:
        generator.manual_seed(args.seed * 1000003 + training.step)
        images, agreement = crops.batch(generator, args.batch, args.crop, args.scales)
        training.net.train()
        loss = loss_of(training.net((images - mean) * edge_net.SCALE), agreement)
        training.descend(loss, rate_at(training.step, args.steps, args.rate), EMA)
        sum_of_loss = sum_of_loss + loss.detach()
        if training.step % EVERY == 0 or training.step == args.steps:
            mean_loss = sum_of_loss.item() / ((training.step - 1) % EVERY + 1)
            seconds = training.save(os.path.join(args.out, 'log.csv'), [mean_loss])
            print('step %d of %d: loss %.4f, %.0f s' % (training.step, args.steps, mean_loss, seconds), flush=True)
            sum_of_loss = 0.0
    edge_net.export(training.average, os.path.join(args.out, 'edge.onnx'))


if __name__ == '__main__':
    main()
