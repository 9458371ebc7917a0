# SPDX-License-Identifier: Apache-2.0
"""Runs (.plb), annotation projects and model databases of Plumbline, as numpy arrays.

Everything is opened for reading alone. Lengths are metres, angles radians, transforms 4x4 and named
target_from_source; docs/run_file.md and docs/formats.md of Plumbline describe the files.
"""

from .annotation import Annotation, Instance
from .files import FormatError
from .geometry import azimuth_of, box_corners, project, upright_rotation, wrap_angle
from .models import Mesh, Model, Models
from .run import Event, Frame, Frames, Mode, Object, Particles, Proposals, Run, SmoothedObject

__all__ = [
    'Annotation', 'Event', 'FormatError', 'Frame', 'Frames', 'Instance', 'Mesh', 'Mode', 'Model',
    'Models', 'Object', 'Particles', 'Proposals', 'Run', 'SmoothedObject', 'azimuth_of',
    'box_corners', 'project', 'upright_rotation', 'wrap_angle']
__version__ = '0.1.0'
