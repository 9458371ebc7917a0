#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How sure a run became of its objects: spread and probability over the frames.

uncertainty.py RUN.plb [--out FILE.png]"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import plumbline_run as pr


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('run', type=Path)
    parser.add_argument('--out', type=Path, help='a picture instead of a window')
    arguments = parser.parse_args()
    figure, (spread, there) = plt.subplots(2, 1, figsize=(9, 7), sharex=True)
    with pr.Run(arguments.run) as run:
        frames = run.frames().frame
        confirmed = [o.id for o in run.objects(run.last_used(), particles=False) if o.state == 'confirmed']
        for number in confirmed:
            positions, objects = run.history(number)
            # Without particles, over the modes: quick to read.
            deviations = [np.sqrt(np.trace(o.mixture_covariance(run.gravity)[:3, :3])) for o in objects]
            name = '%d %s' % (number, objects[-1].model)
            spread.plot(frames[positions], 100 * np.array(deviations), label=name)
            there.plot(frames[positions], [o.probability for o in objects], label=name)
    spread.set(yscale='log', ylabel='spread [cm]', title=arguments.run.name)
    there.set(xlabel='frame', ylabel='probability that it is there', ylim=(-0.02, 1.02))
    if confirmed:
        spread.legend(fontsize=8)
    if arguments.out:
        figure.savefig(arguments.out, dpi=120, bbox_inches='tight')
    else:
        plt.show()


if __name__ == '__main__':
    main()
