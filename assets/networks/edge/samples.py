# SPDX-License-Identifier: Apache-2.0
"""Training pictures: images with, for every pixel, how much the annotators agree that an edge is there."""
import glob
import os

import cv2
import numpy as np

UNKNOWN = .15  # an agreement that the loss leaves out

NEAR = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))  # within 2 px
AROUND = np.ones((3, 3), np.uint8)


def bsds(folder, split):
    """(id, image BGR, agreement) of BSDS500: of all annotators' lines, by how many share them within 2 px."""
    for file in sorted(glob.glob(os.path.join(folder, 'images', split, '*.jpg'))):
        name = os.path.basename(file)[:-4]
        lines = [cv2.imread(f, 0) > 0 for f in sorted(glob.glob(os.path.join(folder, 'gt', split, name + '_*.png')))]
        if not lines:
            raise SystemExit('%s has no annotations in gt/%s' % (file, split))
        share = np.mean([cv2.dilate(line.astype(np.uint8), NEAR) for line in lines], axis=0)
        agreement = cv2.dilate(np.where(np.any(lines, axis=0), share, 0).astype(np.float32), AROUND)
        yield name, cv2.imread(file), agreement


def depth_steps(depth):
    """Where neither surface, continued as a plane, explains the depth beyond [CV_16U, 0 = none]."""
    inverse = np.where(depth > 0, 1 / np.maximum(depth, 1).astype(np.float64), 0)
    steps = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        w = np.moveaxis(inverse, axis, 0)
        here, there = w[1:-2], w[2:-1]
        from_here, from_there = 2 * here - w[:-3], 2 * there - w[3:]
        least = .03 * np.maximum(here, there)
        step = (np.abs(from_here - there) > least) & (np.abs(from_there - here) > least)
        np.moveaxis(steps, axis, 0)[1:-2] |= step
    return steps


def rooms(folders):
    """(name, image, agreement) of frames of `plumbline synth`: boundaries of objects are edges, creases and texture unknown."""
    for folder in folders:
        for file in sorted(glob.glob(os.path.join(folder, 'color', '*'))):
            frame = os.path.basename(file).split('.')[0] + '.png'
            depth = cv2.imread(os.path.join(folder, 'depth', frame), -1)
            mask = cv2.imread(os.path.join(folder, 'masks', frame), -1)
            other = cv2.imread(os.path.join(folder, 'edges', frame), 0)
            if depth is None or mask is None or other is None:
                raise SystemExit('%s lacks depth/, masks/ or edges/ of frame %s' % (folder, frame))
            boundary = depth_steps(depth)
            boundary[:, :-1] |= mask[:, :-1] != mask[:, 1:]
            boundary[:-1] |= mask[:-1] != mask[1:]
            agreement = np.where(cv2.dilate((other > 0).astype(np.uint8), NEAR) > 0, np.float32(UNKNOWN), np.float32(0))
            agreement[cv2.dilate(boundary.astype(np.uint8), AROUND) > 0] = 1
            yield os.path.basename(folder) + '/' + frame[:-4], cv2.imread(file), agreement


def crop(rng, image, agreement, size, scales):
    """A square of `size` pixels, turned, scaled, mirrored, and in other light."""
    h, w = image.shape[:2]
    angle = rng.uniform(-180, 180) if rng.random() < .7 else rng.choice([0, 90, 180, 270])
    scale = np.exp(rng.uniform(np.log(scales[0]), np.log(scales[1])))
    turn = cv2.getRotationMatrix2D((0, 0), angle, scale)
    if rng.random() < .5:
        turn[0] *= -1
    half = size / 2 / scale
    center = [rng.uniform(min(half, n / 2), max(n - half, n / 2)) for n in (w, h)]
    turn[:, 2] = size / 2 - turn[:, :2] @ center
    if scale < .8:  # the lines must not fall between the pixels
        image = cv2.GaussianBlur(image, (0, 0), .45 / scale)
        agreement = cv2.dilate(agreement, AROUND)
    image = cv2.warpAffine(image, turn, (size, size), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
    agreement = cv2.warpAffine(agreement, turn, (size, size), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
    image = image.astype(np.float32)
    if rng.random() < .6:
        mean = image.mean((0, 1))
        image = (image - mean) * rng.uniform(.6, 1.3) + mean * rng.uniform(.6, 1.4) + rng.normal(0, 8, 3)
        if rng.random() < .3:
            grey = image.mean(2, keepdims=True)
            image = grey + (image - grey) * rng.uniform(0, 1)
    if rng.random() < .3:
        image = cv2.GaussianBlur(image, (0, 0), rng.uniform(.5, 1.2))
    if rng.random() < .4:
        image = image + rng.normal(0, rng.uniform(1, 6), image.shape)
    return np.clip(image, 0, 255).astype(np.float32), agreement
