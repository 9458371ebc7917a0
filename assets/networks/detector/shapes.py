# SPDX-License-Identifier: Apache-2.0
"""Furniture at random: a category's shape as coloured parts (vtkPolyData with RGB a vertex), +z up, standing on z = 0, metres."""
import json
import os

import numpy as np
import vtk
from vtk.util import numpy_support


def paint(rng):
    """A part's colour: mostly muted, sometimes strong, sometimes nearly black or white."""
    value = rng.choice([rng.uniform(.02, .2), rng.uniform(.2, .8), rng.uniform(.8, 1)])
    hue, saturation = rng.uniform(), rng.choice([rng.uniform(0, .15), rng.uniform(.15, .5), rng.uniform(.5, 1)])
    if rng.random() < .35:  # wood
        hue, saturation, value = rng.uniform(.05, .12), rng.uniform(.3, .8), rng.uniform(.2, .9)
    rgb = [0, 0, 0]
    vtk.vtkMath.HSVToRGB(np.array([hue, saturation, value]), rgb)
    return rgb


class Parts:
    """Boxes, bars and discs that are put together."""

    def __init__(self, rng):
        self.rng, self.append = rng, vtk.vtkAppendPolyData()
        self.colors = [paint(rng) for _ in range(3)]

    def add(self, source, matrix, color):
        mover = vtk.vtkTransformPolyDataFilter()
        mover.SetInputConnection(source.GetOutputPort())
        mover.SetTransform(matrix)
        mover.Update()
        part = vtk.vtkPolyData()
        part.ShallowCopy(mover.GetOutput())
        rgb = np.tile((255 * np.array(self.colors[color])).astype(np.uint8), (part.GetNumberOfPoints(), 1))
        scalars = numpy_support.numpy_to_vtk(rgb, deep=True)
        part.GetPointData().Initialize()
        part.GetPointData().SetScalars(scalars)
        self.append.AddInputData(part)

    def box(self, center, size, color=0, lean=0, round_=0.):
        """Lean: about y, in degrees, positive tilts the upper end to -x."""
        if round_ > 0:
            source = vtk.vtkSuperquadricSource()
            source.SetPhiRoundness(round_)
            source.SetThetaRoundness(round_)
            source.SetPhiResolution(16)
            source.SetThetaResolution(16)
            source.SetScale(1, 1, 1)
        else:
            source = vtk.vtkCubeSource()
        matrix = vtk.vtkTransform()
        matrix.Translate(*center)
        matrix.RotateY(-lean)
        matrix.Scale(*size)
        self.add(source, matrix, color)

    def bar(self, a, b, radius, color=1, sides=10, taper=1.):
        a, b = np.array(a, float), np.array(b, float)
        source = vtk.vtkCylinderSource()
        source.SetResolution(sides)
        axis = b - a
        length = np.linalg.norm(axis)
        matrix = vtk.vtkTransform()
        matrix.Translate(*((a + b) / 2))
        side = np.cross([0, 1, 0], axis)
        if np.linalg.norm(side) > 1e-9:
            matrix.RotateWXYZ(np.degrees(np.arccos(axis[1] / length)), *side)
        matrix.Scale(radius * 2, length, radius * 2)
        self.add(source, matrix, color)

    def mesh(self):
        self.append.Update()
        return self.append.GetOutput()


