#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The particles of an object: where they are, coloured by how well they fit, and which way they face.

particles.py RUN.plb [--object ID] [--frame N] [--out FILE.png]"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import plumbline_run as pr


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('run', type=Path)
    parser.add_argument('--object', type=int, help='else the one with the most modes')
    parser.add_argument('--frame', type=int, help='of the sequence; else the last one used')
    parser.add_argument('--out', type=Path, help='a picture instead of a window')
    arguments = parser.parse_args()
    with pr.Run(arguments.run) as run:
        position = run.last_used() if arguments.frame is None else run.position_of(arguments.frame)
        frame = run.frame(position)
        level = pr.upright_rotation(run.gravity)[:, :2]
    with_particles = [o for o in frame.objects if o.particles is not None]
    if not with_particles:
        raise SystemExit('frame %d has no particles' % frame.frame)
    chosen = frame.object(arguments.object) if arguments.object is not None else \
        max(with_particles, key=lambda o: len(o.modes))
    if chosen.particles is None:
        raise SystemExit('object %d has no particles in frame %d' % (chosen.id, frame.frame))
    particles = chosen.particles
    places = particles.centers @ level
    figure, (above, facing) = plt.subplots(1, 2, figsize=(11, 5), layout='constrained')
    dots = above.scatter(places[:, 0], places[:, 1], c=particles.table['phi_edge'], s=8)
    figure.colorbar(dots, ax=above, label='edge term')
    for mode in chosen.modes:
        place = mode.world_from_object[:3, 3] @ level
        above.plot(*place, 'k+', markersize=12)
        above.annotate('%s %.0f %%' % (mode.model, 100 * mode.weight), place, fontsize=8)
    above.set(aspect='equal', xlabel='x [m]', ylabel='y [m]', title='centres (+: origins of modes)')
    facing.hist(np.degrees(pr.wrap_angle(particles.azimuths)), bins=72, range=(-180, 180),
                weights=particles.weights)
    facing.set(xlabel='azimuth [degrees]', ylabel='weight', title='which way it faces')
    figure.suptitle('%s, frame %d, object %d (%s)' % (arguments.run.name, frame.frame, chosen.id, chosen.model))
    if arguments.out:
        figure.savefig(arguments.out, dpi=120, bbox_inches='tight')
    else:
        plt.show()


if __name__ == '__main__':
    main()
