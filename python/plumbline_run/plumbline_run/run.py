# SPDX-License-Identifier: Apache-2.0
"""A run file: what the mapper did, frame by frame. See docs/run_file.md."""

import json
import os
import sqlite3
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Dict, Iterator, List, Optional, Tuple, Type

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .codec import Reader, read_particles, unpack
from .files import FormatError, PathLike
from .geometry import Floats, azimuth_of, transform, wrap_angle

APPLICATION_ID = 0x504C4252
NEWEST_VERSION = 2
STATES = ('tentative', 'confirmed', 'retired')
FATES = ('explained', 'spawned', 'unknown_category', 'low_score', 'implausible')
EVENTS = ('spawned', 'confirmed', 'merged', 'retired', 'label_changed', 'frame_skipped',
          'options_changed', 'poses_corrected')


@dataclass
class Frames:
    """All frames, a row each."""
    position: 'NDArray[np.int64]'  # in the file: 0, 1, 2 ..
    frame: 'NDArray[np.int64]'     # number in the sequence
    stamp_ns: 'NDArray[np.int64]'
    elapsed_s: Floats              # wall-clock seconds of the run up to there
    skipped: List[str]             # '' or why the frame was not used

    def __len__(self) -> int:
        return len(self.position)

    @property
    def used(self) -> 'NDArray[np.bool_]':
        return np.array([not why for why in self.skipped], bool)


@dataclass
class Proposals:
    """Boxes of the detector in a frame, a row each."""
    boxes: Floats                 # (N, 4): x0 y0 x1 y1 [px]
    scores: Floats
    categories: List[str]
    fates: List[str]              # of FATES
    objects: 'NDArray[np.int64]'  # which it explains or gave birth to; -1 none


@dataclass
class Mode:
    """One of the separate places where an object may be."""
    model: str
    weight: float
    world_from_object: Floats
    position_std: float  # [m], root of the mean squared distance
    azimuth_std: float   # [rad]
    scale: float = 1.0
    scale_std: float = 0.0


@dataclass
class Particles:
    """Hypotheses of an object's shape and pose."""
    table: 'NDArray[Any]'              # columns as docs/run_file.md names them
    world_from_reference_cam: Floats
    models: List[str]                  # by label

    def __len__(self) -> int:
        return len(self.table)

    @property
    def weights(self) -> Floats:
        """They sum to 1."""
        weights: Floats = np.exp(self.table['log_weight'].astype(float))
        normalized: Floats = weights / weights.sum()
        return normalized

    @property
    def centers(self) -> Floats:
        """(N, 3): the middle of the model's box in world [m], exp(rho) [x_c, y_c, 1] in the
        reference camera."""
        z = np.exp(self.table['rho'].astype(float))
        in_cam = np.stack([z * self.table['x_c'], z * self.table['y_c'], z], axis=1)
        return transform(self.world_from_reference_cam, in_cam)

    @property
    def azimuths(self) -> Floats:
        """About up [rad]."""
        azimuths: Floats = self.table['azimuth'].astype(float)
        return azimuths

    @property
    def labels(self) -> 'NDArray[np.int64]':
        return self.table['label'].astype(np.int64)

    def label_probability(self) -> Dict[str, float]:
        sums = np.bincount(self.labels, self.weights, len(self.models))
        return {name: float(p) for name, p in zip(self.models, sums) if p > 0}


