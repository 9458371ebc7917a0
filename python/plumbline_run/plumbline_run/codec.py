# SPDX-License-Identifier: Apache-2.0
"""The bytes of a run file's blobs: docs/run_file.md, "Bytes"."""

import struct
import zlib
from typing import Any, Callable, List, Optional, Tuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from .files import FormatError
from .geometry import Floats

T = TypeVar('T')

PARTICLE_DTYPE = np.dtype([(name, '<f4') for name in (
    'x_c', 'y_c', 'rho', 'azimuth', 'log_weight', 'phi_cnn', 'phi_edge')] + [
        ('label', '<u2'), ('ancestor', '<u2'), ('log_scale', '<f4')])


def unpack(blob: bytes) -> bytes:
    """4 bytes of length, then a zlib stream that unpacks to as many."""
    try:
        length, = struct.unpack_from('<I', blob)
        plain = zlib.decompress(blob[4:])
    except (struct.error, zlib.error) as error:
        raise FormatError('a frame in it is damaged: %s' % error) from None
    if len(plain) != length:
        raise FormatError('a frame in it is damaged: %d bytes instead of %d' % (len(plain), length))
    return plain


class Reader:
    """Values one after the other."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, format: str) -> Tuple[Any, ...]:
        try:
            values = struct.unpack_from('<' + format, self.data, self.at)
        except struct.error:
            raise FormatError('a frame in it is damaged: it ends too early') from None
        self.at += struct.calcsize('<' + format)
        return values

    def one(self, format: str) -> Any:
        return self.take(format)[0]

    def raw(self) -> bytes:
        size = self.one('I')
        if self.at + size > len(self.data):
            raise FormatError('a frame in it is damaged: it ends too early')
        self.at += size
        return self.data[self.at - size:self.at]

    def text(self) -> str:
        return self.raw().decode('utf-8', 'replace')

    def list(self, read: 'Callable[[], T]') -> 'List[T]':
        return [read() for _ in range(self.one('I'))]

    def optional(self, read: 'Callable[[], T]') -> 'Optional[T]':
        return read() if self.one('B') else None

    def pose(self) -> Floats:
        """4x4; the file has the upper three rows."""
        return np.vstack([np.array(self.take('12d')).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])

    def matrix(self, rows: int, columns: int) -> Floats:
        return np.array(self.take('%dd' % (rows * columns))).reshape(rows, columns)

    def box(self) -> Floats:
        """x0 y0 x1 y1 [px]."""
        return np.array(self.take('4f'), float)

    @property
    def left(self) -> int:
        return len(self.data) - self.at


def read_particles(blob: bytes) -> 'NDArray[Any]':
    """A structured array of PARTICLE_DTYPE. In the file each column has the lowest bytes of all
    values first, then the next ones; log_scale is there only where a last byte 1 makes the length
    odd."""
    plain = unpack(blob)
    scaled = len(plain) % 2 == 1
    each = PARTICLE_DTYPE.itemsize if scaled else PARTICLE_DTYPE.itemsize - 4
    count, rest = divmod(len(plain) - scaled, each)
    if rest:
        raise FormatError('a set of particles in it is damaged')
    particles = np.zeros(count, PARTICLE_DTYPE)
    at = 0
    for name in PARTICLE_DTYPE.names or ():
        if name == 'log_scale' and not scaled:
            break
        kind = PARTICLE_DTYPE[name]
        size = kind.itemsize * count
        planes = np.frombuffer(plain, np.uint8, size, at).reshape(kind.itemsize, count)
        particles[name] = np.ascontiguousarray(planes.T).view(kind)[:, 0]
        at += size
    return particles
