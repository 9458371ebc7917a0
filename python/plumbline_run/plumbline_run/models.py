# SPDX-License-Identifier: Apache-2.0
"""Model databases: a folder with models.json and meshes (docs/formats.md)."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .files import FormatError, PathLike, read_json
from .geometry import Floats, box_corners, transform
from .ply import read_ply


@dataclass
class Mesh:
    vertices: Floats                         # (V, 3) [m]: +z up, +x the front, standing on z = 0
    triangles: 'NDArray[np.int64]'           # (T, 3)
    colors: 'Optional[NDArray[np.uint8]]'    # (V, 3) or None
    normals: Optional[Floats]                # (V, 3) or None


class Model:
    """A shape; its mesh is read when it is first asked for."""

    def __init__(self, folder: Path, entry: Dict[str, Any]) -> None:
        self.raw = entry
        try:
            self.name, self.category = str(entry['name']), str(entry['category'])
            self.file = folder / entry['file']
        except KeyError as error:
            raise FormatError("a model of '%s' has no %s" % (folder, error)) from None
        symmetry = entry.get('symmetry', {})
        self.symmetry_order = int(symmetry.get('order', 1))  # 0: round, 1: none
        self.symmetry_axis: Floats = np.array(symmetry.get('axis', [0, 0, 1]), float)
        self.on_floor = entry.get('support', 'any') == 'floor'
        self._mesh: Optional[Mesh] = None

    @property
    def mesh(self) -> Mesh:
        """Errors: FormatError for meshes that are not PLY, which `models build` writes."""
        if self._mesh is None:
            columns = read_ply(self.file)
            self._mesh = Mesh(columns.vertices, columns.triangles, columns.colors, columns.normals)
        return self._mesh

    @property
    def bounds(self) -> Floats:
        """(2, 3): lower and upper corner in the model's frame."""
        vertices = self.mesh.vertices
        return np.stack([vertices.min(axis=0), vertices.max(axis=0)])

    @property
    def center(self) -> Floats:
        """The middle of the box: what an object's covariance is about."""
        center: Floats = self.bounds.mean(axis=0)
        return center

    def corners(self, target_from_object: ArrayLike, scale: float = 1.0) -> Floats:
        """(8, 3): the box of the posed model."""
        lower, upper = scale * self.bounds
        return transform(target_from_object, box_corners(lower, upper))


class Models:
    """A database, by name: models['chair'].mesh.vertices."""

    def __init__(self, folder: PathLike) -> None:
        self.folder = Path(folder)
        listed = read_json(self.folder / 'models.json')
        if not isinstance(listed, dict) or not isinstance(listed.get('models'), list):
            raise FormatError("'%s' is no model database: its models.json has no list 'models'"
                              % self.folder)
        self._models: List[Model] = [Model(self.folder, entry) for entry in listed['models']]

    def __len__(self) -> int:
        return len(self._models)

    def __iter__(self) -> Iterator[Model]:
        return iter(self._models)

    def __contains__(self, name: str) -> bool:
        return any(model.name == name for model in self._models)

    def __getitem__(self, name: str) -> Model:
        for model in self._models:
            if model.name == name:
                return model
        raise KeyError("'%s' has no model '%s'" % (self.folder, name))

    @property
    def names(self) -> List[str]:
        return [model.name for model in self._models]