@dataclass
class Object:
    """What is believed of an object after a frame."""
    id: int
    state: str                    # of STATES
    category: str
    model: str                    # the most likely one
    weighed: bool                 # False: hidden or out of view, so that nothing was learned
    confirmed_frame: Optional[int]
    reference_frame: int
    world_from_reference_cam: Floats
    first_frame: int
    last_frame: int               # the last one in which it was weighed
    label_probability: Dict[str, float]
    world_from_object: Floats     # the mean of the heaviest mode
    covariance: Floats            # of it: x, y, z of the centre in world [m], azimuth [rad]
    modes: List[Mode]             # by falling weight
    effective_sample_size: float
    log_evidence: float           # log odds that it is there
    visible_fraction: float
    phi_cnn: float
    phi_edge: float
    whole_box: Floats             # x0 y0 x1 y1 [px] of the mean in this image, hidden or not
    visible_box: Floats
    scale: float = 1.0            # point_in_world = world_from_object (scale point_in_object)
    scale_std: float = 0.0
    particles: Optional[Particles] = None

    @property
    def probability(self) -> float:
        """That it is there."""
        return float(1 / (1 + np.exp(-self.log_evidence)))

    def mixture_covariance(self, gravity: ArrayLike, symmetry_order: int = 1) -> Floats:
        """(4, 4) over all that is believed, in the order of `covariance`, which is the heaviest
        mode's alone: over all particles about their mean, or, without them, over the modes. With
        one mode it is that mode's. `plumbline export --format json` has the same.

        symmetry_order: of the model: the azimuth counts modulo a turn of 1 / order; 0: round."""
        if len(self.modes) < 2:
            return self.covariance
        azimuth = azimuth_of(self.world_from_object, gravity)
        place = self.world_from_object[:3, 3]

        def turns(azimuths: ArrayLike) -> Floats:
            difference = np.asarray(azimuths, float) - azimuth
            if symmetry_order == 0:
                return np.zeros_like(difference)
            return wrap_angle(difference * symmetry_order) / symmetry_order

        own: Floats = np.zeros((1, 4, 4))
        if self.particles is not None and len(self.particles):
            weights, places = self.particles.weights, self.particles.centers - place
            turned = turns(self.particles.azimuths)
        else:
            poses = np.stack([mode.world_from_object for mode in self.modes])
            weights = np.array([mode.weight for mode in self.modes])
            weights = weights / weights.sum()
            places, turned = poses[:, :3, 3] - place, turns(azimuth_of(poses, gravity))
            own = np.stack([np.diag([m.position_std**2 / 3] * 3 + [m.azimuth_std**2])
                            for m in self.modes])
            own[0] = self.covariance
        states = np.column_stack([places, turned])
        states = states - weights @ states
        mixture: Floats = np.einsum('n,ni,nj->ij', weights, states, states)
        spread: Floats = np.einsum('n,nij->ij', np.broadcast_to(weights, len(own)), own) \
            if len(own) == len(weights) else own[0]
        return mixture + spread


@dataclass
class SmoothedObject:
    """An object of the second pass over all frames."""
    belief: Object
    spawned_frame: int
    looks: int
    looks_before: int
    views: int
    refined: bool
    agreement: float
    pushed: float  # [m]


@dataclass
class Frame:
    position: int
    frame: int
    stamp_ns: int
    skipped: str
    world_from_cam: Optional[Floats]
    proposals: Proposals
    timings: Dict[str, float]  # milliseconds of each stage
    objects: List[Object] = field(default_factory=list)

    def object(self, id: int) -> Object:
        for each in self.objects:
            if each.id == id:
                return each
        raise KeyError('frame %d reports no object %d' % (self.frame, id))


@dataclass
class Event:
    position: int
    frame: int
    kind: str                   # of EVENTS
    object: Optional[int]
    other: Optional[int]
    text: str


