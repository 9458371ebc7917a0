#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Turns torchvision's Faster R-CNN into the two networks and the sidecar that Plumbline's two-stage detector reads.

  export_torchvision.py OUT.onnx --model fasterrcnn_mobilenet_v3_large_320_fpn --weights state_dict.pt [--classes names.txt]
                        [--size 448x320]
  export_torchvision.py OUT.onnx --model fasterrcnn_resnet50_fpn --random 1

Writes OUT.onnx (image -> one tensor a level: features, then objectness, then box deltas, along the channels), OUT.head.onnx
(N crops of C x 7 x 7 -> N x 5K: K class logits, then 4 box deltas a class) and OUT.json. docs/algorithms/two_stage.md has the
rest. Weights are a file that torch.load reads: torchvision's own, or of a model of the same form with as many classes as
--classes names (one a line, without the background). Other Faster R-CNNs: import this file and call export(model, ...).
Needs python3-torch and python3-torchvision; downloads nothing.
"""
import argparse
import json
import math
import pathlib
import warnings

import torch
from torch import nn
from torch.nn import functional as F
import torchvision
from torchvision.models import detection
from torchvision.models.detection.anchor_utils import AnchorGenerator
from torchvision.models.detection.backbone_utils import BackboneWithFPN
from torchvision.models.detection.faster_rcnn import FasterRCNN, FastRCNNPredictor, TwoMLPHead

# Boxes of one pass of the head. OpenCV multiplies whole blocks of 32.
BATCH = 128
MAX_PIXEL = 255


def mobilenet_light_320(num_classes, channels=32, hidden=128):
    """Mobilenet v3 as in torchvision's 320, but from stride 16 on, with few channels and a small head: 0.5 MFLOP a box."""
    features = torchvision.models.mobilenet_v3_large(weights=None).features
    taken = {'12': '0', '16': '1'}
    anchors = AnchorGenerator(((32, 64, 128, 256, 512),) * 3, ((.5, 1., 2.),) * 3)
    backbone = BackboneWithFPN(features, taken, [features[int(i)].out_channels for i in taken], channels)
    return FasterRCNN(backbone, rpn_anchor_generator=anchors, min_size=320, max_size=640, rpn_pre_nms_top_n_test=150,
                      rpn_post_nms_top_n_test=150, rpn_score_thresh=.05,
                      box_head=TwoMLPHead(channels * 7 * 7, hidden), box_predictor=FastRCNNPredictor(hidden, num_classes))


def torchvisions(name):
    return lambda num_classes: getattr(detection, name)(weights=None, weights_backbone=None, num_classes=num_classes)


MODELS = {name: torchvisions(name) for name in (
    'fasterrcnn_mobilenet_v3_large_320_fpn', 'fasterrcnn_mobilenet_v3_large_fpn', 'fasterrcnn_resnet50_fpn',
    'fasterrcnn_resnet50_fpn_v2')}
MODELS['mobilenet_light_320'] = mobilenet_light_320


class Trunk(nn.Module):
    """A normalised image -> for each level: features, objectness, deltas."""

    def __init__(self, model):
        super().__init__()
        self.backbone, self.rpn_head = model.backbone, model.rpn.head

    def forward(self, image):
        levels = list(self.backbone(image).values())
        objectness, deltas = self.rpn_head(levels)
        return tuple(torch.cat(parts, 1) for parts in zip(levels, objectness, deltas))


class Head(nn.Module):
    """Crops -> class logits and deltas. Layers that connect all with all become convolutions of 1 x 1 over the boxes: OpenCV
    multiplies those matrix by matrix, but inner products box by box, which reads all weights again for each box. Heads that
    begin with such a layer take a crop as a column, 1 x 49C x N x 1 (OpenCV's own transposition is slow)."""

    def __init__(self, model):
        super().__init__()
        heads = model.roi_heads
        layers = [heads.box_head.fc6, nn.ReLU(), heads.box_head.fc7, nn.ReLU()] \
            if isinstance(heads.box_head, TwoMLPHead) else list(heads.box_head)
        first = next(i for i, layer in enumerate(layers) if isinstance(layer, nn.Linear))
        self.front = nn.Sequential(*[layer for layer in layers[:first] if not isinstance(layer, nn.Flatten)])
        self.takes_columns = len(self.front) == 0
        self.inputs = layers[first].in_features
        self.back = nn.Sequential(*[over_boxes(layer) for layer in layers[first:]])
        predictor = heads.box_predictor
        both = nn.Linear(predictor.cls_score.in_features,
                         predictor.cls_score.out_features + predictor.bbox_pred.out_features)
        both.weight.data = torch.cat((predictor.cls_score.weight, predictor.bbox_pred.weight))
        both.bias.data = torch.cat((predictor.cls_score.bias, predictor.bbox_pred.bias))
        self.last = over_boxes(both)

    def forward(self, crops):
        if not self.takes_columns:
            crops = self.front(crops).reshape(-1, self.inputs).transpose(0, 1).reshape(1, self.inputs, -1, 1)
        result = self.last(self.back(crops))
        return result.reshape(self.last.out_channels, -1).transpose(0, 1)


