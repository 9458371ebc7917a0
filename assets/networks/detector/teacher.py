# SPDX-License-Identifier: Apache-2.0
"""A published detector of COCO, PicoDet-S (PaddleDetection, Apache-2.0), from its ONNX file in torch: what ours learns from."""
import numpy as np
import onnx
import torch
from onnx import numpy_helper
from torch import nn
from torch.nn import functional as F

MEAN, DEVIATION = (123.675, 116.28, 103.53), (58.395, 57.12, 57.375)  # RGB
STRIDES = (8, 16, 32, 64)
CATEGORIES, BINS = 80, 8
COCO = {'chair': 56, 'couch': 57, 'potted plant': 58, 'bed': 59, 'dining table': 60, 'tv': 62, 'cup': 41, 'refrigerator': 72}


def attributes(node):
    return {a.name: onnx.helper.get_attribute_value(a) for a in node.attribute}


class Teacher(nn.Module):
    """Runs the graph's nodes. Any square size whose side is a multiple of 32; features and outputs of strides 8 to 64."""

    def __init__(self, file):
        super().__init__()
        graph = onnx.load(file).graph
        weights = {w.name: numpy_helper.to_array(w) for w in graph.initializer}
        for node in graph.node:
            if node.op_type == 'Constant':
                weights[node.output[0]] = numpy_helper.to_array(attributes(node)['value'])
        self.image = [i.name for i in graph.input if i.name not in weights][0]
        self.nodes = [(n.op_type, list(n.input), list(n.output), attributes(n)) for n in graph.node if n.op_type != 'Constant']
        self.by_output = {o: k for k, n in enumerate(self.nodes) for o in n[2]}
        self.constants = {k: v for k, v in weights.items() if v.dtype != np.float32 or v.ndim < 1 or v.size < 3}
        self.names = {}
        for name, value in weights.items():
            if name not in self.constants:
                self.names[name] = 'w%d' % len(self.names)
                self.register_buffer(self.names[name], torch.from_numpy(value.copy()))
        ends = [n for n in self.nodes if n[0] == 'Split' and self.nodes[self.by_output[n[1][0]]][0] == 'Conv' and self.leads_to(n, 'Sigmoid')]
        self.outputs = [n[1][0] for n in ends][:len(STRIDES)]  # CATEGORIES scores before the sigmoid, then 4 x BINS
        self.features = [self.head_input(o) for o in self.outputs[:3]]

    def leads_to(self, node, kind):
        return any(o in n[1] for n in self.nodes if n[0] == kind for o in node[2])

    def head_input(self, output):
        """Where the head of an output begins: back over four convolutions and what acts on them."""
        seen, name = 0, output
        while True:
            kind, inputs, _, _ = self.nodes[self.by_output[name]]
            seen += kind == 'Conv'
            if kind == 'Conv' and seen == 5:
                return inputs[0]
            name = next(i for i in inputs if i in self.by_output)

    def forward(self, wanted, values):
        """Wanted values of the graph from given ones."""
        values = dict(values)
        for name in wanted:
            self.compute(name, values)
        return [values[name] for name in wanted]

    def tensor(self, name, values):
        if name in self.names:
            return getattr(self, self.names[name])
        return values[name]

    def compute(self, wanted, values):
        stack = [wanted]
        while stack:
            name = stack[-1]
            if name in values:
                stack.pop()
                continue
            kind, inputs, outputs, attribute = self.nodes[self.by_output[name]]
            missing = [i for i in inputs if i and i not in values and i not in self.names and i not in self.constants]
            if missing:
                stack.extend(missing)
                continue
            stack.pop()
            self.run(kind, inputs, outputs, attribute, values)

    def run(self, kind, inputs, outputs, attribute, values):
        def get(k):
            return torch.as_tensor(float(self.constants[inputs[k]].ravel()[0])) if inputs[k] in self.constants else self.tensor(inputs[k], values)

        def scalar(k):
            return float(self.constants[inputs[k]].ravel()[0]) if inputs[k] in self.constants else self.tensor(inputs[k], values)
        if kind == 'Conv':
            pads = attribute.get('pads', [0, 0, 0, 0])
            bias = self.tensor(inputs[2], values) if len(inputs) > 2 else None
            out = F.conv2d(get(0), get(1), bias, attribute.get('strides', [1, 1]), (pads[0], pads[1]), attribute.get('dilations', [1, 1]), attribute.get('group', 1))
        elif kind == 'Mul':
            out = scalar(0) * scalar(1)
        elif kind == 'Add':
            out = scalar(0) + scalar(1)
        elif kind == 'Div':
            out = scalar(0) / scalar(1)
        elif kind == 'Clip':
            out = get(0).clamp(attribute['min'], attribute['max'])
        elif kind == 'Concat':
            out = torch.cat([get(k) for k in range(len(inputs))], attribute['axis'])
        elif kind == 'Relu':
            out = get(0).relu()
        elif kind == 'HardSigmoid':
            out = (get(0) * attribute.get('alpha', .2) + attribute.get('beta', .5)).clamp(0, 1)
        elif kind == 'Sigmoid':
            out = get(0).sigmoid()
        elif kind == 'GlobalAveragePool':
            out = get(0).mean((2, 3), keepdim=True)
        elif kind == 'MaxPool':
            pads = attribute.get('pads', [0, 0, 0, 0])
            out = F.max_pool2d(get(0), attribute['kernel_shape'], attribute['strides'], (pads[0], pads[1]))
        elif kind == 'Resize':
            out = F.interpolate(get(0), scale_factor=2, mode='nearest' if b'nearest' in attribute.get('mode', b'nearest') else 'bilinear')
        elif kind == 'Split':
            parts = torch.split(get(0), attribute['split'], attribute['axis'])
            for name, part in zip(outputs, parts):
                values[name] = part
            return
        elif kind == 'Reshape':  # of shuffled channels: its sizes are those of one image of 416 px
            x, shape = get(0), self.constants[inputs[1]] if inputs[1] in self.constants else self.tensor(inputs[1], values)
            n, h, w = len(x), x.shape[-2], x.shape[-1]
            out = x.reshape(n, int(shape[1]), -1, h, w) if len(shape) == 5 else x.reshape(n, -1, h, w)
        elif kind == 'Transpose':
            out = get(0).permute(*attribute['perm'])
        else:
            raise SystemExit("the teacher's file has a node '%s', which teacher.py does not know" % kind)
        values[outputs[0]] = out


def prepared(image):
    """From RGB 0 .. 1."""
    mean = torch.tensor(MEAN, device=image.device).view(1, 3, 1, 1)
    return (image * 255 - mean) / torch.tensor(DEVIATION, device=image.device).view(1, 3, 1, 1)


def boxes_of(output, stride):
    """Scores (N x CATEGORIES x h x w) and corners (N x 4 x h x w, pixels of the input) of one level."""
    n, _, h, w = output.shape
    distance = output[:, CATEGORIES:].float().view(n, 4, BINS, h, w).softmax(2)
    distance = (distance * torch.arange(BINS, device=output.device).view(1, 1, BINS, 1, 1)).sum(2) * stride
    x = (torch.arange(w, device=output.device) + .5) * stride
    y = (torch.arange(h, device=output.device) + .5).view(-1, 1) * stride
    corners = torch.stack((x - distance[:, 0], y - distance[:, 1], x + distance[:, 2], y + distance[:, 3]), 1)
    return output[:, :CATEGORIES].float().sigmoid(), corners
