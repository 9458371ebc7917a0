# SPDX-License-Identifier: Apache-2.0
"""Angles, upright poses and boxes, as Plumbline's docs/conventions.md defines them."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def wrap_angle(angle: ArrayLike) -> Floats:
    """Angles [rad] wrapped to (-pi, pi]."""
    wrapped: Floats = np.pi - np.mod(np.pi - np.asarray(angle, float), 2 * np.pi)
    return wrapped


def upright_rotation(gravity_in_world: ArrayLike) -> Floats:
    """[h, up x h, up]: the rotation of an object at azimuth 0, h being the world's x (or y, where x
    is within 26 degrees of up) made horizontal."""
    up = -np.asarray(gravity_in_world, float)
    up = up / np.linalg.norm(up)
    axis = np.array([0.0, 1.0, 0.0]) if abs(up[0]) > 0.9 else np.array([1.0, 0.0, 0.0])
    h = axis - up * (axis @ up)
    h = h / np.linalg.norm(h)
    return np.stack([h, np.cross(up, h), up], axis=1)


def azimuth_of(world_from_object: ArrayLike, gravity_in_world: ArrayLike) -> Floats:
    """Angle [rad] about up of each pose's +x; of poses (.., 4, 4) or rotations (.., 3, 3)."""
    x = np.asarray(world_from_object, float)[..., :3, 0]
    frame = upright_rotation(gravity_in_world)
    angle: Floats = np.arctan2(x @ frame[:, 1], x @ frame[:, 0])
    return angle


def box_corners(lower: ArrayLike, upper: ArrayLike) -> Floats:
    """The 8 corners of an axis-aligned box, (8, 3); bit k of a corner's number says which side of
    axis k it is on."""
    sides = np.stack([np.asarray(lower, float), np.asarray(upper, float)])
    return np.array([[sides[(i >> k) & 1, k] for k in range(3)] for i in range(8)])


def transform(target_from_source: ArrayLike, points: ArrayLike) -> Floats:
    """Points (.., 3) by a 4x4 transform."""
    matrix = np.asarray(target_from_source, float)
    moved: Floats = np.asarray(points, float) @ matrix[:3, :3].T + matrix[:3, 3]
    return moved


def project(camera: 'dict[str, Any]', points_in_cam: ArrayLike) -> Floats:
    """Pixels (.., 2) of points before a camera {fx, fy, cx, cy}; the centre of the first pixel is
    (0, 0). Points that are not before it become NaN."""
    points = np.asarray(points_in_cam, float)
    z = np.where(points[..., 2] > 0, points[..., 2], np.nan)
    return np.stack([camera['fx'] * points[..., 0] / z + camera['cx'],
                     camera['fy'] * points[..., 1] / z + camera['cy']], axis=-1)