def chair(rng):
    p = Parts(rng)
    width, depth, seat = rng.uniform(.38, .55), rng.uniform(.38, .52), rng.uniform(.4, .5)
    back, lean, thick = rng.uniform(.3, .6), rng.uniform(0, 18), rng.uniform(.02, .1)
    soft = rng.choice([0, .2, .4]) if thick > .04 else 0
    front, rear = depth / 2, -depth / 2
    p.box((0, 0, seat - thick / 2), (depth, width, thick), 0, round_=soft)
    away = np.tan(np.radians(lean))
    kind = rng.choice(['solid', 'slats', 'bars', 'half', 'none'], p=[.35, .2, .15, .25, .05])
    post = rng.uniform(.012, .025)
    top = np.array([rear - away * back, 0, seat + back])
    if kind == 'solid':
        p.box((rear - away * back / 2, 0, seat + back / 2), (thick, width * rng.uniform(.8, 1), back), 0, lean, soft)
    elif kind == 'half':
        part = back * rng.uniform(.4, .7)
        p.box((rear - away * (back - part / 2), 0, seat + back - part / 2), (thick, width, part), 0, lean, soft)
    elif kind in ('slats', 'bars'):
        n = rng.integers(2, 6)
        for k in range(n):
            if kind == 'slats':
                share = (k + .7) / n
                p.box((rear - away * back * share, 0, seat + back * share), (.02, width, back / n * .45), 0, lean)
            else:
                y = width * ((k + .5) / n - .5)
                p.bar((rear, y, seat), (top[0], y, top[2]), post * .7, 0)
        p.box((top[0], 0, top[2]), (.03, width, .06), 0, lean)
    if kind not in ('solid', 'none'):
        for y in (-width / 2 + post, width / 2 - post) if rng.random() < .8 else (0,):
            p.bar((rear, y, seat - thick), (top[0], y, top[2]), post)
    base = rng.choice(['legs', 'star', 'cantilever', 'sled', 'pedestal'], p=[.5, .2, .15, .1, .05])
    splay = rng.uniform(0, .06)
    if base == 'legs':
        for x in (front - .03, rear + .03):
            for y in (-width / 2 + .03, width / 2 - .03):
                p.bar((x + np.sign(x) * splay, y + np.sign(y) * splay, 0), (x, y, seat - thick), post)
        if rng.random() < .4:
            for y in (-width / 2 + .03, width / 2 - .03):
                p.bar((front, y, seat * .4), (rear, y, seat * .4), post * .6)
    elif base == 'star':
        p.bar((0, 0, .08), (0, 0, seat - thick), .03)
        n = rng.integers(4, 6)
        for k in range(n):
            a = 2 * np.pi * k / n
            foot = np.array([np.cos(a), np.sin(a)]) * rng.uniform(.27, .33)
            p.bar((0, 0, .11), (*foot, .06), .02)
            p.box((*foot, .03), (.05, .05, .06), 2, round_=1)
    elif base == 'pedestal':
        p.bar((0, 0, 0), (0, 0, seat - thick), .035)
        p.bar((0, 0, 0), (0, 0, .02), .22, sides=24)
    else:
        for y in (-width / 2 + .02, width / 2 - .02):
            p.bar((front, y, 0), (front, y, seat - thick / 2), post)
            p.bar((front, y, post), (rear, y, post), post)
            if base == 'sled':
                p.bar((rear, y, 0), (rear, y, seat - thick / 2), post)
        p.bar((rear, -width / 2, post), (rear, width / 2, post), post)
    if rng.random() < .4:
        rest = seat + rng.uniform(.17, .25)
        for y in (-width / 2 - .02, width / 2 + .02):
            p.bar((front - .08, y, seat * rng.choice([0, 1])), (front - .08, y, rest), post)
            p.box(((front + rear) / 2, y, rest), (depth, rng.uniform(.03, .07), .03), rng.integers(3))
    return p.mesh()


def table(rng):
    p = Parts(rng)
    low = rng.random() < .25
    height = rng.uniform(.35, .5) if low else rng.uniform(.68, .8)
    length, width = rng.uniform(.6, 1.2 if low else 2.), rng.uniform(.55, 1.)
    thick = rng.uniform(.02, .06)
    round_ = rng.random() < .3
    if round_:
        width = length = rng.uniform(.6, 1.3)
        p.bar((0, 0, height - thick), (0, 0, height), width / 2, 0, 36)
    else:
        p.box((0, 0, height - thick / 2), (width, length, thick), 0)
    leg = rng.uniform(.015, .045)
    kind = rng.choice(['legs', 'pedestal', 'sides'], p=[.65, .2, .15])
    x, y = (width / 2 - .06) * (.65 if round_ else 1), (length / 2 - .06) * (.65 if round_ else 1)
    if kind == 'legs':
        for sx in (-1, 1):
            for sy in (-1, 1):
                if rng.random() < .5:
                    p.bar((sx * x, sy * y, 0), (sx * x, sy * y, height - thick), leg)
                else:
                    p.box((sx * x, sy * y, (height - thick) / 2), (leg * 2, leg * 2, height - thick), 1)
        if rng.random() < .5 and not round_:
            p.box((0, 0, height - thick - .04), (width - .12, length - .12, .08), 1)
    elif kind == 'pedestal':
        p.bar((0, 0, 0), (0, 0, height - thick), leg * 1.6)
        p.bar((0, 0, 0), (0, 0, .03), width * .3, sides=24)
    else:
        for sy in (-1, 1):
            p.box((0, sy * y, (height - thick) / 2), (width * .8, .04, height - thick), 1)
    return p.mesh()


def desk(rng):
    p = Parts(rng)
    length, width, height = rng.uniform(1.1, 1.8), rng.uniform(.6, .85), rng.uniform(.7, .78)
    p.box((0, 0, height - .015), (width, length, .03), 0)
    block = rng.uniform(.35, .5)
    for side in (-1, 1):
        y = side * (length / 2 - block / 2)
        if side == 1 or rng.random() < .3:
            p.box((0, y, (height - .03) / 2 + .03), (width * .9, block, height - .09), 1)
            for k in range(3):
                z = .15 + k * (height - .2) / 3
                p.box((width * .455, y, z), (.015, block * .9, (height - .2) / 3 * .85), 0)
                p.box((width * .47, y, z + .05), (.02, .12, .015), 2)
        else:
            for x in (-1, 1):
                p.bar((x * (width / 2 - .05), side * (length / 2 - .05), 0), (x * (width / 2 - .05), side * (length / 2 - .05), height), .025, 2)
    if rng.random() < .5:
        p.box((-width / 2 + .03, 0, height * .6), (.02, length * .95, height * .5), 1)
    return p.mesh()


