#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes what train.py has learnt as OUT.onnx, its head and its sidecar:  export.py build/networks/detector/weights.pt --out detector.onnx"""
import argparse
import os
import sys

import numpy as np
import onnx
import torch
from onnx import TensorProto, numpy_helper

import detector_net

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
import export_torchvision  # noqa: E402


def halve(file):
    """Numbers of 16 bits: half the size, and no more error than they had."""
    model = onnx.load(file)
    for weight in model.graph.initializer:
        if weight.data_type == TensorProto.FLOAT:
            weight.CopyFrom(numpy_helper.from_array(numpy_helper.to_array(weight).astype(np.float16), weight.name))
    for value in (*model.graph.input, *model.graph.output, *model.graph.value_info):
        if value.type.tensor_type.elem_type == TensorProto.FLOAT:
            value.type.tensor_type.elem_type = TensorProto.FLOAT16
    onnx.checker.check_model(model)
    onnx.save(model, file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('weights')
    parser.add_argument('--out', required=True)
    parser.add_argument('--size', default='448x352', help="of the network's input, multiples of 32")
    parser.add_argument('--half', action='store_true', help='numbers of 16 bits')
    args = parser.parse_args()
    net = detector_net.detector_net()
    net.load_state_dict(torch.load(args.weights, map_location='cpu'))
    export_torchvision.export(net.eval(), args.out, tuple(int(v) for v in args.size.split('x')), detector_net.CATEGORIES)
    if args.half:
        for file in (args.out, os.path.splitext(args.out)[0] + '.head.onnx'):
            halve(file)


if __name__ == '__main__':
    main()
