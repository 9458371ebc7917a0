# SPDX-License-Identifier: Apache-2.0
"""PLY meshes: ascii and both binary orders, polygons as fans of triangles."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from .files import FormatError
from .geometry import Floats

TYPES = {'char': 'i1', 'uchar': 'u1', 'short': 'i2', 'ushort': 'u2', 'int': 'i4', 'uint': 'u4',
         'float': 'f4', 'double': 'f8', 'int8': 'i1', 'uint8': 'u1', 'int16': 'i2', 'uint16': 'u2',
         'int32': 'i4', 'uint32': 'u4', 'float32': 'f4', 'float64': 'f8'}
ORDERS = {'ascii': '', 'binary_little_endian': '<', 'binary_big_endian': '>'}


@dataclass
class Ply:
    vertices: Floats
    triangles: 'NDArray[np.int64]'
    colors: 'Optional[NDArray[np.uint8]]'
    normals: Optional[Floats]


@dataclass
class _Element:
    name: str
    count: int
    properties: List[Tuple[str, str, str]]  # name, type, type of a list's length or ''


def _header(data: bytes, path: Path) -> Tuple[str, List[_Element], int]:
    end = data.find(b'end_header')
    if not data.startswith(b'ply') or end < 0:
        raise FormatError("'%s' is no PLY file; other meshes are not read by this package" % path)
    order, elements = '', []
    for line in data[:end].decode('ascii', 'replace').splitlines():
        words = line.split()
        if words[:1] == ['format']:
            order = words[1]
        elif words[:1] == ['element']:
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[:2] == ['property', 'list']:
            elements[-1].properties.append((words[4], TYPES[words[3]], TYPES[words[2]]))
        elif words[:1] == ['property']:
            elements[-1].properties.append((words[2], TYPES[words[1]], ''))
    if order not in ORDERS:
        raise FormatError("'%s' has the unknown format '%s'" % (path, order))
    return ORDERS[order], elements, data.index(b'\n', end) + 1


class _Body:
    """The values behind the header."""

    def __init__(self, data: bytes, at: int, order: str) -> None:
        self.data, self.at, self.order = data, at, order
        self.words: List[bytes] = data[at:].split() if not order else []
        self.word = 0

    def one(self, kind: str) -> float:
        if not self.order:
            self.word += 1
            return float(self.words[self.word - 1])
        value = np.frombuffer(self.data, self.order + kind, 1, self.at)[0]
        self.at += np.dtype(kind).itemsize
        return float(value)

    def scalars(self, element: _Element) -> 'Dict[str, NDArray[Any]]':
        names = [p[0] for p in element.properties]
        if not self.order:
            size = element.count * len(names)
            table = np.array(self.words[self.word:self.word + size], float).reshape(-1, len(names))
            self.word += size
            return {name: table[:, i] for i, name in enumerate(names)}
        kind = np.dtype([(name, self.order + type) for name, type, _ in element.properties])
        rows = np.frombuffer(self.data, kind, element.count, self.at)
        self.at += kind.itemsize * element.count
        return {name: rows[name] for name in names}

    def triangles(self, element: _Element) -> 'Optional[NDArray[np.int64]]':
        """The usual case, triangles alone, at once; None if it is another."""
        if not self.order or len(element.properties) != 1:
            return None
        _, type, length = element.properties[0]
        kind = np.dtype([('n', self.order + length), ('v', self.order + type, 3)])
        if len(self.data) - self.at < kind.itemsize * element.count:
            return None
        rows = np.frombuffer(self.data, kind, element.count, self.at)
        if not (rows['n'] == 3).all():
            return None
        self.at += kind.itemsize * element.count
        corners: 'NDArray[np.int64]' = rows['v'].astype(np.int64)
        return corners

    def lists(self, element: _Element) -> 'NDArray[np.int64]':
        """Polygons row by row, as fans of triangles."""
        found: List[List[int]] = []
        for _ in range(element.count):
            for name, type, length in element.properties:
                values = [self.one(type) for _ in range(int(self.one(length)))] if length \
                    else [self.one(type)]
                if name in ('vertex_indices', 'vertex_index'):
                    v = [int(value) for value in values]
                    found += [[v[0], v[k - 1], v[k]] for k in range(2, len(v))]
        return np.array(found, np.int64).reshape(-1, 3)


def read_ply(path: Path) -> Ply:
    data = path.read_bytes()
    order, elements, at = _header(data, path)
    body = _Body(data, at, order)
    columns: 'Dict[str, NDArray[Any]]' = {}
    triangles: 'NDArray[np.int64]' = np.zeros((0, 3), np.int64)
    try:
        for element in elements:
            if any(p[2] for p in element.properties):
                quick = body.triangles(element)
                read = body.lists(element) if quick is None else quick
                triangles = read if element.name == 'face' else triangles
            else:
                read_columns = body.scalars(element)
                columns = read_columns if element.name == 'vertex' else columns

        def stacked(*names: str) -> 'Optional[NDArray[Any]]':
            if not all(name in columns for name in names):
                return None
            rows: 'NDArray[Any]' = np.stack([columns[name] for name in names], axis=1)
            return rows

        vertices = stacked('x', 'y', 'z')
        if vertices is None:
            raise FormatError("'%s' has no vertices" % path)
        colors, normals = stacked('red', 'green', 'blue'), stacked('nx', 'ny', 'nz')
    except (ValueError, IndexError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError("'%s' is damaged: %s" % (path, error)) from None
    return Ply(vertices.astype(float), triangles,
               None if colors is None else colors.astype(np.uint8),
               None if normals is None else normals.astype(float))
