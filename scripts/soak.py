#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Maps hours of a recording by the clock, in processes, and watches their memory.

  scripts/soak.py build/bin/plumbline SEQUENCE [--hours 8 | --own-poses] [--speed 20] [--kill-every 60] [--deaf] [--out DIR] [-- OPTIONS OF UP]

The recording is SEQUENCE (with poses) played to its end and back again and again, ten frames a second: files linked under many
names. With --own-poses SEQUENCE is played once, as long as it is, and its poses are found from its images and IMU by a node. One of the nodes, by turns, is killed every --kill-every seconds (0: none). --deaf adds somebody who asks the mapper for its newest map
again and again and never reads an answer (needs python3-zmq and protoc). Every ten seconds the nodes are asked for their memory.
"""
import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

RATE_HZ = 10


def link_frames(source, target, frames):
    """All that a frame has, under the number of each of `frames` frames."""
    with open(os.path.join(source, 'trajectory.txt')) as text:
        poses = [line.split()[1:] for line in text if line.strip() and not line.startswith('#')]
    there_and_back = list(range(len(poses))) + list(range(len(poses) - 2, 0, -1))
    for part in ('color', 'edges', 'proposals'):
        if not os.path.isdir(os.path.join(source, part)):
            continue
        files = {}  # of a frame: one, or of edges two
        for name in os.listdir(os.path.join(source, part)):
            if name[:6].isdigit():
                files.setdefault(int(name[:6]), []).append(name)
        os.makedirs(os.path.join(target, part))
        for i in range(frames):
            for name in files.get(there_and_back[i % len(there_and_back)], []):
                os.symlink(os.path.join(source, part, name), os.path.join(target, part, '%06d%s' % (i, name[6:])))
    with open(os.path.join(target, 'trajectory.txt'), 'w') as text:
        for i in range(frames):
            text.write('%.9f %s\n' % (i / RATE_HZ, ' '.join(poses[there_and_back[i % len(there_and_back)]])))
    with open(os.path.join(source, 'camera.json')) as text:
        camera = json.load(text)
    camera['rate_hz'] = RATE_HZ
    with open(os.path.join(target, 'camera.json'), 'w') as text:
        json.dump(camera, text)
    for name in ('gravity.json', 'models'):
        if os.path.exists(os.path.join(source, name)):
            os.symlink(os.path.join(source, name), os.path.join(target, name))


def deaf(endpoint, schema):
    """Somebody who asks and does not read, in a process of its own."""
    code = ('import sys, time, zmq; sys.path.insert(0, sys.argv[2]); import plumbline_pb2 as wire\n'
            'socket = zmq.Context().socket(zmq.DEALER); socket.connect(sys.argv[1])\n'
            'i = 0\n'
            'while True:\n'
            '  i += 1; request = wire.Request(version=1, id=i, map=wire.MapRequest(after=-1))\n'
            '  try: socket.send_multipart([b"", request.SerializeToString()], zmq.DONTWAIT)\n'
            '  except zmq.Again: pass\n'
            '  time.sleep(.01)\n')
    return subprocess.Popen(['/usr/bin/python3', '-c', code, endpoint, schema])


def ask(plumbline, graph):
    """{name: what it says of itself} of the nodes that answer."""
    state = os.path.join(graph, 'soak.json')
    done = subprocess.run([plumbline, 'graph', graph, '--patience', '1', '--json', state], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if done.returncode:
        return {}
    with open(state) as text:
        return {node['name']: node for node in json.load(text)['nodes'] if node['answers']}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('plumbline')
    parser.add_argument('sequence')
    parser.add_argument('--hours', type=float, default=8)
    parser.add_argument('--own-poses', action='store_true')
    parser.add_argument('--speed', type=float, default=20)
    parser.add_argument('--kill-every', type=float, default=60)
    parser.add_argument('--deaf', action='store_true')
    parser.add_argument('--out', help='keep the run here (run.plb) and what was seen (soak.json)')
    arguments, options = parser.parse_known_args()
    options = [word for word in options if word != '--']
    with tempfile.TemporaryDirectory() as folder:
        out = arguments.out or folder
        os.makedirs(out, exist_ok=True)
        long, graph, run = os.path.join(folder, 'long'), os.path.join(folder, 'graph'), os.path.join(out, 'run.plb')
        words = ['paper', long]
        if arguments.own_poses:
            words = ['paper_vio', arguments.sequence, '--poses', 'vio']
        else:
            os.makedirs(long)
            frames = int(arguments.hours * 3600 * RATE_HZ)
            link_frames(os.path.abspath(arguments.sequence), long, frames)
            print('%d frames, %.1f h, in %.1f minutes' % (frames, arguments.hours, arguments.hours * 60 / arguments.speed), flush=True)
        up = subprocess.Popen([arguments.plumbline, 'up'] + words + ['--live=%g' % arguments.speed, '--out', run, '--folder', graph] + options,
                              stdout=subprocess.DEVNULL, stderr=open(os.path.join(out, 'up.log'), 'w'))
        listener, seen, kills, began, killed = None, [], [], time.monotonic(), time.monotonic()
        while up.poll() is None:
            time.sleep(10)
            nodes = ask(arguments.plumbline, graph)
            now = time.monotonic() - began
            if arguments.deaf and listener is None and 'mapper' in nodes:
                subprocess.run(['protoc', '--proto_path', os.path.join(os.path.dirname(__file__), '../engine/transport'), '--python_out', folder,
                                'plumbline.proto'], check=True)
                listener = deaf(nodes['mapper']['endpoint'], folder)
            seen.append((now, {name: node['resident_bytes'] / 1e6 for name, node in nodes.items()}))
            print('%5.0f s  ' % now + '  '.join('%s %.0f MB' % (name, node['resident_bytes'] / 1e6) for name, node in nodes.items()) +
                  '  ' + nodes.get('mapper', {}).get('state', ''), flush=True)
            if arguments.kill_every and nodes and time.monotonic() - killed > arguments.kill_every:
                name = sorted(nodes)[len(kills) % len(nodes)]
                os.kill(nodes[name]['process'], signal.SIGKILL)
                kills.append((now, name))
                killed = time.monotonic()
        if listener:
            listener.kill()
        with open(os.path.join(out, 'soak.json'), 'w') as text:
            json.dump({'seen': seen, 'kills': kills, 'exit': up.returncode}, text)
        print('ended with %d after %.0f s; %d kills' % (up.returncode, time.monotonic() - began, len(kills)))
        for name in sorted({name for _, nodes in seen for name in nodes}):
            sizes = [nodes[name] for _, nodes in seen if name in nodes]
            few = max(1, len(sizes) // 4)
            print('%-10s most %4.0f MB, mean of the first quarter %4.0f, of the last %4.0f' % (
                name, max(sizes), sum(sizes[:few]) / few, sum(sizes[-few:]) / few))
        sys.exit(up.returncode)


if __name__ == '__main__':
    main()
