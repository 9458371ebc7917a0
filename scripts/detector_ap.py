#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Average precision of a detector's boxes, by category, against what is truly visible.

  plumbline detect ROOM/color --detector FILE.onnx --min-score .01 --coco boxes.json
  scripts/detector_ap.py boxes.json --masks ROOM [--json FILE]   (several of both: one table of all)

  plumbline annotate export PROJECT.json --format bop --out bop
  scripts/detector_ap.py boxes.json --bop bop

The truth is the box of what shows: of the masks of a synthetic sequence, or of bbox_visib of a BOP dataset that `annotate
export` wrote. Rules of COCO: IoU .50 to .95 in steps of .05, 101 points of recall, 100 boxes an image. Objects of which less
than --least-pixels or (BOP) --least-share show count neither way. Needs python3-numpy, and python3-opencv for masks.
"""
import argparse
import collections
import json
import os
import re
import sys

import numpy as np

IOUS = np.arange(.5, .96, .05)
RECALLS = np.linspace(0, 1, 101)
MOST = 100  # boxes of a category in an image


def stem(name):
    """Number of the frame that a file is named by."""
    digits = re.findall(r'\d+', os.path.basename(name))
    if not digits:
        raise SystemExit("'%s' is named by no frame number" % name)
    return int(digits[-1])


def truth_of_masks(sequence, frames, least_pixels):
    """{frame: [(category, [x0, y0, x1, y1], counts)]} of the masks of `plumbline synth`."""
    import cv2
    with open(os.path.join(sequence, 'ground_truth.json')) as file:
        categories = {i['mask_id']: i['category'] for i in json.load(file)['instances']}
    truth = {}
    for frame in frames:
        file = os.path.join(sequence, 'masks', '%06d.png' % frame)
        mask = cv2.imread(file, cv2.IMREAD_UNCHANGED)
        if mask is None:
            raise SystemExit("'%s' cannot be read" % file)
        truth[frame] = []
        for number, category in categories.items():
            rows, columns = np.nonzero(mask == number)
            if len(rows):
                box = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
                truth[frame].append((category, box, len(rows) >= least_pixels))
    return truth


def truth_of_bop(folder, frames, least_pixels, least_share):
    """The same of the first scene of a BOP dataset of ours."""
    scene = os.path.join(folder, 'test', '000000')
    with open(os.path.join(scene, 'scene_gt.json')) as file:
        poses = json.load(file)
    with open(os.path.join(scene, 'scene_gt_info.json')) as file:
        infos = json.load(file)
    with open(os.path.join(folder, 'models', 'plumbline_models.json')) as file:
        named = json.load(file)
    models = {int(key): value for key, value in named.items()}
    truth = {}
    for frame in frames:
        if str(frame) not in infos:
            raise SystemExit("'%s' has no frame %d" % (scene, frame))
        truth[frame] = []
        for pose, info in zip(poses[str(frame)], infos[str(frame)]):
            x, y, w, h = info['bbox_visib']
            if w > 0:
                counts = info['px_count_visib'] >= least_pixels and info['visib_fract'] >= least_share
                truth[frame].append((models[pose['obj_id']]['category'], [x, y, x + w, y + h], counts))
    return truth


def overlaps(box, others):
    others = np.asarray(others, float).reshape(-1, 4)
    low, high = np.maximum(others[:, :2], box[:2]), np.minimum(others[:, 2:], box[2:])
    inside = np.prod(np.clip(high - low, 0, None), axis=1)
    area = np.prod(others[:, 2:] - others[:, :2], axis=1) + (box[2] - box[0]) * (box[3] - box[1])
    return inside / (area - inside)


def average_precision(boxes, truth, iou):
    """Of one category. boxes: (frame, score, box); truth: {frame: [(box, counts)]}. Nothing where no truth counts."""
    total = sum(counts for objects in truth.values() for _, counts in objects)
    if total == 0:
        return None
    taken, hits = collections.defaultdict(set), []
    for frame, _, box in sorted(boxes, key=lambda b: -b[1]):
        objects = truth.get(frame, [])
        found = None
        for want in (True, False):  # one that counts is preferred, whatever they overlap
            free = [k for k, (_, counts) in enumerate(objects) if counts == want and k not in taken[frame]]
            each = overlaps(box, [objects[k][0] for k in free])
            if found is None and len(free) and each.max() >= iou:
                found = free[int(each.argmax())]
        if found is None:
            hits.append(0)
        else:
            taken[frame].add(found)
            if objects[found][1]:
                hits.append(1)
    hits = np.array(hits, float)
    right = np.cumsum(hits)
    recall, precision = right / total, right / np.arange(1, len(hits) + 1)
    precision = np.maximum.accumulate(precision[::-1])[::-1]
    at = np.searchsorted(recall, RECALLS - 1e-12)
    return float(np.mean(np.where(at < len(hits), np.append(precision, 0)[np.minimum(at, len(hits))], 0)))


def evaluate(detections, truth):
    """[(category, objects, AP, AP at IoU .5)], of each category that the truth has."""
    rows = []
    for category in sorted({c for objects in truth.values() for c, _, _ in objects}):
        boxes = [d[1:] for d in detections if d[0] == category]
        mine = {frame: [(b, n) for c, b, n in objects if c == category] for frame, objects in truth.items()}
        each = [average_precision(boxes, mine, iou) for iou in IOUS]
        if each[0] is not None:
            rows.append((category, sum(n for objects in mine.values() for _, n in objects), float(np.mean(each)), each[0]))
    return rows


def read_boxes(file):
    """Frames, and [(category, frame, score, box)], of what `detect --coco` wrote."""
    with open(file) as text:
        found = json.load(text)
    frame_of = {image['id']: stem(image['file_name']) for image in found['images']}
    names = {c['id']: c['name'] for c in found['categories']}
    frames = sorted(frame_of.values())
    if len(set(frames)) < len(frames):
        raise SystemExit("'%s' has two images of one frame number" % file)
    groups = collections.defaultdict(list)
    for a in found['annotations']:
        x, y, w, h = a['bbox']
        frame, category = frame_of[a['image_id']], names[a['category_id']]
        groups[frame, category].append((category, frame, a['score'], [x, y, x + w, y + h]))
    return frames, [d for group in groups.values() for d in sorted(group, key=lambda d: -d[2])[:MOST]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('boxes', nargs='+', help="what 'detect --coco' wrote")
    truths = parser.add_mutually_exclusive_group(required=True)
    truths.add_argument('--masks', metavar='SEQUENCE', nargs='+', help='one for each of the boxes')
    truths.add_argument('--bop', metavar='FOLDER', nargs='+')
    parser.add_argument('--least-pixels', type=int, default=300)
    parser.add_argument('--least-share', type=float, default=.15)
    parser.add_argument('--json', help='write the table to this file, too')
    args = parser.parse_args()
    folders = args.masks or args.bop
    if len(folders) != len(args.boxes):
        raise SystemExit('%d files of boxes, %d of truth: give one for each' % (len(args.boxes), len(folders)))
    kept, truth = [], {}
    for file, folder in zip(args.boxes, folders):
        frames, detections = read_boxes(file)
        objects = truth_of_masks(folder, frames, args.least_pixels) if args.masks else \
            truth_of_bop(folder, frames, args.least_pixels, args.least_share)
        truth.update({(folder, frame): boxes for frame, boxes in objects.items()})
        kept += [(category, (folder, frame), score, box) for category, frame, score, box in detections]
    rows = evaluate(kept, truth)
    print('%-16s %8s %6s %6s' % ('category', 'objects', 'AP', 'AP50'))
    for category, count, ap, ap50 in rows:
        print('%-16s %8d %6.1f %6.1f' % (category, count, 100 * ap, 100 * ap50))
    if rows:
        print('%-16s %8d %6.1f %6.1f' % ('mean', sum(r[1] for r in rows), 100 * np.mean([r[2] for r in rows]), 100 * np.mean([r[3] for r in rows])))
    if args.json:
        with open(args.json, 'w') as file:
            json.dump([dict(zip(('category', 'objects', 'ap', 'ap50'), row)) for row in rows], file, indent=1)
    return 0 if rows else 1


if __name__ == '__main__':
    sys.exit(main())
