#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The map at the end of a run, seen from above: boxes of the models, cameras, 95 % ellipses.

map_from_above.py RUN.plb [--models DIR] [--out FILE.png]"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import plumbline_run as pr

T4_95_OF_2 = 6.944  # 95 % of Student's t of four degrees of freedom in the plane: 1 - (1 + x / 2)^-2 = .95


def ellipse(covariance):
    """Points of the 95 % ellipse of a 2x2 covariance."""
    values, axes = np.linalg.eigh(covariance)
    angles = np.linspace(0, 2 * np.pi, 60)
    circle = np.stack([np.cos(angles), np.sin(angles)])
    return (axes @ (np.sqrt(T4_95_OF_2 * np.maximum(values, 0))[:, None] * circle)).T


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('run', type=Path)
    parser.add_argument('--models', type=Path, help='where they are, if they have moved')
    parser.add_argument('--out', type=Path, help='a picture instead of a window')
    arguments = parser.parse_args()
    with pr.Run(arguments.run) as run:
        objects = [o for o in run.objects(run.last_used()) if o.state == 'confirmed']
        _, cameras = run.trajectory()
        models = pr.Models(arguments.models or run.header['recipe']['models'])
        level = pr.upright_rotation(run.gravity)[:, :2]  # two horizontal axes
        gravity = run.gravity
    figure, axes = plt.subplots(figsize=(8, 8))
    path = cameras[:, :3, 3] @ level
    axes.plot(path[:, 0], path[:, 1], color='0.6', label='camera')
    for o in objects:
        model = models[o.model]
        corners = model.corners(o.world_from_object, o.scale) @ level
        outline = corners[[0, 1, 3, 2, 0]]  # of the base
        line, = axes.plot(outline[:, 0], outline[:, 1])
        spread = level.T @ o.mixture_covariance(gravity, model.symmetry_order)[:3, :3] @ level
        around = corners[:8].mean(axis=0) + ellipse(spread)
        axes.plot(around[:, 0], around[:, 1], color=line.get_color(), linestyle=':')
        axes.annotate('%d %s' % (o.id, o.model), corners[:8].mean(axis=0), ha='center', fontsize=8)
    axes.set(aspect='equal', xlabel='x [m]', ylabel='y [m]', title=arguments.run.name)
    axes.legend()
    if arguments.out:
        figure.savefig(arguments.out, dpi=120, bbox_inches='tight')
    else:
        plt.show()


if __name__ == '__main__':
    main()
