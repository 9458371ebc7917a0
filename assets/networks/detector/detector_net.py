# SPDX-License-Identifier: Apache-2.0
"""The detector: Faster R-CNN (Ren et al., 2015) on a small residual trunk with a feature pyramid (Lin et al., 2017)."""
from collections import OrderedDict

from torch import nn
from torch.nn import functional as F
from torchvision.models.detection.anchor_utils import AnchorGenerator
from torchvision.models.detection.faster_rcnn import FasterRCNN, FastRCNNPredictor, TwoMLPHead
from torchvision.ops import MultiScaleRoIAlign

CATEGORIES = ['chair', 'dining table', 'couch', 'tv', 'cabinet', 'desk', 'lamp', 'shelf', 'potted plant', 'cup', 'bed', 'refrigerator']
CHANNELS, HIDDEN = 48, 128  # of the pyramid, of the head


def convolution(inputs, outputs, stride=1, size=3):
    return nn.Sequential(nn.Conv2d(inputs, outputs, size, stride, size // 2, bias=False), nn.BatchNorm2d(outputs))


class Residual(nn.Module):
    def __init__(self, inputs, outputs, stride=1):
        super().__init__()
        self.first, self.second = convolution(inputs, outputs, stride), convolution(outputs, outputs)
        self.past = nn.Identity() if stride == 1 and inputs == outputs else convolution(inputs, outputs, stride, 1)

    def forward(self, x):
        return F.relu(self.second(F.relu(self.first(x))) + self.past(x))


class Trunk(nn.Module):
    """Features of stride 8, 16 and 32."""

    def __init__(self):
        super().__init__()
        self.out_channels = CHANNELS
        self.stem = nn.Sequential(convolution(3, 16, 2), nn.ReLU(), convolution(16, 32, 2), nn.ReLU(), Residual(32, 32))
        self.stages = nn.ModuleList([
            nn.Sequential(Residual(32, 64, 2), Residual(64, 64)),
            nn.Sequential(Residual(64, 128, 2), Residual(128, 128), Residual(128, 128)),
            nn.Sequential(Residual(128, 192, 2), Residual(192, 192))])
        self.sides = nn.ModuleList([nn.Conv2d(n, CHANNELS, 1) for n in (64, 128, 192)])
        self.smooth = nn.ModuleList([nn.Conv2d(CHANNELS, CHANNELS, 3, padding=1) for _ in range(3)])

    def forward(self, image):
        x, sides = self.stem(image), []
        for stage, side in zip(self.stages, self.sides):
            x = stage(x)
            sides.append(side(x))
        for level in (1, 0):
            sides[level] = sides[level] + F.interpolate(sides[level + 1], scale_factor=2, mode='nearest')
        return OrderedDict((str(k), smooth(side)) for k, (smooth, side) in enumerate(zip(self.smooth, sides)))


def detector_net():
    anchors = AnchorGenerator(((20, 36), (64, 104), (160, 240)), ((.5, 1., 2.),) * 3)
    pool = MultiScaleRoIAlign(['0', '1', '2'], 7, 2, canonical_scale=112)
    return FasterRCNN(Trunk(), rpn_anchor_generator=anchors, box_roi_pool=pool,
                      box_head=TwoMLPHead(CHANNELS * 7 * 7, HIDDEN), box_predictor=FastRCNNPredictor(HIDDEN, len(CATEGORIES) + 1),
                      min_size=240, max_size=320, rpn_pre_nms_top_n_train=600, rpn_post_nms_top_n_train=250, rpn_pre_nms_top_n_test=200,
                      rpn_post_nms_top_n_test=150, rpn_batch_size_per_image=128, box_batch_size_per_image=64, box_score_thresh=.05)