def over_boxes(layer):
    if not isinstance(layer, nn.Linear):
        return layer
    convolution = nn.Conv2d(layer.in_features, layer.out_features, 1)
    convolution.weight.data = layer.weight.data[:, :, None, None].clone()
    convolution.bias.data = layer.bias.data.clone()
    return convolution


def random_picture(width, height):
    """Blobs, rectangles and noise in 8 bits: something at every scale, so that no channel sees only nothing."""
    picture = F.interpolate(torch.rand(1, 3, height // 20, width // 20), (height, width), mode='bilinear',
                            align_corners=False)[0]
    for _ in range(40):
        x, y = int(torch.randint(width - 10, ())), int(torch.randint(height - 10, ()))
        right, bottom = x + int(torch.randint(10, 120, ())), y + int(torch.randint(10, 120, ()))
        picture[:, y:bottom, x:right] = torch.rand(3, 1, 1)
    return ((picture + .05 * torch.randn_like(picture)).clamp(0, 1) * MAX_PIXEL).round().to(torch.uint8)


@torch.no_grad()
def scale_outputs(layer, outputs, spread):
    """Scales a layer that gave `outputs`, each with its channels second, so that they vary by `spread` around about 0."""
    flat = torch.cat([output.transpose(0, 1).flatten(1) for output in outputs], 1)
    factor = spread / flat.std(1).mean()
    mean = flat.mean(1) - layer.bias
    layer.weight *= factor
    layer.bias.copy_(torch.randn_like(mean) * .1 * spread - mean * factor)


@torch.no_grad()
def fill_at_random(model, seed, size):
    """Weights under which scores differ and boxes move: normalisations fit what they see, outputs have a sensible spread."""
    torch.manual_seed(seed)
    width, height = size
    for name, parameter in model.named_parameters():
        if parameter.dim() > 1:
            nn.init.kaiming_normal_(parameter, nonlinearity='relu')
        elif name.endswith('bias'):
            nn.init.normal_(parameter, std=.1)
    pictures = [random_picture(width, height).float() / MAX_PIXEL for _ in range(2)]
    norms = [m for m in model.modules() if isinstance(m, nn.BatchNorm2d)]
    for norm in norms:
        norm.momentum = None  # the mean over all that is seen
        norm.weight.uniform_(.8, 1.2)
    model.eval().transform.fixed_size = size  # for now: the pictures are of the right size
    images, _ = model.transform(pictures)
    for norm in norms:
        norm.train()
    model.backbone(images.tensors)
    model.eval()
    heads, rpn = model.roi_heads, model.rpn.head

    # Objectness far from where a probability is 1 in 32 bits, beyond which all are equal.
    spreads = ((rpn.cls_logits, .4), (rpn.bbox_pred, .2), (heads.box_predictor.cls_score, 3.),
               (heads.box_predictor.bbox_pred, 1.))
    for layer, spread in spreads:
        outputs = []
        hook = layer.register_forward_hook(lambda _, __, output, seen=outputs: seen.append(output))
        model(pictures[:1])
        hook.remove()
        scale_outputs(layer, outputs, spread)
    model.transform.fixed_size = None


def level_strides(model, size):
    """Of all levels, and how many of them crops are taken from."""
    width, height = size
    levels = model.backbone(torch.zeros(1, 3, height, width))
    strides = [width // level.shape[3] for level in levels.values()]
    for level, stride in zip(levels.values(), strides):
        if height // level.shape[2] != stride:
            raise SystemExit(f'a level of {level.shape[3]}x{level.shape[2]} does not divide {width}x{height} evenly; '
                             'give a --size that is a multiple of the largest stride')
    taken = [name for name in levels if name in model.roi_heads.box_roi_pool.featmap_names]
    if taken != list(levels)[:len(taken)]:
        raise SystemExit('crops must be taken from the first levels')
    return strides, len(taken)


def sidecar_of(model, size, names):
    strides, taken = level_strides(model, size)
    rpn, heads, transform = model.rpn, model.roi_heads, model.transform
    pool, generator = heads.box_roi_pool, rpn.anchor_generator
    return {
        'kind': 'two_stage', 'width': size[0], 'height': size[1], 'resize': 'letterbox', 'swap_rb': True,
        'mean': [MAX_PIXEL * v for v in transform.image_mean], 'std': [MAX_PIXEL * v for v in transform.image_std],
        'scale': 1, 'strides': strides,
        'anchors': [{'sizes': list(s), 'ratios': list(r)} for s, r in zip(generator.sizes, generator.aspect_ratios)],
        'rpn': {'before_nms': rpn._pre_nms_top_n['testing'], 'after_nms': rpn._post_nms_top_n['testing'],
                'nms_iou': rpn.nms_thresh, 'min_score': rpn.score_thresh, 'weights': list(rpn.box_coder.weights)},
        'crops': {'size': pool.output_size[0], 'sampling': max(0, pool.sampling_ratio), 'levels': taken,
                  'columns': Head(model).takes_columns, 'canonical_scale': pool.canonical_scale, 'canonical_level': pool.canonical_level},
        'boxes': {'weights': list(heads.box_coder.weights), 'most': heads.detections_per_img},
        'categories': names}


def write_onnx(module, example, file, inputs, outputs):
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        torch.onnx.export(module.eval(), example, str(file), opset_version=11, input_names=inputs, output_names=outputs,
                          do_constant_folding=True)


@torch.no_grad()
def export(model, out, size, names):
    """Writes the three files of `model`, a FasterRCNN, for images fitted into `size` (width, height)."""
    model.eval()
    out = pathlib.Path(out)
    width, height = size
    sidecar = sidecar_of(model, size, names)
    write_onnx(Trunk(model), torch.zeros(1, 3, height, width), out, ['image'],
               [f'level{i}' for i in range(len(sidecar['strides']))])
    head, side = Head(model), sidecar['crops']['size']
    crops = torch.zeros((1, head.inputs, BATCH, 1) if head.takes_columns
                        else (BATCH, model.backbone.out_channels, side, side))
    write_onnx(head, crops, out.with_suffix('.head.onnx'), ['crops'], ['boxes'])
    out.with_suffix('.json').write_text(json.dumps(sidecar, indent=1) + '\n')


def usual_size(model):
    """What torchvision makes of an image of 640x480."""
    transform = model.transform
    scale = min(transform.min_size[-1] / 480, transform.max_size / 640)
    divisor = max(64, transform.size_divisible)
    return tuple(math.ceil(math.floor(length * scale) / divisor) * divisor for length in (640, 480))


def class_names(file):
    if file:
        return [line.strip() for line in pathlib.Path(file).read_text().splitlines() if line.strip()]
    coco = detection.FasterRCNN_ResNet50_FPN_Weights.COCO_V1.meta['categories']
    # Numbers that COCO does not use: names of their own, since boxes of one name suppress one another.
    return [f'unused {i}' if name == 'N/A' else name.lower() for i, name in enumerate(coco) if i > 0]


def load_weights(model, file, what):
    try:
        weights = torch.load(file, map_location='cpu')
    except Exception as error:  # torch raises many kinds
        raise SystemExit(f"'{file}' is no state dict that torch can read: {error}") from None
    try:
        missing, unknown = model.load_state_dict(weights, strict=False)
    except (RuntimeError, TypeError) as error:
        raise SystemExit(f"'{file}' does not fit {what} (--model, --classes): {str(error).splitlines()[-1].strip()}") from None
    missing = [name for name in missing if not name.endswith('num_batches_tracked')]
    if missing or unknown:
        raise SystemExit(f"'{file}' does not fit {what} (--model): it lacks {missing[:3]} and has {unknown[:3]} too many")


def build(arguments):
    """The model with its weights, the size of its input and its names."""
    names = class_names(arguments.classes)
    model = MODELS[arguments.model](len(names) + 1)
    if arguments.batch_norm_eps is not None:
        for module in model.modules():
            if isinstance(module, nn.BatchNorm2d):
                module.eps = arguments.batch_norm_eps
    size = tuple(int(n) for n in arguments.size.split('x')) if arguments.size else usual_size(model)
    if arguments.weights:
        load_weights(model, arguments.weights, f'{arguments.model} of {len(names)} classes')
    else:
        fill_at_random(model, arguments.random, size)
    return model.eval(), size, names


def options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('out', help='OUT.onnx; OUT.head.onnx and OUT.json are written beside it')
    parser.add_argument('--model', choices=sorted(MODELS), default='fasterrcnn_mobilenet_v3_large_320_fpn')
    weights = parser.add_mutually_exclusive_group(required=True)
    weights.add_argument('--weights', help='a state dict')
    weights.add_argument('--random', type=int, metavar='SEED', help='random weights instead, for trials')
    parser.add_argument('--classes', help='names of the classes, one a line, without the background (COCO)')
    parser.add_argument('--size', metavar='WxH', help='of the input, multiples of 64; images are fitted into its upper left '
                        'corner (what torchvision makes of 640x480)')
    parser.add_argument('--batch-norm-eps', type=float, help="0 for torchvision's COCO weights of resnet50_fpn (V1)")
    return parser


def main():
    arguments = options().parse_args()
    if not arguments.out.endswith('.onnx'):
        raise SystemExit('OUT must end in .onnx')
    model, size, names = build(arguments)
    export(model, arguments.out, size, names)
    print(f'{arguments.out}, its head and its sidecar: {size[0]}x{size[1]}, {len(names)} categories')


if __name__ == '__main__':
    main()
