# SPDX-License-Identifier: Apache-2.0
"""Pictures with boxes of `plumbline synth`."""
import glob
import json
import os

import cv2
import numpy as np

LEAST_PIXELS = 150  # of an object in a frame of a synthetic room that is labelled


def rooms(folders):
    """(image file, [category, x0, y0, x1, y1]) of sequences: boxes of what the masks show."""
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
