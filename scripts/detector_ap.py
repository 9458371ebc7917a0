#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Average precision of a detector's boxes, by category, against what is truly visible.

  plumbline detect ROOM/color --detector FILE.onnx --min-score .01 --coco boxes.json
  scripts/detector_ap.py boxes.json --masks ROOM [--json FILE]   (several of both: one table of all)

  plumbline annotate export PROJECT.json --format bop --out bop
  scripts/detector_ap.py boxes.json --bop bop

The truth is the box of what shows: of the masks of a synthetic sequence, or of bbox_visib of a BOP dataset that `annotate
export` wrote. Rules of COCO: IoU .50 to .95 in steps of .05, 101 points of recall, 100 boxes an image. Objects of which less
than --least-pixels or (BOP) --least-share of the whole silhouette, also outside the image, show count neither way. Masks need python3-opencv.
"""
import argparse
import collections
import json
import os
import re
import sys

IOUS = [.5 + .05 * k for k in range(10)]
RECALLS = [k / 100 for k in range(101)]
MOST = 100  # boxes of a category in an image


def read_json(file):
    """Ends with one sentence where there is none."""
    try:
        with open(file) as text:
            return json.load(text)
    except (OSError, ValueError) as error:
        raise SystemExit("'%s' cannot be read: %s" % (file, error)) from None


def stem(name):
    """Number of the frame that a file is named by."""
    digits = re.findall(r'\d+', os.path.basename(name))
    if not digits:
        raise SystemExit("'%s' is named by no frame number" % name)
    return int(digits[-1])


def truth_of_masks(sequence, frames, least_pixels):
    """{frame: [(category, [x0, y0, x1, y1], counts)]} of the masks of `plumbline synth`."""
    import cv2
    import numpy as np
    instances = read_json(os.path.join(sequence, 'ground_truth.json'))['instances']
    if any('mask_id' not in i for i in instances):
        raise SystemExit("'%s' has no masks: it is not a sequence of plumbline synth" % sequence)
    categories = {i['mask_id']: i['category'] for i in instances}
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
                box = [int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1]
                truth[frame].append((category, box, len(rows) >= least_pixels))
    return truth


def truth_of_bop(folder, frames, least_pixels, least_share):
    """The same of the first scene of a BOP dataset of ours."""
    scene = os.path.join(folder, 'test', '000000')
    poses, infos = read_json(os.path.join(scene, 'scene_gt.json')), read_json(os.path.join(scene, 'scene_gt_info.json'))
    named = read_json(os.path.join(folder, 'models', 'plumbline_models.json'))
    models = {int(key): value for key, value in named.items()}
    truth = {}
    for frame in frames:
        if str(frame) not in infos:
            raise SystemExit("'%s' has no frame %d" % (scene, frame))
        truth[frame] = []
        for pose, info in zip(poses[str(frame)], infos[str(frame)]):
            x, y, w, h = info['bbox_visib']
            if w >= 0:  # as bop_toolkit has it: w and h are those between the outermost pixels' centres
                counts = info['px_count_visib'] >= least_pixels and info['visib_fract'] >= least_share
                truth[frame].append((models[pose['obj_id']]['category'], [x, y, x + w + 1, y + h + 1], counts))
    return truth


def overlap(a, b):
    """Intersection over union."""
    width, height = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0
    area = (a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1])
    return width * height / (area - width * height)


def hits_of(boxes, truth, iou):
    """By falling score: whether a box is of an object of its own. Those of objects that do not count are left out."""
    taken, hits = collections.defaultdict(set), []
    for frame, _, box in sorted(boxes, key=lambda b: -b[1]):
        objects, found = truth.get(frame, []), None
        for want in (True, False):  # one that counts is preferred, whatever they overlap
            each = [(overlap(box, other), k) for k, (other, counts) in enumerate(objects) if counts == want and k not in taken[frame]]
            if found is None and each and max(each)[0] >= iou:
                found = max(each)[1]
        if found is not None:
            taken[frame].add(found)
        if found is None or objects[found][1]:
            hits.append(found is not None)
    return hits


def average_precision(boxes, truth, iou):
    """Of one category. boxes: (frame, score, box); truth: {frame: [(box, counts)]}. Nothing where no truth counts."""
    total = sum(counts for objects in truth.values() for _, counts in objects)
    if total == 0:
        return None
    right, curve = 0, []  # (recall, precision)
    for number, hit in enumerate(hits_of(boxes, truth, iou), 1):
        right += hit
        curve.append((right / total, right / number))
    best, sum_of_precision = 0, 0
    for recall in reversed(RECALLS):  # the best precision at this recall or a higher one
        while curve and curve[-1][0] >= recall - 1e-12:
            best = max(best, curve.pop()[1])
        sum_of_precision += best
    return sum_of_precision / len(RECALLS)


def evaluate(detections, truth):
    """[(category, objects, AP, AP at IoU .5)], of each category that the truth has."""
    rows = []
    for category in sorted({c for objects in truth.values() for c, _, _ in objects}):
        boxes = [d[1:] for d in detections if d[0] == category]
        mine = {frame: [(b, n) for c, b, n in objects if c == category] for frame, objects in truth.items()}
        each = [average_precision(boxes, mine, iou) for iou in IOUS]
        if each[0] is not None:
            rows.append((category, sum(n for objects in mine.values() for _, n in objects), sum(each) / len(each), each[0]))
    return rows


def read_boxes(file):
    """Frames, and [(category, frame, score, box)], of what `detect --coco` wrote."""
    found = read_json(file)
    if not isinstance(found, dict) or not {'images', 'categories', 'annotations'} <= found.keys():
        raise SystemExit("'%s' is not what 'plumbline detect --coco' writes" % file)
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
        print('%-16s %8d %6.1f %6.1f' % ('mean', sum(r[1] for r in rows), 100 * sum(r[2] for r in rows) / len(rows), 100 * sum(r[3] for r in rows) / len(rows)))
    if args.json:
        with open(args.json, 'w') as file:
            json.dump([dict(zip(('category', 'objects', 'ap', 'ap50'), row)) for row in rows], file, indent=1)
    return 0 if rows else 1


if __name__ == '__main__':
    sys.exit(main())
