# SPDX-License-Identifier: Apache-2.0
"""Furniture of other people's hands: the catalogs of Sweet Home 3D (Debian: sweethome3d-furniture), unpacked.

A model is a list of (vtkPolyData, vtkTexture or None, RGB): +z up, standing on z = 0, centred, metres.
"""
import glob
import os
import re

import cv2
import numpy as np
import vtk
from vtk.util import numpy_support

MOST_FACES = 120000
CATEGORIES = [  # of what a name says, first match
    ('', r'^(bench|piano bench|stool|bar stool|flower box|bedside table|table tennis bat|children game|.*swing|beach chair|deck chair|pool lounge|.*wheelchair|baby high chair|contemporary.*|crib|baby bed|.*stand|tv remote.*|table (fan|tennis)|pool table|football table|changing table|street.*|ceiling.*|track.*|candle|chandelier.*|hanging.*|pendant.*|wall.*|fluor.*|flashlight|.*post|.*spotlight|upper.*|hood|sink cabinet|puff)$'),
    ('couch', r'sofa|couch|futon|winchester armchair'),
    ('chair', r'chair|seat'),
    ('desk', r'desk(?! lamp)'),
    ('lamp', r'lamp|little lamp'),
    ('tv', r'^tv( 16:9)?$|flat tv|^screen$|imac'),
    ('dining table', r'table(?!t)'),
    ('bed', r'bed$'),
    ('shelf', r'shel(f|ves)|bookcase'),
    ('cabinet', r'cabinet|wardrobe|cupboard|dresser|chest$|vanity|^lower'),
    ('refrigerator', r'fridge|refrigerator'),
    ('potted plant', r'plant(?! box)|ficus|bamboo|yucca|spath|lily|cactus|orchid|flowers|tulips|bonsai'),
    ('cup', r'^(coffee |plastic )?(cup|mug)$'),
]
NO_ROOM = {'Vehicles', 'Staircases', 'Doors and windows'}


def category_of(name, section):
    """Of a model; '' for what is nothing of ours, None for what does not belong into a room."""
    if section in NO_ROOM:
        return None
    for category, pattern in CATEGORIES:
        if re.search(pattern, name.lower()):
            return category if category != 'bed' or section == 'Bedroom' else ''
    return None if section == 'Exterior' else ''


def entries(folder):
    """Of every catalog below the folder: its fields."""
    files = sorted(glob.glob(os.path.join(folder, '*', 'PluginFurnitureCatalog.properties')))
    if not files:
        raise SystemExit("'%s' has no unpacked catalogs (*/PluginFurnitureCatalog.properties); unzip the .sh3f of sweethome3d-furniture there" % folder)
    for file in files:
        found = {}
        with open(file, encoding='latin1') as lines:
            for line in lines:
                match = re.match(r'(\w+)#(\d+)=(.*)', line.strip())
                if match:
                    found.setdefault(int(match[2]), {})[match[1]] = match[3]
        for number in sorted(found):
            found[number]['root'] = os.path.dirname(file)
            yield found[number]


def read_materials(file):
    """Name -> (RGB, file of its picture or None)."""
    found, name = {}, None
    if os.path.exists(file):
        with open(file, encoding='latin1') as lines:
            for line in lines:
                words = line.split()
                if not words:
                    continue
                if words[0] == 'newmtl':
                    name = ' '.join(words[1:])
                    found[name] = ((.7, .7, .7), None)
                elif words[0] == 'Kd' and name is not None:
                    found[name] = (tuple(min(1., float(w)) for w in words[1:4]), found[name][1])
                elif words[0] == 'map_Kd' and name is not None:
                    picture = os.path.join(os.path.dirname(file), line.strip()[6:].strip().replace('\\', '/'))
                    found[name] = (found[name][0], picture if os.path.exists(picture) else None)
    return found


