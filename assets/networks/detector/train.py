#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Trains the detector (README.md beside this file has the recipe of the one that ships).

  draw.py --out pictures --count 12000 .. &
  train.py --drawn pictures --rooms office/* --steps 16000 --out build/networks/detector

Writes OUT/detector.pt after every 250 steps (run the same command again to go on), OUT/log.csv and, at the end,
OUT/detector.onnx, its head and its sidecar. Needs python3-torch, python3-torchvision, python3-opencv.
The same options and --threads 1 give the same weights.
"""
import argparse
import csv
import os
import sys
import time

import cv2
import numpy as np
import torch

import detector_net
import samples

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
import export_torchvision

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
    parser.add_argument('--threads', type=int, default=1)
    parser.add_argument('--out', required=True)
    args = parser.parse_args()

    torch.set_num_threads(args.threads)
    cv2.setNumThreads(1)
    torch.manual_seed(args.seed)
    os.makedirs(args.out, exist_ok=True)
    rooms = list(samples.rooms(args.rooms))
    print('%d drawn pictures, %d of rooms' % (drawn_until(args.steps, args.drawn_at_first), len(rooms)), flush=True)
    net, average = detector_net.detector_net(), detector_net.detector_net()
    average.load_state_dict(net.state_dict())
    decayed = [p for p in net.parameters() if p.ndim > 1]
    plain = [p for p in net.parameters() if p.ndim <= 1]
    optimizer = torch.optim.AdamW([{'params': decayed, 'weight_decay': 1e-2}, {'params': plain, 'weight_decay': 0}], lr=args.rate)
    file, step, spent = os.path.join(args.out, 'detector.pt'), 0, 0.0
    if os.path.exists(file):
        saved = torch.load(file)
        for module, key in ((net, 'net'), (average, 'average'), (optimizer, 'optimizer')):
            module.load_state_dict(saved[key])
        step, spent = saved['step'], saved['seconds']
    begun, sums = time.time() - spent, {}
    net.train()
    while step < args.steps:
        rng = np.random.default_rng([args.seed, step])
        torch.manual_seed(args.seed * 1000003 + step)  # which boxes are drawn
        images, targets = batch(rng, args.drawn, drawn_until(step, args.drawn_at_first), rooms, args.batch, args.rooms_share)
        for group in optimizer.param_groups:
            group['lr'] = rate_at(step, args.steps, args.rate)
        losses = net(images, targets)
        optimizer.zero_grad()
        sum(losses.values()).backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 5)
        optimizer.step()
        step += 1
        for name, loss in losses.items():
            sums[name] = sums.get(name, 0) + loss.item()
        keep = min(EMA, step / (step + 10))
        with torch.no_grad():
            for mine, other in zip(average.state_dict().values(), net.state_dict().values()):
                if mine.dtype.is_floating_point:
                    mine.mul_(keep).add_(other, alpha=1 - keep)
                else:
                    mine.copy_(other)
        if step % EVERY == 0 or step == args.steps:
            seconds, count = time.time() - begun, (step - 1) % EVERY + 1
            names = ['loss_objectness', 'loss_rpn_box_reg', 'loss_classifier', 'loss_box_reg']
            means = ['%.4f' % (sums[name] / count) for name in names]
            with open(os.path.join(args.out, 'log.csv'), 'a', newline='') as log:
                csv.writer(log).writerow([step, *means, '%.6f' % optimizer.param_groups[0]['lr'], '%.0f' % seconds])
            print('step %d of %d: proposals %s %s, boxes %s %s, %.0f s' % (step, args.steps, *means, seconds), flush=True)
            sums = {}
            torch.save({'net': net.state_dict(), 'average': average.state_dict(), 'optimizer': optimizer.state_dict(), 'step': step, 'seconds': seconds}, file + '.new')
            os.replace(file + '.new', file)
    export_torchvision.export(average.eval(), os.path.join(args.out, 'detector.onnx'), EXPORTED, detector_net.CATEGORIES)


if __name__ == '__main__':
    main()
