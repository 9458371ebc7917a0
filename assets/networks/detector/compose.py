# SPDX-License-Identifier: Apache-2.0
"""Training pictures put together on the device: a part of a photograph or of a drawn scene, pieces of furniture before it, other light."""
import glob
import json
import math
import os
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import torch
from torch.nn import functional as F

import detector_net
import samples

CANVAS = (336, 480)  # rows, columns of a stored picture; portrait ones lie on their side
PIECE, PIECES = 176, 5
MOST_BOXES = 20
VISIBLE, LEAST = .25, 8  # share and pixels of a side of what is labelled


def stored(image):
    """In the upper left of the canvas, and its size (columns, rows)."""
    share = min(CANVAS[0] / image.shape[0], CANVAS[1] / image.shape[1], 1)
    image = cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA) if share < 1 else image
    canvas = np.zeros((3, *CANVAS), np.uint8)
    canvas[:, :image.shape[0], :image.shape[1]] = image[:, :, ::-1].transpose(2, 0, 1)
    return canvas, (image.shape[1], image.shape[0]), share


def read_picture(file, boxes):
    image = cv2.imread(file)
    canvas, size, share = stored(image)
    rows = [[detector_net.CATEGORIES.index(b[0]) + 1, *[share * v for v in b[1:]]] for b in boxes if b[0] in detector_net.CATEGORIES][:MOST_BOXES]
    return canvas, size, rows


def read_photo(file):
    """Portrait ones, which the canvas would shrink, as they are, cut to a landscape of the middle."""
    image = cv2.imread(file)
    if image.shape[0] > image.shape[1]:
        top = (image.shape[0] - image.shape[1]) // 2
        image = image[top:top + image.shape[1]]
    return (*stored(image)[:2], [])


def read_piece(file):
    piece = cv2.imread(file, cv2.IMREAD_UNCHANGED)
    with open(file[:-5] + '.json') as text:
        category = json.load(text)
    canvas = np.zeros((4, PIECE, PIECE), np.uint8)
    canvas[:3, :piece.shape[0], :piece.shape[1]] = piece[:, :, 2::-1].transpose(2, 0, 1)
    canvas[3, :piece.shape[0], :piece.shape[1]] = piece[:, :, 3]
    return canvas, (piece.shape[1], piece.shape[0]), detector_net.CATEGORIES.index(category) + 1 if category else 0


