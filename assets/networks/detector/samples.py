# SPDX-License-Identifier: Apache-2.0
"""Pictures with boxes, as draw.py writes them and as `plumbline synth` does, and how they are varied."""
import glob
import json
import os
import time

import cv2
import numpy as np

LEAST_PIXELS = 150  # of an object in a frame of a synthetic room that is labelled


def drawn(folder, number):
    """(image file, [category, x0, y0, x1, y1]) of draw.py; waits until it is there."""
    file = os.path.join(folder, '%06d' % number)
    if not os.path.exists(file + '.json'):
        print('waiting for %s.json, which draw.py writes' % file, flush=True)
    while not os.path.exists(file + '.json'):
        time.sleep(1)
    with open(file + '.json') as boxes:
        return file + '.jpg', json.load(boxes)


def rooms(folders):
    """The same of sequences of plumbline synth: boxes of what the masks show."""
    for folder in folders:
        if not os.path.isdir(os.path.join(folder, 'masks')):
            raise SystemExit("'%s' is not a sequence of plumbline synth: it has no masks/" % folder)
        with open(os.path.join(folder, 'ground_truth.json')) as file:
            categories = {i['mask_id']: i['category'] for i in json.load(file)['instances']}
        for file in sorted(glob.glob(os.path.join(folder, 'color', '*'))):
            mask = cv2.imread(os.path.join(folder, 'masks', os.path.basename(file).split('.')[0] + '.png'), -1)
            boxes = []
            for number, category in categories.items():
                rows, columns = np.nonzero(mask == number)
                if len(rows) >= LEAST_PIXELS:
                    boxes.append([category, int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1])
            yield file, boxes


def varied(rng, image, boxes, size):
    """Image of `size` (width, height) cut out of another, mirrored, in other light; boxes of which enough is left."""
    h, w = image.shape[:2]
    scale = max(size[0] / w, size[1] / h) * np.exp(rng.uniform(np.log(.62), np.log(1.6)))
    stretch = np.exp(rng.normal(0, .08))
    sx, sy = scale * stretch, scale / stretch
    x, y = rng.uniform(0, 1, 2) * (np.array([w * sx, h * sy]) - size)
    turn = np.array([[sx, 0, -x], [0, sy, -y]])
    if rng.random() < .5:
        turn = np.array([[-1, 0, size[0]], [0, 1, 0]]) @ np.vstack((turn, [0, 0, 1]))
    border = cv2.BORDER_CONSTANT if rng.random() < .5 else cv2.BORDER_REPLICATE
    image = cv2.warpAffine(image, turn, size, flags=cv2.INTER_AREA if scale < .8 else cv2.INTER_LINEAR, borderMode=border, borderValue=(114, 114, 114))
    kept = []
    for category, x0, y0, x1, y1 in boxes:
        corners = np.array([[x0, y0, 1], [x1, y1, 1]]) @ turn.T
        low, high = corners.min(0), corners.max(0)
        inner_low, inner_high = np.clip(low, 0, size), np.clip(high, 0, size)
        area = np.prod(inner_high - inner_low)
        if area >= .25 * np.prod(high - low) and np.all(inner_high - inner_low >= 5):
            kept.append([category, *inner_low, *inner_high])
    image = image.astype(np.float32)
    if rng.random() < .8:  # exposure, contrast, white balance
        mean = image.mean((0, 1))
        image = (image - mean) * rng.uniform(.5, 1.3) + mean * rng.uniform(.55, 1.5) * rng.uniform(.85, 1.15, 3)
    if rng.random() < .3:
        grey = image.mean(2, keepdims=True)
        image = grey + (image - grey) * rng.uniform(0, 1)
    if rng.random() < .3:
        image = cv2.GaussianBlur(image, (0, 0), rng.uniform(.4, 1.5))
    elif rng.random() < .15:  # shaken
        length = int(rng.integers(3, 10))
        line = np.zeros((length, length), np.float32)
        line[length // 2] = 1 / length
        image = cv2.filter2D(image, -1, cv2.warpAffine(line, cv2.getRotationMatrix2D((length / 2, length / 2), rng.uniform(0, 180), 1), (length, length)))
    if rng.random() < .5:
        image = image + rng.normal(0, rng.uniform(1, 12), image.shape)
    image = np.clip(image, 0, 255).astype(np.uint8)
    if rng.random() < .3:
        image = cv2.imdecode(cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(30, 90))])[1], cv2.IMREAD_COLOR)
    return image, kept