def read_obj(file):
    """Of each material its corners: (name, positions, normals or None, picture coordinates or None, corners of each face)."""
    numbers = {'v': [], 'vt': [], 'vn': []}
    groups, name = {}, ''
    with open(file, encoding='latin1') as lines:
        for line in lines:
            words = line.split()
            if not words:
                continue
            if words[0] in numbers:
                width = 2 if words[0] == 'vt' else 3
                numbers[words[0]].append(([float(w) for w in words[1:1 + width]] + [0.] * width)[:width])
            elif words[0] == 'usemtl':
                name = ' '.join(words[1:])
            elif words[0] == 'f':
                groups.setdefault(name, []).append([(corner + '//').split('/')[:3] for corner in words[1:]])
    arrays = {k: np.array(v, float).reshape(-1, 2 if k == 'vt' else 3) for k, v in numbers.items()}

    def values(kind, words):
        if not len(arrays[kind]) or any(not w for w in words):
            return None
        index = np.array([int(w) for w in words])
        return arrays[kind][np.where(index < 0, len(arrays[kind]) + index, index - 1)]
    for name, faces in groups.items():
        corners = [corner for face in faces for corner in face]
        yield (name, values('v', [c[0] for c in corners]), values('vn', [c[2] for c in corners]), values('vt', [c[1] for c in corners]),
               [len(face) for face in faces])


def mesh_of(positions, normals, coordinates, sizes):
    mesh, points, faces = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetData(numpy_support.numpy_to_vtk(positions, deep=True))
    ends = np.concatenate(([0], np.cumsum(sizes)))
    faces.SetData(numpy_support.numpy_to_vtkIdTypeArray(ends, deep=True), numpy_support.numpy_to_vtkIdTypeArray(np.arange(ends[-1]), deep=True))
    mesh.SetPoints(points)
    mesh.SetPolys(faces)
    if normals is not None:
        mesh.GetPointData().SetNormals(numpy_support.numpy_to_vtk(normals, deep=True))
    if coordinates is not None:
        mesh.GetPointData().SetTCoords(numpy_support.numpy_to_vtk(coordinates, deep=True))
    return mesh


def texture_of(picture):
    image = cv2.imread(picture)
    if image is None:
        return None
    share = min(1, 256 / max(image.shape))
    image = cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    data, texture = vtk.vtkImageData(), vtk.vtkTexture()
    data.SetDimensions(image.shape[1], image.shape[0], 1)
    data.GetPointData().SetScalars(numpy_support.numpy_to_vtk(np.ascontiguousarray(image[::-1, :, ::-1]).reshape(-1, 3), deep=True))
    texture.SetInputData(data)
    texture.InterpolateOn()
    texture.RepeatOn()
    return texture


def model_of(entry):
    """Parts of a catalog's entry; None where it is too fine."""
    file = entry['root'] + entry['model']
    if not file.endswith('.obj') or not os.path.exists(file):
        return None
    groups, materials, pictures = list(read_obj(file)), read_materials(file[:-4] + '.mtl'), {}
    groups = [g for g in groups if g[1] is not None]
    if not groups or sum(len(g[4]) for g in groups) > MOST_FACES:
        return None
    turn = np.array([[1., 0, 0], [0, 0, -1], [0, 1, 0]])  # y up to z up
    if 'modelRotation' in entry:
        turn = turn @ np.array(entry['modelRotation'].split(), float).reshape(3, 3)
    positions = [g[1] @ turn.T for g in groups]
    low, high = np.min([p.min(0) for p in positions], 0), np.max([p.max(0) for p in positions], 0)
    scale = np.array([float(entry[k]) / 100 for k in ('width', 'depth', 'height')]) / np.maximum(high - low, 1e-6)
    middle = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    parts = []
    for (name, _, normals, coordinates, sizes), points in zip(groups, positions):
        color, picture = materials.get(name, ((.7, .7, .7), None))
        if picture and coordinates is not None and picture not in pictures:
            pictures[picture] = texture_of(picture)
        normals = None if normals is None else normals @ turn.T
        parts.append((mesh_of((points - middle) * scale, normals, coordinates, sizes), pictures.get(picture) if coordinates is not None else None, color))
    return parts


def models(folder):
    """(category, parts) of all that belongs into a room; the category of what is nothing of ours is ''."""
    for entry in entries(folder):
        category = category_of(entry.get('name', ''), entry.get('category', ''))
        if category is not None and 'model' in entry and max(float(entry[k]) for k in ('width', 'depth', 'height')) < 330:
            parts = model_of(entry)
            if parts:
                yield category, parts