def couch(rng):
    p = Parts(rng)
    width, depth = rng.uniform(.8, 2.3), rng.uniform(.75, 1.)
    seat, back, arm = rng.uniform(.36, .46), rng.uniform(.3, .5), rng.uniform(.1, .25)
    soft = rng.choice([0, .15, .3])
    p.box((0, 0, seat * .5), (depth, width, seat * .75), 0)
    n = max(1, round(width / .75))
    each = (width - 2 * arm) / n
    for k in range(n):
        y = -width / 2 + arm + each * (k + .5)
        p.box((.05, y, seat), (depth * .8, each * .97, .16), rng.choice([0, 0, 1]), round_=soft)
        p.box((-depth / 2 + .14, y, seat + back / 2), (.22, each * .97, back), 0, rng.uniform(5, 15), soft)
    for side in (-1, 1):
        if rng.random() < .92:
            p.box((0, side * (width - arm) / 2, seat * .75), (depth, arm, seat * 1.3), 0, round_=soft)
        for x in (-1, 1):
            p.bar((x * depth * .42, side * width * .42, 0), (x * depth * .42, side * width * .42, .12), .025, 2)
    return p.mesh()


def tv(rng):
    p = Parts(rng)
    width = rng.uniform(.45, 1.3)
    height, lift = width * rng.uniform(.54, .65), rng.uniform(.03, .18)
    p.colors[0] = [rng.uniform(.01, .1)] * 3 if rng.random() < .8 else p.colors[0]
    p.colors[1] = [c * rng.uniform(.2, 1) for c in ([.1, .1, .1] if rng.random() < .6 else paint(rng))]
    p.box((0, 0, lift + height / 2), (.04, width, height), 0)
    p.box((.0205, 0, lift + height / 2), (.002, width - .04, height - .04), 1)
    p.box((-.03, 0, lift + height / 2), (.05, width * .4, height * .5), 0)
    p.box((-.01, 0, lift / 2), (.03, .08, lift), 2)
    p.box((0, 0, .008), (.18, width * .4, .016), 2)
    return p.mesh()


def cabinet(rng):
    p = Parts(rng)
    low = rng.random() < .6
    width, depth = rng.uniform(.4, 1.7), rng.uniform(.3, .6)
    height = rng.uniform(.4, .95) if low else rng.uniform(1.4, 2.1)
    foot = rng.choice([0., .04, .12])
    p.box((0, 0, foot + (height - foot) / 2), (depth, width, height - foot), 0)
    columns, rows = rng.integers(1, 4), rng.integers(1, 4) if low else rng.integers(1, 3)
    cell = np.array([width / columns, (height - foot) / rows])
    for i in range(columns):
        for j in range(rows):
            y, z = -width / 2 + cell[0] * (i + .5), foot + cell[1] * (j + .5)
            p.box((depth / 2 + .008, y, z), (.016, cell[0] * .94, cell[1] * .94), rng.choice([0, 1]))
            p.box((depth / 2 + .03, y + cell[0] * rng.choice([0, .35]), z + cell[1] * .3), (.03, .08, .015), 2)
    for x in (-1, 1):
        for y in (-1, 1):
            if foot:
                p.bar((x * depth * .42, y * width * .45, 0), (x * depth * .42, y * width * .45, foot), .02, 2)
    return p.mesh()


def shelf(rng):
    p = Parts(rng)
    width, depth, height = rng.uniform(.5, 1.3), rng.uniform(.22, .4), rng.uniform(.8, 2.1)
    n = rng.integers(3, 7)
    for side in (-1, 1):
        p.box((0, side * (width / 2 - .01), height / 2), (depth, .025, height), 0)
    if rng.random() < .5:
        p.box((-depth / 2, 0, height / 2), (.01, width, height), 1)
    for k in range(n):
        z = .05 + (height - .07) * k / (n - 1)
        p.box((0, 0, z), (depth, width, .025), 0)
        y = -width / 2 + .05
        while k < n - 1 and y < width / 2 - .1 and rng.random() < .85:
            thick, tall = rng.uniform(.015, .08), rng.uniform(.1, min(.3, height / n))
            p.colors[2] = paint(rng)
            p.box((0, y + thick / 2, z + tall / 2 + .012), (depth * .7, thick, tall), 2)
            y += thick + rng.choice([.002, .002, .1])
    return p.mesh()