class Pictures:
    """All of a folder's on the device; batches from them."""

    def __init__(self, photos, drawn, rooms, pieces, device):
        self.device = device
        scenes = []
        for folder in drawn:
            for file in sorted(glob.glob(os.path.join(folder, '*.json'))):
                picture = next(f for f in (file[:-5] + end for end in ('.webp', '.jpg')) if os.path.exists(f))
                with open(file) as text:
                    scenes.append((picture, json.load(text)))
        scenes += list(samples.rooms(rooms))
        with ThreadPoolExecutor(16) as pool:
            real = list(pool.map(read_photo, sorted(f for folder in photos for f in glob.glob(os.path.join(folder, '*.jpg')) + glob.glob(os.path.join(folder, '*.webp')))))
            drawn = list(pool.map(lambda s: read_picture(*s), scenes))
            cut = list(pool.map(read_piece, sorted(glob.glob(os.path.join(pieces, '*.webp')))))
        for found, what in ((real, 'photograph (.jpg, .webp) in %s' % ' '.join(photos)), (scenes, 'scene in the folders of draw.py, and no room'),
                            (cut, "piece of 'draw.py --alone' in %s" % pieces)):
            if not found:
                raise SystemExit('there is no ' + what)
        self.real = len(real)
        everything = real + drawn
        self.pictures = torch.from_numpy(np.stack([p[0] for p in everything])).to(device)
        self.sizes = torch.tensor([p[1] for p in everything], dtype=torch.float32, device=device)
        boxes = np.zeros((len(everything), MOST_BOXES, 5), np.float32)
        for k, picture in enumerate(everything):
            boxes[k, :len(picture[2])] = np.array(picture[2], np.float32).reshape(-1, 5)
        self.boxes = torch.from_numpy(boxes).to(device)
        self.pieces = torch.from_numpy(np.stack([p[0] for p in cut])).to(device)
        self.piece_sizes = torch.tensor([p[1] for p in cut], dtype=torch.float32, device=device)
        self.piece_categories = torch.tensor([p[2] for p in cut], device=device)
        shares = self.pieces[:, 3].float().mean((1, 2)) / 255 * PIECE * PIECE
        self.piece_fill = shares / (self.piece_sizes[:, 0] * self.piece_sizes[:, 1])
        print('%d photographs, %d drawn scenes, %d pieces' % (len(real), len(drawn), len(cut)), flush=True)

    def batch(self, generator, count, side, real_share):
        """RGB 0 .. 1 (count x 3 x side x side); boxes (count x n x 4, px), categories (0: none, -1: neither nor) of each; which are photographs."""
        device = self.device

        def uniform(low, high, *shape):
            return torch.rand(shape or (count,), generator=generator, device=device) * (high - low) + low

        def chance(share, *shape):
            return torch.rand(shape or (count,), generator=generator, device=device) < share

        def whole(most, *shape):
            return (torch.rand(shape or (count,), generator=generator, device=device) * most).long()
        real = chance(real_share)
        index = torch.where(real, whole(self.real), self.real + whole(len(self.pictures) - self.real))
        # A window of the picture, its width and height in the picture's pixels.
        size = self.sizes[index]
        part = torch.where(real, uniform(math.log(.3), 0.), uniform(math.log(.6), math.log(1.1))).exp()
        stretch = torch.randn(count, generator=generator, device=device).mul(.14).exp() * torch.where(chance(.5), 4 / 3, 1.)
        high = part * torch.minimum(size[:, 1], size[:, 0] / stretch)
        wide = high * stretch
        left, top = uniform(0, 1) * (size[:, 0] - wide), uniform(0, 1) * (size[:, 1] - high)
        mirror = torch.where(chance(.5), -1., 1.)
        # Where output pixels look, in -1 .. 1 of the canvas.
        sx, sy = wide / CANVAS[1], high / CANVAS[0]
        cx, cy = 2 * (left + wide / 2) / CANVAS[1] - 1, 2 * (top + high / 2) / CANVAS[0] - 1
        zero = torch.zeros_like(sx)
        theta = torch.stack((torch.stack((sx * mirror, zero, cx), 1), torch.stack((zero, sy, cy), 1)), 1)
        grid = F.affine_grid(theta, (count, 3, side, side), align_corners=False)
        low = torch.stack((torch.full_like(sx, -1.), torch.full_like(sx, -1.)), 1)
        most = 2 * (size - .5) / torch.tensor([CANVAS[1], CANVAS[0]], device=device) - 1
        grid = torch.maximum(torch.minimum(grid, most.view(count, 1, 1, 2)), low.view(count, 1, 1, 2))
        image = F.grid_sample(self.pictures[index].float() / 255, grid, padding_mode='border', align_corners=False)
        boxes, categories = self.boxes[index][:, :, 1:], self.boxes[index][:, :, 0].long()
        x = (boxes[:, :, 0::2] - left.view(-1, 1, 1)) * side / wide.view(-1, 1, 1)
        x = torch.where((mirror < 0).view(-1, 1, 1), side - x.flip(2), x)
        y = (boxes[:, :, 1::2] - top.view(-1, 1, 1)) * side / high.view(-1, 1, 1)
        whole_area = (x[:, :, 1] - x[:, :, 0]) * (y[:, :, 1] - y[:, :, 0])
        x, y = x.clamp(0, side), y.clamp(0, side)
        area = (x[:, :, 1] - x[:, :, 0]) * (y[:, :, 1] - y[:, :, 0])
        boxes = torch.stack((x[:, :, 0], y[:, :, 0], x[:, :, 1], y[:, :, 1]), 2)
        there, neither = categories > 0, self.hardly(boxes, area / whole_area.clamp(min=1))
        categories = torch.where(there & neither, torch.full_like(categories, -1), categories)
        # Pieces before it, the last in front.
        placed, hidden = [], torch.zeros(count, side, side, device=device)
        for _ in range(PIECES):
            used = chance(.55) & (real | chance(.25))
            k = whole(len(self.pieces))
            own = self.piece_sizes[k]
            longer = uniform(math.log(36), math.log(.85 * side)).exp()
            scale = longer / own.max(1).values
            turn, squeeze = torch.randn(count, generator=generator, device=device) * .08, torch.randn(count, generator=generator, device=device).mul(.12).exp()
            wide, high = own[:, 0] * scale * squeeze, own[:, 1] * scale / squeeze
            cx, cy = uniform(-.05, 1.05) * side, uniform(0, 1.1) * side
            flip = torch.where(chance(.5), -1., 1.)
            # Output pixel -> piece: p = R (o - c) / size * own.
            c, s = turn.cos(), turn.sin()
            a = side / 2 * own[:, 0] / wide / (PIECE / 2)
            b = side / 2 * own[:, 1] / high / (PIECE / 2)
            ox, oy = 2 * cx / side - 1, 2 * cy / side - 1
            mx, my = own[:, 0] / PIECE - 1, own[:, 1] / PIECE - 1  # the piece's middle on its canvas
            theta = torch.stack((torch.stack((flip * a * c, flip * a * s, mx - flip * a * (c * ox + s * oy)), 1),
                                 torch.stack((-b * s, b * c, my - b * (-s * ox + c * oy)), 1)), 1)
            piece = F.grid_sample(self.pieces[k].float() / 255, F.affine_grid(theta, (count, 4, side, side), align_corners=False), align_corners=False)
            alpha = piece[:, 3] * used.view(-1, 1, 1)
            light = uniform(.6, 1.35).view(-1, 1, 1, 1) * uniform(.85, 1.15, count, 3, 1, 1)
            image = image * (1 - alpha[:, None]) + (piece[:, :3] * light).clamp(max=1) * used.view(-1, 1, 1, 1)
            placed = [(mask & (alpha < .5), *rest) for mask, *rest in placed]
            placed.append((alpha > .5, self.piece_categories[k], wide * high * self.piece_fill[k], used))
            hidden = hidden * (1 - alpha) + alpha
        # What pieces hide of the scene's objects.
        table = F.pad(hidden.cumsum(1).cumsum(2), (1, 0, 1, 0)).flatten(1)
        at = boxes.round().long().clamp(0, side)

        def corner(column, row):
            return table.gather(1, row * (side + 1) + column)
        covered = corner(at[:, :, 2], at[:, :, 3]) - corner(at[:, :, 0], at[:, :, 3]) - corner(at[:, :, 2], at[:, :, 1]) + corner(at[:, :, 0], at[:, :, 1])
        share = covered / ((at[:, :, 2] - at[:, :, 0]) * (at[:, :, 3] - at[:, :, 1])).clamp(min=1)
        categories = torch.where((categories > 0) & (share > .35), torch.full_like(categories, -1), categories)
        for mask, kind, full, used in placed:
            columns, rows = mask.any(1), mask.any(2)
            number = torch.arange(side, device=device)
            box = torch.stack((torch.where(columns, number, side).min(1).values, torch.where(rows, number, side).min(1).values,
                               torch.where(columns, number + 1, 0).max(1).values, torch.where(rows, number + 1, 0).max(1).values), 1).float()
            seen = mask.sum((1, 2))
            bad = self.hardly(box[:, None], (seen / full.clamp(min=1))[:, None])[:, 0]
            kind = torch.where(bad & (kind > 0), torch.full_like(kind, -1), kind) * (used & (seen > 0))
            boxes, categories = torch.cat((boxes, box[:, None]), 1), torch.cat((categories, kind[:, None]), 1)
        return self.light(image, generator), boxes, categories, real

    @staticmethod
    def hardly(boxes, share):
        """Too little of it to be asked for."""
        return (share < VISIBLE) | (boxes[:, :, 2] - boxes[:, :, 0] < LEAST) | (boxes[:, :, 3] - boxes[:, :, 1] < LEAST)

    def light(self, image, generator):
        """Exposure, contrast, tint, grey, blur of focus or of motion, noise."""
        count, device = len(image), self.device

        def uniform(low, high, *shape):
            return torch.rand(shape, generator=generator, device=device) * (high - low) + low
        one = (count, 1, 1, 1)
        blurred = max(1, count // 3)
        kernels = self.kernels(blurred, generator)
        part = image[:blurred].reshape(1, blurred * 3, *image.shape[2:])
        size = kernels.shape[-1]
        part = F.conv2d(F.pad(part, [size // 2] * 4, mode='reflect'), kernels.repeat_interleave(3, 0)[:, None], groups=blurred * 3)
        image = torch.cat((part.view(blurred, 3, *image.shape[2:]), image[blurred:]))
        mean = image.mean((2, 3), keepdim=True)
        varied = (torch.rand(one, generator=generator, device=device) < .8).float()
        contrast, exposure = 1 + varied * (uniform(.5, 1.3, *one) - 1), 1 + varied * (uniform(.55, 1.5, *one) - 1)
        tint = 1 + varied * (uniform(.85, 1.15, count, 3, 1, 1) - 1)
        image = (image - mean) * contrast + mean * exposure * tint
        grey = image.mean(1, keepdim=True)
        image = torch.where(torch.rand(one, generator=generator, device=device) < .2, grey + (image - grey) * uniform(0, 1, *one), image)
        noise = uniform(0, .045, *one) * (torch.rand(one, generator=generator, device=device) < .6)
        return (image + noise * torch.randn(image.shape, generator=generator, device=device)).clamp(0, 1)

    def kernels(self, count, generator):
        """count x 11 x 11: half Gaussians of .4 to 2 px, half lines of 3 to 10 px."""
        device = self.device
        at = torch.arange(-5, 6, device=device).float()
        y, x = torch.meshgrid(at, at, indexing='ij')
        sigma = torch.rand((count, 1, 1), generator=generator, device=device) * 1.6 + .4
        round_ = torch.exp(-(x * x + y * y) / (2 * sigma * sigma))
        angle = torch.rand((count, 1, 1), generator=generator, device=device) * math.pi
        half = torch.rand((count, 1, 1), generator=generator, device=device) * 3.5 + 1.5
        along, across = x * angle.cos() + y * angle.sin(), y * angle.cos() - x * angle.sin()
        line = (1 - across.abs()).clamp(min=0) * (along.abs() < half)
        kernel = torch.where(torch.rand((count, 1, 1), generator=generator, device=device) < .5, round_, line)
        return kernel / kernel.sum((1, 2), keepdim=True)
