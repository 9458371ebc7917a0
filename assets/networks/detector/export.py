#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes what train.py has learnt as OUT.onnx, its head and its sidecar:  export.py build/networks/detector/weights.pt --out detector.onnx"""
import argparse
import os
import sys

import torch

import detector_net

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
import export_torchvision  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('weights')
    parser.add_argument('--out', required=True)
    parser.add_argument('--size', default='448x336', help="of the network's input")
    args = parser.parse_args()
    net = detector_net.detector_net()
    net.load_state_dict(torch.load(args.weights, map_location='cpu'))
    export_torchvision.export(net.eval(), args.out, tuple(int(v) for v in args.size.split('x')), detector_net.CATEGORIES)


if __name__ == '__main__':
    main()