def lamp(rng):
    p = Parts(rng)
    height = rng.uniform(.35, .6) if rng.random() < .4 else rng.uniform(1.2, 1.8)
    shade, wide = rng.uniform(.15, .3), rng.uniform(.12, .24)
    p.colors[0] = [min(1, c + .5) for c in p.colors[0]] if rng.random() < .7 else p.colors[0]
    p.bar((0, 0, 0), (0, 0, .025), rng.uniform(.08, .16), 1, 24)
    p.bar((0, 0, 0), (0, 0, height - shade / 2), .012 if height > 1 else rng.uniform(.012, .05))
    p.bar((0, 0, height - shade), (0, 0, height), wide, 0, 24)
    return p.mesh()


def bed(rng):
    p = Parts(rng)
    width, length, height = rng.uniform(.9, 1.9), rng.uniform(1.9, 2.1), rng.uniform(.4, .6)
    p.box((0, 0, height * .3), (length, width, height * .5), 1)
    p.box((0, 0, height * .8), (length * .97, width * .97, height * .45), 0, round_=.15)
    p.box((-length / 2, 0, height), (.06, width, height * rng.uniform(1.6, 2.2)), 1)
    for y in ((-.25, .25) if width > 1.2 else (0,)):
        p.box((-length * .38, y * width, height * 1.05), (.4, width * .4 if width > 1.2 else width * .7, .14), 2, round_=.5)
    return p.mesh()


def refrigerator(rng):
    p = Parts(rng)
    p.colors[0] = [rng.uniform(.55, 1)] * 3 if rng.random() < .8 else p.colors[0]
    width, depth, height = rng.uniform(.5, .9), rng.uniform(.55, .7), rng.uniform(.85, 2.)
    p.box((0, 0, height / 2), (depth, width, height), 0)
    split = rng.uniform(.25, .7) * height
    for low, high in ((.03, split - .005), (split + .005, height)):
        p.box((depth / 2 + .015, 0, (low + high) / 2), (.03, width, high - low), 0)
        p.box((depth / 2 + .05, width * .42, (low + high) / 2), (.03, .02, (high - low) * .4), 2)
    return p.mesh()


def plant(rng):
    p = Parts(rng)
    pot, tall = rng.uniform(.1, .4), rng.uniform(.25, 1.2)
    p.bar((0, 0, 0), (0, 0, pot), pot * rng.uniform(.3, .55), 0, 20)
    for _ in range(rng.integers(12, 40)):
        p.colors[1] = [rng.uniform(.05, .35), rng.uniform(.25, .65), rng.uniform(.03, .25)]
        a, up, out = rng.uniform(0, 2 * np.pi), rng.uniform(.3, 1) * tall, rng.uniform(.1, .45) * tall
        tip = np.array([np.cos(a) * out, np.sin(a) * out, pot + up])
        p.bar((0, 0, pot), tip, .004, 1, 5)
        p.box(tip, (.06 + tall * .12, .03 + tall * .05, .02), 1, rng.uniform(-60, 60), .8)
    return p.mesh()


def cup(rng):
    p = Parts(rng)
    radius, height = rng.uniform(.032, .05), rng.uniform(.075, .12)
    p.bar((0, 0, 0), (0, 0, height), radius, 0, 24)
    p.colors[1] = [c * .3 for c in p.colors[0]]
    p.bar((0, 0, height * .99), (0, 0, height * 1.001), radius * .88, 1, 24)
    for a, b in (((radius, .8), (radius * 1.75, .7)), ((radius * 1.75, .7), (radius * 1.75, .35)), ((radius * 1.75, .35), (radius, .22))):
        p.bar((a[0] * .95, 0, a[1] * height), (b[0], 0, b[1] * height), .006, 0, 6)
    return p.mesh()


MAKERS = {'chair': chair, 'dining table': table, 'desk': desk, 'couch': couch, 'tv': tv, 'cabinet': cabinet, 'shelf': shelf,
          'lamp': lamp, 'bed': bed, 'refrigerator': refrigerator, 'potted plant': plant, 'cup': cup}


def database(folder):
    """(category, mesh) of the models of a folder that `plumbline models build` wrote."""
    if not os.path.exists(os.path.join(folder, 'models.json')):
        raise SystemExit("'%s' is not a database of models: it has no models.json" % folder)
    with open(os.path.join(folder, 'models.json')) as file:
        entries = json.load(file)['models']
    for entry in entries:
        reader = vtk.vtkPLYReader()
        reader.SetFileName(os.path.join(folder, entry['file']))
        reader.Update()
        yield entry['name'], entry['category'], reader.GetOutput()
