# SPDX-License-Identifier: Apache-2.0
"""Annotation projects and ground truth: docs/annotation.md, docs/formats.md."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Optional

import numpy as np

from .files import FormatError, PathLike, read_json
from .geometry import Floats
from .models import Models


@dataclass
class Instance:
    """An object that somebody placed. In a ground truth, `scan` is the frame of that file."""
    id: str
    model: str
    category: str
    fine: bool
    scan_from_object: Floats  # point_in_scan = scan_from_object (scale point_in_object)
    scale: float
    annotator: str
    note: str
    seconds_spent: float
    raw: Dict[str, Any]       # everything that the file says of it


class Annotation:
    """A project (PROJECT.json) or a ground_truth.json, as it was saved. Edits that are in the
    project's journal alone are not seen: `plumbline annotate` or the window save them."""

    def __init__(self, path: PathLike) -> None:
        self.path = Path(path)
        self.raw: Dict[str, Any] = read_json(self.path)
        if not isinstance(self.raw, dict) or not isinstance(self.raw.get('instances'), list):
            raise FormatError("'%s' is no annotation project and no ground truth: it has no list "
                              "'instances'" % self.path)
        self.is_project = 'plumbline_annotation' in self.raw
        key = 'scan_from_object' if self.is_project else 'world_from_object'
        self.instances: List[Instance] = [self._instance(entry, key)
                                          for entry in self.raw['instances']]
        self.gravity: Floats = np.asarray(self.raw.get('gravity', [0, 0, -1]), float)
        floor = self.raw.get('floor')
        self.floor: Optional[Floats] = None if floor is None else np.asarray(floor, float)

    def _instance(self, entry: Dict[str, Any], key: str) -> Instance:
        try:
            pose = np.array(entry[key], float).reshape(4, 4)
            return Instance(entry['id'], entry['model'], entry.get('category', ''),
                            entry.get('quality', 'fine') == 'fine', pose,
                            float(entry.get('scale', 1)), entry.get('annotator', ''),
                            entry.get('note', ''), float(entry.get('seconds_spent', 0)), entry)
        except (KeyError, TypeError, ValueError) as error:
            raise FormatError("'%s': an instance has no %s" % (self.path, error)) from None

    def __len__(self) -> int:
        return len(self.instances)

    @property
    def ids(self) -> List[str]:
        return [instance.id for instance in self.instances]

    @property
    def poses(self) -> Floats:
        """scan_from_object, (N, 4, 4)."""
        return np.array([i.scan_from_object for i in self.instances]).reshape(-1, 4, 4)

    @property
    def scan_from_world(self) -> Floats:
        """Where the sequence's world is in the scan; the identity where they share a frame."""
        return np.array(self.raw.get('scan_from_world') or np.eye(4), float).reshape(4, 4)

    def resolve(self, key: str) -> Optional[Path]:
        """The path of `scan`, `models` or `sequence`, which the file has relative to itself."""
        value = self.raw.get(key)
        return self.path.parent / value if value else None

    def models(self) -> Models:
        folder = self.resolve('models')
        if folder is None:
            raise FormatError("'%s' names no model database" % self.path)
        return Models(folder)

    def boxes(self, models: Optional[Models] = None) -> Floats:
        """Corners of the boxes around the posed models in the scan, (N, 8, 3)."""
        models = models or self.models()
        return np.array([models[i.model].corners(i.scan_from_object, i.scale)
                         for i in self.instances]).reshape(-1, 8, 3)
