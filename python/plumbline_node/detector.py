#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A detector of one's own, as a node of a graph: docs/processes.md. Usage: detector.py ENDPOINT PLAYER"""
import sys

import numpy as np
import plumbline_pb2 as wire
import zmq


def find(image):
    """Boxes of what stands out from a dark background; your network goes here."""
    lit = image.max(axis=2) > 30
    ends = np.flatnonzero(np.diff(np.concatenate(([0], lit.any(axis=0), [0]))))
    for x0, x1 in ends.reshape(-1, 2):
        y = np.flatnonzero(lit[:, x0:x1].any(axis=1))
        if x1 - x0 > 20:
            yield wire.Proposal(x0=x0, y0=y[0], x1=x1 - 1, y1=y[-1], category="chair", score=0.6)


context = zmq.Context()
node, player = context.socket(zmq.REP), context.socket(zmq.REQ)
player.setsockopt(zmq.REQ_RELAXED, 1)  # a player that died is asked again
player.setsockopt(zmq.RCVTIMEO, 1000)
player.connect(sys.argv[2])
node.bind(sys.argv[1])
while True:
    asked = wire.Request.FromString(node.recv())
    reply = wire.Reply(version=1, id=asked.id, about=wire.About(kind="detector", program="detector.py 1"))
    image = wire.Reply()
    while asked.HasField("proposals") and not image.version:
        player.send(wire.Request(version=1, plain_pixels=True,
                                 image=wire.ImageRequest(frame=asked.proposals.frame)).SerializeToString())
        try:
            image = wire.Reply.FromString(player.recv())
        except zmq.Again:
            continue
        pixels = image.image.pixels
        colours = np.frombuffer(pixels.plain, np.uint8).reshape(pixels.height, pixels.width, pixels.channels)
        reply.proposals.CopyFrom(wire.Proposals(frame=asked.proposals.frame, proposals=find(colours)))
    node.send(reply.SerializeToString())
