# SPDX-License-Identifier: Apache-2.0
"""The edge network: encoder of four levels (1/2 to 1/16) and a decoder that adds, for OpenCV 4.6's importer."""
import torch
from torch import nn
from torch.nn import functional as F

WIDTHS = (16, 32, 64, 96)  # channels at 1/2, 1/4, 1/8, 1/16
MEAN, SCALE = (104.0, 117.0, 123.0), 1 / 58  # of the input, BGR 0..255


def convolution(inputs, outputs, stride=1, dilation=1):
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 3, stride, dilation, dilation, bias=False), nn.BatchNorm2d(outputs), nn.ReLU(True))


class Level(nn.Module):
    """Halves the size, then convolutions of which each adds to what it was given."""

    def __init__(self, inputs, outputs, dilations):
        super().__init__()
        self.down = convolution(inputs, outputs, 2)
        self.more = nn.ModuleList(convolution(outputs, outputs, 1, d) for d in dilations)

    def forward(self, x):
        x = self.down(x)
        for layer in self.more:
            x = x + layer(x)
        return x


class EdgeNet(nn.Module):
    """Log odds of an edge at every pixel; in training also those at 1/2, 1/4 and 1/8.

    Input: N x 3 x H x W, BGR, (value - MEAN) * SCALE, H and W multiples of 16."""

    def __init__(self, width=1.0):
        super().__init__()
        a, b, c, d = (round(width * channels) for channels in WIDTHS)
        self.levels = nn.ModuleList([Level(3, a, (1,)), Level(a, b, (1,)), Level(b, c, (1, 1)), Level(c, d, (1, 2))])
        self.reduce = nn.ModuleList([nn.Conv2d(d, c, 1), nn.Conv2d(c, b, 1), nn.Conv2d(b, a, 1)])
        self.join = nn.ModuleList([convolution(c, c), convolution(b, b), convolution(a, a)])
        self.sides = nn.ModuleList([nn.Conv2d(c, 1, 1), nn.Conv2d(b, 1, 1), nn.Conv2d(a, 1, 1)])
        self.last = nn.ConvTranspose2d(a, 1, 4, 2, 1)

    def forward(self, x):
        seen = []
        for level in self.levels:
            x = level(x)
            seen.append(x)
        sides = []
        for reduce, join, side, lateral in zip(self.reduce, self.join, self.sides, reversed(seen[:-1])):
            x = join(F.interpolate(reduce(x), scale_factor=2.0, mode='bilinear', align_corners=False) + lateral)
            if self.training:
                sides.append(side(x))
        return (self.last(x), sides) if self.training else self.last(x)


class Exported(nn.Module):
    """What the ONNX file holds: the raw score of an edge, in (0, 1)."""

    def __init__(self, net):
        super().__init__()
        self.net = net

    def forward(self, image):
        return torch.sigmoid(self.net(image))


def export(net, file, width=640, height=480):
    net.cpu().eval()
    torch.onnx.export(Exported(net), torch.zeros(1, 3, height, width), file, opset_version=11, input_names=['image'],
                      output_names=['edge'])