class Run:
    """A run file, opened for reading. Use it as a context manager or close() it.

    A run that is still being written can be read: what is asked for later sees later frames."""

    def __init__(self, path: PathLike) -> None:
        self.path = Path(path)
        if not self.path.is_file():
            raise FileNotFoundError("there is no run file '%s'" % self.path)
        try:
            self._connection = self._open()
            self.header: Dict[str, Any] = json.loads(self._value('header') or '{}')
        except sqlite3.DatabaseError as error:
            raise FormatError("'%s' is not a run file: %s" % (self.path, error)) from None

    def _open(self) -> sqlite3.Connection:
        connection = sqlite3.connect('file:%s?mode=ro' % _quoted(self.path), uri=True)
        application, = connection.execute('PRAGMA application_id').fetchone()
        version, = connection.execute('PRAGMA user_version').fetchone()
        if application != APPLICATION_ID:
            connection.close()
            raise FormatError("'%s' is not a run file" % self.path)
        if version > NEWEST_VERSION:
            connection.close()
            raise FormatError("'%s' is of format %d; this package knows %d and older"
                              % (self.path, version, NEWEST_VERSION))
        return connection

    def __enter__(self) -> 'Run':
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], value: Optional[BaseException],
                 trace: Optional[TracebackType]) -> None:
        self.close()

    def close(self) -> None:
        self._connection.close()

    def _value(self, key: str) -> Optional[str]:
        row = self._connection.execute('SELECT value FROM run WHERE key = ?', (key,)).fetchone()
        return None if row is None else str(row[0])

    def _rows(self, query: str, values: Tuple[Any, ...] = ()) -> Iterator[Tuple[Any, ...]]:
        return iter(self._connection.execute(query, values).fetchall())

    def _has_table(self, name: str) -> bool:
        query = "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?"
        return self._connection.execute(query, (name,)).fetchone() is not None

    # The run as a whole.

    @property
    def finished(self) -> bool:
        """False: it is being written, or was cut off."""
        return self._value('finished') == '1'

    @property
    def models(self) -> List[str]:
        """Names by label."""
        listed = self.header.get('models') or self.header.get('database', {}).get('models', [])
        return [str(model['name']) for model in listed]

    @property
    def gravity(self) -> Floats:
        """Unit vector down, in world."""
        gravity = np.asarray(self.header['gravity'], float)
        return gravity / float(np.linalg.norm(gravity))

    @property
    def camera(self) -> Dict[str, Any]:
        """width, height, fx, fy, cx, cy [px] of the undistorted images, and rate_hz."""
        camera: Dict[str, Any] = self.header['camera']
        return camera

    def __len__(self) -> int:
        count, = self._connection.execute('SELECT count(*) FROM frames').fetchone()
        return int(count)

    def frames(self) -> Frames:
        rows = list(self._rows('SELECT position, frame, stamp_ns, elapsed_s, skipped FROM frames '
                               'ORDER BY position'))
        position, frame, stamp, elapsed, skipped = zip(*rows) if rows else ((),) * 5
        return Frames(np.array(position, np.int64), np.array(frame, np.int64),
                      np.array(stamp, np.int64), np.array(elapsed, float), list(skipped))

    def trajectory(self) -> 'Tuple[NDArray[np.int64], Floats]':
        """Frames that have a camera pose, and world_from_cam (N, 4, 4)."""
        numbers, poses = [], []
        for frame, details in self._rows('SELECT frame, details FROM frames ORDER BY position'):
            reader = Reader(unpack(details))
            pose = reader.optional(reader.pose)
            if pose is not None:
                numbers.append(frame)
                poses.append(pose)
        return np.array(numbers, np.int64), np.array(poses).reshape(-1, 4, 4)

    def events(self) -> List[Event]:
        query = ('SELECT e.position, f.frame, kind, object, other, text FROM events e JOIN frames f '
                 'ON f.position = e.position ORDER BY e.position, ordinal')
        return [Event(position, frame, EVENTS[kind], None if object < 0 else object,
                      None if other < 0 else other, text)
                for position, frame, kind, object, other, text in self._rows(query)]

    def object_ids(self) -> List[int]:
        return [row[0] for row in self._rows('SELECT DISTINCT object FROM objects ORDER BY object')]

    # One frame.

    def _position(self, position: int) -> int:
        count = len(self)
        if not -count <= position < count:
            raise IndexError("'%s' has %d frames; there is no position %d"
                             % (self.path, count, position))
        return position % count

    def last_used(self) -> int:
        """Position of the newest frame that was not skipped."""
        row = self._connection.execute(
            "SELECT max(position) FROM frames WHERE skipped = ''").fetchone()
        if row[0] is None:
            raise IndexError("no frame of '%s' was used" % self.path)
        return int(row[0])

    def position_of(self, frame: int) -> int:
        """Of a frame of the sequence. KeyError if it is not in the run."""
        row = self._connection.execute('SELECT position FROM frames WHERE frame = ?',
                                       (frame,)).fetchone()
        if row is None:
            raise KeyError("frame %d is not in '%s'" % (frame, self.path))
        return int(row[0])

    def frame(self, position: int, particles: bool = True) -> Frame:
        """By position in the file; negative counts from the end."""
        position = self._position(position)
        frame, stamp, skipped, details = self._connection.execute(
            'SELECT frame, stamp_ns, skipped, details FROM frames WHERE position = ?',
            (position,)).fetchone()
        reader = Reader(unpack(details))
        pose = reader.optional(reader.pose)
        rows = reader.list(lambda: (reader.box(), reader.text(), reader.one('f'), reader.one('B'),
                                    reader.one('i')))
        proposals = Proposals(np.array([r[0] for r in rows]).reshape(-1, 4),
                              np.array([r[2] for r in rows], float), [r[1] for r in rows],
                              [FATES[r[3]] for r in rows], np.array([r[4] for r in rows], np.int64))
        timings = dict(reader.list(lambda: (reader.text(), float(reader.one('d')))))
        return Frame(position, frame, stamp, skipped, pose, proposals, timings,
                     self.objects(position, particles))

    def objects(self, position: int = -1, particles: bool = True) -> List[Object]:
        """What is reported at a position, by id; retired objects are reported once more."""
        position = self._position(position)
        query = ('SELECT object, state, category, label, confirmed_frame, weighed, details, '
                 'particles_at, particles FROM objects WHERE position = ? ORDER BY object')
        found = []
        for row in self._rows(query, (position,)):
            each = self._object(*row[:7])
            if particles:
                each.particles = self._particles(each, row[7], row[8])
            found.append(each)
        return found

    def history(self, object: int) -> 'Tuple[NDArray[np.int64], List[Object]]':
        """Positions at which an object is reported, and what is believed there, without
        particles."""
        query = ('SELECT position, object, state, category, label, confirmed_frame, weighed, '
                 'details FROM objects WHERE object = ? ORDER BY position')
        rows = list(self._rows(query, (object,)))
        return (np.array([row[0] for row in rows], np.int64),
                [self._object(*row[1:]) for row in rows])

    def smoothed(self) -> Optional[List[SmoothedObject]]:
        """What the second pass found; None in a run that has not had one."""
        if self._value('smoothed') is None or not self._has_table('smoothed'):
            return None
        query = ('SELECT object, state, category, label, confirmed_frame, 1, details, '
                 'spawned_frame, looks, looks_before, views, refined, agreement, pushed_m '
                 'FROM smoothed ORDER BY object')
        return [SmoothedObject(self._object(*row[:7]), row[7], row[8], row[9], row[10],
                               bool(row[11]), row[12], row[13]) for row in self._rows(query)]

    def thumbnail(self, position: int) -> bytes:
        """A JPEG, 160 pixels wide; b'' where there was no image."""
        row = self._connection.execute('SELECT thumbnail FROM frames WHERE position = ?',
                                       (self._position(position),)).fetchone()
        return bytes(row[0])

    def _particles(self, of: Object, at: Optional[int], blob: Optional[bytes]) \
            -> Optional[Particles]:
        if at is None:
            return None
        if blob is None:  # they did not change: stored with an earlier frame
            row = self._connection.execute(
                'SELECT particles FROM objects WHERE position = ? AND object = ?',
                (at, of.id)).fetchone()
            blob = row[0] if row else None
        if blob is None:
            raise FormatError("'%s' is damaged: particles of object %d are missing"
                              % (self.path, of.id))
        return Particles(read_particles(blob), of.world_from_reference_cam, self.models)

    def _object(self, id: int, state: int, category: str, label: int,
                confirmed_frame: Optional[int], weighed: int, details: bytes) -> Object:
        models, r = self.models, Reader(unpack(details))

        def name(index: int) -> str:
            return models[index] if 0 <= index < len(models) else ''

        def mode() -> Mode:
            return Mode(name(r.one('i')), r.one('d'), r.pose(), r.one('d'), r.one('d'))

        # In the order of the file.
        reference_frame, from_reference = r.one('i'), r.pose()
        first_frame, last_frame = r.take('ii')
        labels = r.list(lambda: (name(r.one('i')), float(r.one('d'))))
        pose, covariance, modes = r.pose(), r.matrix(4, 4), r.list(mode)
        sample_size, evidence, visible, cnn, edge = r.take('dddff')
        whole_box, visible_box = r.box(), r.box()
        r.raw()  # what the mapper alone reads
        read = Object(id, STATES[state], category, name(label), bool(weighed), confirmed_frame,
                      reference_frame, from_reference, first_frame, last_frame, dict(labels), pose,
                      covariance, modes, sample_size, evidence, visible, cnn, edge, whole_box,
                      visible_box)
        if r.left:
            read.scale, read.scale_std = r.take('dd')
            for each in modes:
                each.scale, each.scale_std = r.take('dd')
        return read


def _quoted(path: Path) -> str:
    """For an SQLite URI."""
    text = os.fspath(path.absolute())
    return text.replace('%', '%25').replace('?', '%3f').replace('#', '%23')
