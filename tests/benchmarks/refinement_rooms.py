#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Refines objects of drawn rooms by scan, by images and together, where scan and cameras err.

  refinement_rooms.py PROGRAM OUT ROOM... [--above METRES]

ROOM is a folder that `plumbline synth` wrote, OUT is filled. The scan becomes 200 000 points with
3 mm of noise and smooth waves of 2 mm along each axis; `--above` keeps only what is higher, and the
floor. All cameras are shifted by 7 mm along each axis (standard deviation) and wave by 7 mm
(amplitude). Objects start up to 2.5 cm and 3 degrees off. The room's name seeds the random numbers.
"""
import argparse
import json
import math
import pathlib
import shutil
import subprocess

import numpy as np


def read_points(file):
    with open(file, 'rb') as f:
        head = []
        while not head or head[-1] != 'end_header':
            head.append(f.readline().decode().strip())
        count = next(int(line.split()[2]) for line in head if line.startswith('element vertex'))
        types, in_vertex = [], False
        for line in head:
            if line.startswith('element'):
                in_vertex = 'vertex' in line
            elif line.startswith('property') and in_vertex:
                kind, name = line.split()[1:]
                types.append((name, {'float': '<f4', 'uchar': 'u1', 'double': '<f8', 'int': '<i4'}[kind]))
        kind = np.dtype(types)
        data = np.frombuffer(f.read(count * kind.itemsize), kind, count=count)
    return np.stack([data[axis] for axis in 'xyz'], 1).astype(float)


def write_scan(file, points, above_m, rng):
    if above_m is not None:
        points = points[(points[:, 2] > above_m) | (points[:, 2] < 0.02)]
    points = points[rng.permutation(len(points))[:200000]]
    phase, wave = rng.uniform(0, 2 * math.pi, (3, 4)), rng.uniform(2, 6, (3, 4, 3))
    bend = np.stack([sum(0.0015 * np.sin(points @ wave[axis, k] + phase[axis, k]) for k in range(4))
                     for axis in range(3)], 1)
    points = points + bend + rng.normal(0, 0.003, points.shape)
    with open(file, 'wb') as f:
        f.write(('ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\n'
                 'property float y\nproperty float z\nend_header\n' % len(points)).encode())
        f.write(points.astype('<f4').tobytes())


def write_cameras(source, target, rng):
    rows = [line.split() for line in open(source) if line.strip() and line[0] != '#']
    time, shift = np.arange(len(rows)), rng.normal(0, 0.007, 3)
    wave = np.stack([0.007 * np.sin(2 * math.pi * time / len(rows) * rng.uniform(0.5, 1.5)
                                    + rng.uniform(0, 2 * math.pi)) for _ in range(3)], 1)
    with open(target, 'w') as f:
        for i, row in enumerate(rows):
            place = np.array([float(x) for x in row[1:4]]) + shift + wave[i]
            f.write(' '.join([row[0]] + ['%.6f' % x for x in place] + row[4:]) + '\n')


def moved(instance, rng):
    pose, turn = np.array(instance['world_from_object']), math.radians(rng.uniform(-3, 3))
    c, s = math.cos(turn), math.sin(turn)
    pose[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ pose[:3, :3]
    pose[:3, 3] += [*rng.uniform(-0.025, 0.025, 2), rng.uniform(-0.01, 0.01)]
    return dict(instance, world_from_object=pose.tolist())


def errors(result, truth):
    """Centimetres, degrees about up, and the standard deviation of the place [cm]."""
    pose, covariance = np.array(result['scan_from_object']), np.array(result['covariance'])
    turn = truth[:3, :3].T @ pose[:3, :3]
    return (100 * np.linalg.norm(pose[:3, 3] - truth[:3, 3]),
            abs(math.degrees(math.atan2(turn[1, 0], turn[0, 0]))),
            100 * math.sqrt(np.trace(covariance[:3, :3])))


def refine_room(program, room, folder, above_m):
    rng = np.random.default_rng(int.from_bytes(room.name.encode()[-7:], 'big'))
    shutil.rmtree(folder, ignore_errors=True)
    (folder / 'sequence').mkdir(parents=True)
    truth = json.loads((room / 'ground_truth.json').read_text())
    write_scan(folder / 'scan.ply', read_points(room / 'scene.ply'), above_m, rng)
    for part in room.iterdir():
        if part.name != 'trajectory.txt':
            (folder / 'sequence' / part.name).symlink_to(part)
    write_cameras(room / 'trajectory.txt', folder / 'sequence' / 'trajectory.txt', rng)
    start = dict(truth, instances=[moved(instance, rng) for instance in truth['instances']])
    (folder / 'start.json').write_text(json.dumps(start))
    (folder / 'inputs.json').write_text(json.dumps(
        [{'edit': 'inputs', 'scan': 'scan.ply', 'models': str(room / 'models'), 'sequence': 'sequence'}]))
    project = str(folder / 'project.json')
    for arguments in (['apply', project, str(folder / 'inputs.json'), '--create'],
                      ['import', project, '--format', 'ground_truth', '--from', str(folder / 'start.json')],
                      ['refine', project, '--json', str(folder / 'refined.json')]):
        subprocess.run([program, 'annotate', *arguments], check=True, stdout=subprocess.DEVNULL)
    places = {i['id']: np.array(i['world_from_object']) for i in truth['instances']}
    for result in json.loads((folder / 'refined.json').read_text()):
        if 'problem' in result:
            print(room.name, result['id'], result['problem'])
            continue
        by = {name: result if result['by'] == name else result.get('by_' + name)
              for name in ('scan', 'images', 'both')}
        found = {name: errors(value, places[result['id']]) for name, value in by.items() if value}
        print('%-16s %-18s %-6s' % (room.name, result['id'], result['by']),
              '  '.join('%s %.2f cm %.2f deg (sigma %.2f)' % (name, *e) for name, e in found.items()))
        yield found, result['by']


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('program')
    parser.add_argument('out', type=pathlib.Path)
    parser.add_argument('rooms', nargs='+', type=pathlib.Path)
    parser.add_argument('--above', type=float)
    arguments = parser.parse_args()
    rows = []
    for room in arguments.rooms:
        out = arguments.out.resolve() / room.name
        rows += refine_room(arguments.program, room.resolve(), out, arguments.above)
    complete = [(found, by) for found, by in rows if len(found) == 3]
    if not complete:
        raise SystemExit('refinement_rooms: no object has results by scan and by images')
    print('%d of %d objects have both results' % (len(complete), len(rows)))
    for name in ('scan', 'images', 'both', 'proposed'):
        e = np.array([found[by if name == 'proposed' else name] for found, by in complete])
        print('%-9s median %.2f cm, 90 %% %.2f; median %.2f deg, 90 %% %.2f; error / sigma, rms %.2f' %
              (name, np.median(e[:, 0]), np.quantile(e[:, 0], 0.9), np.median(e[:, 1]),
               np.quantile(e[:, 1], 0.9), math.sqrt(np.mean((e[:, 0] / e[:, 2])**2))))


main()
