#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows the map of a running graph, and never holds it up: docs/processes.md. Usage: follow.py MAPPER [FRAMES]

Prints a line for each report that it gets: frame, objects confirmed, reports passed over since the one before."""
import sys

import plumbline_pb2 as wire
import zmq

mapper = zmq.Context().socket(zmq.REQ)
mapper.setsockopt(zmq.REQ_RELAXED, 1)  # a mapper that died is asked again
mapper.setsockopt(zmq.RCVTIMEO, 1000)
mapper.setsockopt(zmq.LINGER, 0)
mapper.connect(sys.argv[1])
after, left = -1, int(sys.argv[2]) if len(sys.argv) > 2 else -1
while left != 0:
    mapper.send(wire.Request(version=1, map=wire.MapRequest(after=after)).SerializeToString())
    try:
        reply = wire.Reply.FromString(mapper.recv())
    except zmq.Again:
        continue
    report = reply.map.report
    confirmed = sum(thing.state == 1 for thing in report.objects)
    print(f"frame {report.frame}: {confirmed} objects, {reply.map.dropped} reports passed over", flush=True)
    after, left = report.frame, left - 1
