# SPDX-License-Identifier: Apache-2.0
"""Training pictures: images with, for every pixel, how much the annotators agree that an edge is there; crops of them."""
import glob
import math
import os

import numpy as np
import torch
from PIL import Image
from torch.nn import functional as F

FINEST = .8  # the scale below which lines are kept by their maxima, as means would fade them


def near(lines):
    """What lies within 2 px of a line [N x 1 x H x W, 0 or 1]."""
    disc = torch.ones(5, 5)
    disc[[0, 0, 0, 0, 4, 4, 4, 4], [0, 1, 3, 4, 0, 1, 3, 4]] = 0
    return (F.conv2d(lines, disc[None, None], padding=2) > 0).float()


def bsds(folder, split):
    """(image [3 x H x W, BGR, 0 to 255], agreement [1 x H x W]) of BSDS500, portraits turned by a quarter: of all annotators'
    lines, by how many share them within 2 px."""
    for file in sorted(glob.glob(os.path.join(folder, 'images', split, '*.jpg'))):
        name = os.path.basename(file)[:-4]
        truths = sorted(glob.glob(os.path.join(folder, 'gt', split, name + '_*.png')))
        if not truths:
            raise SystemExit('%s has no annotations in gt/%s' % (file, split))
        image = torch.from_numpy(np.asarray(Image.open(file).convert('RGB')).astype(np.float32)).permute(2, 0, 1).flip(0)
        lines = torch.from_numpy(np.stack([np.asarray(Image.open(f).convert('L')) > 0 for f in truths])).float()[:, None]
        share = near(lines).mean(0) * lines.amax(0)
        agreement = F.max_pool2d(share, 3, 1, 1)
        if image.shape[1] > image.shape[2]:
            image, agreement = image.rot90(1, (1, 2)), agreement.rot90(1, (1, 2))
        yield image, agreement


class Crops:
    """All pictures, of one size, on the device; squares of them turned, scaled, mirrored, and in other light."""

    def __init__(self, pictures, device):
        if len({image.shape for image, _ in pictures}) != 1:
            raise SystemExit('the pictures have not one size (portraits are turned by a quarter)')
        self.pictures = torch.stack([torch.cat(pair) for pair in pictures]).to(device)

    def batch(self, generator, count, size, scales):
        """(images [N x 3 x size x size, BGR, 0 to 255], agreements [N x 1 x size x size])."""
        device = self.pictures.device

        def uniform(low, high, *shape):
            return torch.rand(shape or (count,), generator=generator, device=device) * (high - low) + low

        def chance(share):
            return uniform(0, 1) < share

        which = uniform(0, len(self.pictures)).long()
        pictures = self.pictures[which]
        h, w = pictures.shape[2:]
        quarter = uniform(0, 4).long() * (math.pi / 2)
        angle = torch.where(chance(.7), uniform(-math.pi, math.pi), quarter)
        scale = uniform(math.log(scales[0]), math.log(scales[1])).exp()
        mirror = torch.where(chance(.5), -1., 1.)
        half = size / 2 / scale
        center = [half.clamp(max=n / 2) + uniform(0, 1) * (n - 2 * half.clamp(max=n / 2)) for n in (w, h)]
        # From the crop, at twice its size, to the picture; both in units of half their extent, as grid_sample wants it.
        cos, sin = angle.cos() * half, angle.sin() * half
        turn = torch.stack([torch.stack([mirror * cos * 2 / w, -sin * 2 / w, center[0] * 2 / w - 1], 1),
                            torch.stack([mirror * sin * 2 / h, cos * 2 / h, center[1] * 2 / h - 1], 1)], 1)
        grid = F.affine_grid(turn, (count, 4, 2 * size, 2 * size), align_corners=False)
        fine = F.grid_sample(pictures, grid, mode='bilinear', padding_mode='reflection', align_corners=False)
        small = F.avg_pool2d(fine, 2)
        lines = torch.where((scale < FINEST)[:, None, None, None], F.max_pool2d(fine[:, 3:], 2), small[:, 3:])
        image = small[:, :3]

        def each(*values):
            return [value[:, None, None, None] for value in values]

        varied, greyed, blurred, noisy = each(chance(.6), chance(.3), chance(.3), chance(.4))
        mean = image.mean((2, 3), keepdim=True)
        contrast, light, colour, sigma, noise = each(
            uniform(.6, 1.3), uniform(.6, 1.4), uniform(0, 1), uniform(.5, 1.2), uniform(1, 6))
        tint = torch.randn((count, 3, 1, 1), generator=generator, device=device) * 8
        other = (image - mean) * contrast + mean * light + tint
        grey = other.mean(1, keepdim=True)
        other = torch.where(greyed, grey + (other - grey) * colour, other)
        image = torch.where(varied, other, image)
        taps = torch.arange(-4, 5, device=device)[None, :].float()
        bell = (-.5 * (taps / sigma[:, :, 0, 0]) ** 2).exp()
        bell = (bell / bell.sum(1, keepdim=True)).repeat_interleave(3, 0)[:, None, None]
        soft = F.pad(image.reshape(1, 3 * count, size, size), (4, 4, 4, 4), mode='reflect')
        soft = F.conv2d(F.conv2d(soft, bell, groups=3 * count), bell.transpose(2, 3), groups=3 * count)
        image = torch.where(blurred, soft.reshape(count, 3, size, size), image)
        grain = torch.randn(image.shape, generator=generator, device=device)
        image = torch.where(noisy, image + noise * grain, image)
        return image.clamp(0, 255), lines
