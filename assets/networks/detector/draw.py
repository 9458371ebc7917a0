#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Draws pictures of furniture at random, with the boxes of what is visible.

  xvfb-run -a ./draw.py --out pictures --count 20000 --photos bsds500/images/train bsds500/images/val --models furniture

Shapes come from shapes.py and from databases of models; each is stretched, painted and given light of its own. Photographs
are wallpaper, pictures on walls, cloth, and half of the backgrounds. OUT/N.jpg and OUT/N.json ([category, x0, y0, x1, y1] in
pixels); what is there already is not drawn again. The same seed draws the same pictures. Needs python3-vtk9, python3-opencv.
"""
import argparse
import glob
import json
import os

import cv2
import numpy as np
import vtk
from vtk.util import numpy_support

import catalog
import shapes

WIDTH, HEIGHT = 448, 336
LEAST_PIXELS, LEAST_SHARE = 120, .15  # of an object that is labelled
PIECE = 176  # pixels, the longer side of one drawn alone
LEFT_OUT = {'chair_slat', 'chair_slat_arms', 'chair_shell', 'table_rectangular', 'sofa_wide', 'lamp_floor', 'sideboard', 'tv_wide'}
CHANCE = {'chair': .34, 'dining table': .12, 'couch': .08, 'tv': .08, 'cabinet': .08, 'desk': .06, 'lamp': .05, 'shelf': .05,
          'potted plant': .04, 'cup': .05, 'bed': .025, 'refrigerator': .025}
RAISED = {'tv': .7, 'cup': .9, 'lamp': .3, 'potted plant': .4}  # how often it stands on something
HOLDS = {'dining table', 'desk', 'cabinet'}


class Photos:
    def __init__(self, folders, textures=None):
        self.textures = sorted(glob.glob(os.path.join(textures, '*.jpg'))) if textures else []
        self.files = sorted(f for folder in folders for f in glob.glob(os.path.join(folder, '*.jpg')))
        if not self.files:
            raise SystemExit('no .jpg in %s' % ' '.join(folders))

    def crop(self, rng, width, height):
        """BGR, of any part of a photograph."""
        image = cv2.imread(self.files[rng.integers(len(self.files))])
        scale = max(width / image.shape[1], height / image.shape[0]) * rng.uniform(1, 3)
        w, h = min(image.shape[1], int(width / scale) + 1), min(image.shape[0], int(height / scale) + 1)
        x, y = rng.integers(image.shape[1] - w + 1), rng.integers(image.shape[0] - h + 1)
        image = cv2.resize(image[y:y + h, x:x + w], (width, height))
        return image[:, ::-1] if rng.random() < .5 else image


def texture_of(image):
    data = vtk.vtkImageData()
    data.SetDimensions(image.shape[1], image.shape[0], 1)
    flat = np.ascontiguousarray(image[::-1, :, ::-1]).reshape(-1, 3)
    data.GetPointData().SetScalars(numpy_support.numpy_to_vtk(flat, deep=True))
    texture = vtk.vtkTexture()
    texture.SetInputData(data)
    texture.InterpolateOn()
    texture.RepeatOn()
    return texture


def actor_of(part, rng, photos, share_photo, share_own):
    """An actor with its own colours, other ones, or a photograph as cloth. A part: mesh, texture, RGB."""
    mesh, own_texture, own_color = part
    mapper, actor = vtk.vtkPolyDataMapper(), vtk.vtkActor()
    choice = rng.random()
    if choice < share_photo and np.count_nonzero(np.ptp(np.array(mesh.GetBounds()).reshape(3, 2), axis=1) > 1e-4) > 1:
        project = vtk.vtkTextureMapToPlane()
        project.SetInputData(mesh)
        low, high = np.array(mesh.GetBounds()).reshape(3, 2).T
        along = np.argsort(high - low)[1:][rng.permutation(2)]
        points = [low.copy() for _ in range(3)]
        points[1][along[0]], points[2][along[1]] = high[along[0]], high[along[1]]
        project.SetOrigin(*points[0])
        project.SetPoint1(*points[1])
        project.SetPoint2(*points[2])
        mapper.SetInputConnection(project.GetOutputPort())
        mapper.ScalarVisibilityOff()
        actor.SetTexture(texture_of(photos.crop(rng, 128, 128)))
    else:
        mapper.SetInputData(mesh)
        if choice > share_photo + share_own or (mesh.GetPointData().GetScalars() is None and own_color is None):
            mapper.ScalarVisibilityOff()
            actor.GetProperty().SetColor(*shapes.paint(rng))
            if own_texture and rng.random() < .5:
                actor.SetTexture(own_texture)
        elif own_color is not None:
            actor.GetProperty().SetColor(*own_color)
            if own_texture:
                actor.SetTexture(own_texture)
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetAmbient(rng.uniform(.05, .4))
    look.SetDiffuse(rng.uniform(.6, 1))
    look.SetSpecular(rng.choice([0, rng.uniform(0, .6)]))
    look.SetSpecularPower(rng.uniform(5, 60))
    look.SetInterpolation(rng.integers(2))
    return actor


def assembly_of(parts, rng, photos, share_photo):
    """What a model's parts make, in their own colours or in others."""
    assembly, share_own = vtk.vtkAssembly(), 1 if len(parts) > 1 and rng.random() < .55 else .55
    if share_own == 1:
        share_photo = 0
    for part in parts:
        assembly.AddPart(actor_of(part, rng, photos, share_photo, share_own * (1 - share_photo)))
    return assembly


def actors_of(prop):
    parts = prop.GetParts() if prop.IsA('vtkAssembly') else [prop]
    return [part for part in parts]


def half_bounds(parts):
    """Low and high corner of a model."""
    bounds = np.array([mesh.GetBounds() for mesh, _, _ in parts]).reshape(-1, 3, 2)
    return bounds[:, :, 0].min(0), bounds[:, :, 1].max(0)


class Scene:
    """Furniture on a floor, maybe in a room, in a renderer of its own."""

    def __init__(self, rng, photos, models):
        self.rng, self.photos, self.models = rng, photos, models
        self.renderer = vtk.vtkRenderer()
        self.objects, self.others, self.shades = [], [], []  # (prop, category), props
        self.half = rng.uniform(1.6, 3.2, 2)
        self.in_room = rng.random() < .7
        taken = []
        categories = list(CHANCE)
        count = rng.integers(2, 9) if rng.random() < .4 else rng.integers(5, 16)
        favourite = rng.choice(categories, p=np.array(list(CHANCE.values())) / sum(CHANCE.values()))
        for _ in range(count):
            category = favourite if rng.random() < .35 else rng.choice(categories, p=np.array(list(CHANCE.values())) / sum(CHANCE.values()))
            self.place(category, taken)
        for _ in range(rng.integers(0, 10) if count < 6 else rng.integers(6, 30)):
            self.clutter(taken)
        if self.in_room:
            self.shell()
        self.light()

    def shape(self, category):
        own = self.models.get(category, [])
        if own and self.rng.random() < min(.75, .1 * len(own)):
            return own[self.rng.integers(len(own))]
        return [(shapes.MAKERS[category](self.rng), None, None)]

    def place(self, category, taken):
        rng, parts = self.rng, self.shape(category)
        stretch = rng.uniform(.85, 1.18, 3)
        low, high = half_bounds(parts)
        extent = (high - low) * stretch / 2
        radius = np.hypot(extent[0], extent[1])
        holders = [(actor, c) for actor, c in self.objects if c in HOLDS]
        yaw = rng.choice([0, 90, 180, 270]) + rng.normal(0, 8) if rng.random() < .4 else rng.uniform(0, 360)
        if holders and rng.random() < RAISED.get(category, 0):
            low_x, high_x, low_y, high_y, _, z = holders[rng.integers(len(holders))][0].GetBounds()
            x, y = rng.uniform(.75 * low_x + .25 * high_x, .25 * low_x + .75 * high_x), rng.uniform(.75 * low_y + .25 * high_y, .25 * low_y + .75 * high_y)
        else:
            for _ in range(12):
                x, y = rng.uniform(-self.half, self.half)
                if all(np.hypot(x - a, y - b) > .75 * (radius + r) for a, b, r in taken):
                    break
            else:
                return
            z = rng.uniform(.6, 1.6) if category == 'tv' and rng.random() < .3 else rng.uniform(.4, 1.) if category == 'cup' else 0
            if z == 0:
                taken.append((x, y, radius))
        actor = assembly_of(parts, rng, self.photos, .2)
        actor.SetScale(*stretch)
        actor.SetPosition(x, y, z)
        actor.RotateZ(yaw)
        self.renderer.AddActor(actor)
        self.objects.append((actor, category))
        if z == 0 and rng.random() < .7:
            self.shade(x, y, yaw, extent)
        if category in HOLDS and category != 'cabinet' and rng.random() < .6:
            self.seats(x, y, yaw, extent)

    def seats(self, x, y, yaw, extent):
        """Equal chairs around a table, as people leave them."""
        rng, parts, looks = self.rng, self.shape('chair'), self.rng.integers(2 ** 31)
        for side in rng.permutation(6)[:rng.integers(1, 7)]:
            along, across = (0, 1) if side < 4 else (1, 0)
            out = extent[across] + rng.uniform(-.15, .35)
            offset = np.zeros(2)
            offset[across] = out if side % 2 else -out
            offset[along] = (rng.uniform(.3, .6) * extent[along] * (1 if side % 4 < 2 else -1) if side < 4 else 0) + rng.normal(0, .06)
            turn = np.radians(yaw)
            at = np.array([x, y]) + np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ offset
            prop = assembly_of(parts, np.random.default_rng(looks), self.photos, .2)
            prop.SetPosition(*at, 0)
            prop.RotateZ(yaw + np.degrees(np.arctan2(-offset[1], -offset[0])) + rng.choice([0, 90, 180], p=[.6, .2, .2]) + rng.normal(0, 20))
            self.renderer.AddActor(prop)
            self.objects.append((prop, 'chair'))

    def shade(self, x, y, yaw, extent):
        """The dark that furniture leaves on the floor below it."""
        image = np.zeros((64, 64, 4), np.uint8)
        side = np.clip((1.25 - np.abs(np.linspace(-1.4, 1.4, 64))) * 3, 0, 1)
        image[:, :, 3] = 255 * self.rng.uniform(.2, .6) * np.outer(side, side)
        data, texture, source = vtk.vtkImageData(), vtk.vtkTexture(), vtk.vtkPlaneSource()
        data.SetDimensions(64, 64, 1)
        data.GetPointData().SetScalars(numpy_support.numpy_to_vtk(image.reshape(-1, 4), deep=True))
        texture.SetInputData(data)
        mapper, actor = vtk.vtkPolyDataMapper(), vtk.vtkActor()
        mapper.SetInputConnection(source.GetOutputPort())
        actor.SetMapper(mapper)
        actor.SetTexture(texture)
        actor.GetProperty().LightingOff()
        actor.SetScale(2.8 * extent[0], 2.8 * extent[1], 1)
        actor.SetPosition(x, y, .004)
        actor.RotateZ(yaw)
        self.renderer.AddActor(actor)
        self.shades.append(actor)

    def clutter(self, taken):
        """Boxes, balls and rolls, and things of a catalog, that are nothing."""
        rng, things = self.rng, self.models.get('', [])
        if things and rng.random() < .6:
            parts = things[rng.integers(len(things))]
            actor = assembly_of(parts, rng, self.photos, .1)
            z = 0
            x, y = rng.uniform(-self.half, self.half) * 1.1
            holders = [(a, c) for a, c in self.objects if c in HOLDS]
            if half_bounds(parts)[1][2] < .5 and holders and rng.random() < .8:
                low_x, high_x, low_y, high_y, _, z = holders[rng.integers(len(holders))][0].GetBounds()
                x, y = rng.uniform(low_x, high_x), rng.uniform(low_y, high_y)
            actor.SetPosition(x, y, z)
            actor.RotateZ(rng.uniform(0, 360))
            self.renderer.AddActor(actor)
            self.others.append(actor)
            return
        source = [vtk.vtkCubeSource, vtk.vtkSphereSource, vtk.vtkCylinderSource, vtk.vtkConeSource, vtk.vtkCubeSource][rng.integers(5)]()
        source.Update()
        size = np.exp(rng.uniform(np.log(.05), np.log(.6), 3))
        actor = actor_of((source.GetOutput(), None, None), rng, self.photos, .5, .2)
        x, y = rng.uniform(-self.half, self.half) * 1.1
        z = 0
        if self.objects and rng.random() < .4:
            low_x, high_x, low_y, high_y, _, z = self.objects[rng.integers(len(self.objects))][0].GetBounds()
            x, y, size = rng.uniform(low_x, high_x), rng.uniform(low_y, high_y), size * .35
        actor.SetScale(*size)
        actor.SetPosition(x, y, z + size[2] / 2)
        actor.RotateZ(rng.uniform(0, 360))
        self.renderer.AddActor(actor)
        self.others.append(actor)

    def plane(self, origin, a, b, image, repeat):
        source = vtk.vtkPlaneSource()
        source.SetOrigin(*origin)
        source.SetPoint1(*a)
        source.SetPoint2(*b)
        source.SetResolution(12, 12)
        source.Update()
        mesh = source.GetOutput()
        coordinates = numpy_support.vtk_to_numpy(mesh.GetPointData().GetTCoords())
        coordinates *= repeat
        mapper, actor = vtk.vtkPolyDataMapper(), vtk.vtkActor()
        mapper.SetInputData(mesh)
        actor.SetMapper(mapper)
        if image is None:
            actor.GetProperty().SetColor(*shapes.paint(self.rng))
        else:
            actor.SetTexture(texture_of(image))
        actor.GetProperty().SetAmbient(self.rng.uniform(.1, .5))
        self.renderer.AddActor(actor)
        self.others.append(actor)

    def surface(self):
        """Plain, a photograph, boards, tiles."""
        rng, choice = self.rng, self.rng.random()
        if choice < .4:
            return None, 1
        if choice < .65:
            if self.photos.textures and rng.random() < .6:
                image = cv2.imread(self.photos.textures[rng.integers(len(self.photos.textures))])
                return np.clip(image * rng.uniform(.5, 1.3) * rng.uniform(.85, 1.15, 3), 0, 255).astype(np.uint8), rng.uniform(3, 12)
            return self.photos.crop(rng, 256, 256), rng.uniform(.5, 3)
        base = 255 * np.array(shapes.paint(rng))[::-1]
        image = np.clip(base + rng.normal(0, rng.uniform(2, 15), (128, 128, 1)), 0, 255)
        image = cv2.GaussianBlur(image, (0, 0), rng.uniform(.5, 3), rng.uniform(.5, 12))
        lines = base * rng.uniform(.4, 1.3)
        for k in range(0, 128, int(rng.choice([16, 32, 64]))):
            image[k:k + 2] = lines
            if choice > .85:
                image[:, k:k + 2] = lines
        return np.clip(image, 0, 255).astype(np.uint8), rng.uniform(2, 8)

    def shell(self):
        rng, (a, b) = self.rng, self.half + .4
        far = 2.5
        self.plane((-a - far, -b - far, 0), (a + far, -b - far, 0), (-a - far, b + far, 0), *self.surface())
        wall = self.surface()
        top = rng.uniform(2.3, 3)
        corners = [(-a, -b), (a, -b), (a, b), (-a, b)]
        for k in range(4):
            (x0, y0), (x1, y1) = corners[k], corners[(k + 1) % 4]
            if rng.random() < .85:
                self.plane((x0, y0, 0), (x1, y1, 0), (x0, y0, top), *(wall if rng.random() < .7 else self.surface()))
            for _ in range(rng.integers(0, 4)):  # pictures and windows
                along, low = rng.uniform(.1, .8), rng.uniform(.5, 1.7)
                size, inward = np.array([rng.uniform(.2, 1.2), rng.uniform(.2, 1.)]), .99
                d = np.array([x1 - x0, y1 - y0]) / np.hypot(x1 - x0, y1 - y0)
                p = np.array([x0, y0]) * inward + d * along * np.hypot(x1 - x0, y1 - y0)
                q = p + d * size[0]
                self.plane((*p, low), (*q, low), (*p, low + size[1]), self.photos.crop(rng, 128, 128) if rng.random() < .7 else None, 1)

    def light(self):
        rng = self.rng
        self.renderer.RemoveAllLights()
        self.renderer.AutomaticLightCreationOff()
        for _ in range(rng.integers(2, 5)):
            light = vtk.vtkLight()
            light.SetPositional(rng.random() < .7)
            light.SetPosition(*rng.uniform(-self.half, self.half), rng.uniform(1.2, 3))
            light.SetFocalPoint(*rng.uniform(-1, 1, 2), 0)
            light.SetConeAngle(180)
            tint = 1 - rng.uniform(0, .3) * np.array([0, .5, 1]) if rng.random() < .6 else 1 - rng.uniform(0, .3) * np.array([1, .4, 0])
            light.SetColor(*tint)
            light.SetIntensity(rng.uniform(.4, 1.1))
            self.renderer.AddLight(light)
        self.renderer.SetAmbient(*([rng.uniform(.3, 1)] * 3))

    def view(self):
        """A camera in a hand, at something."""
        rng, camera = self.rng, self.renderer.GetActiveCamera()
        aim = np.array(self.objects[rng.integers(len(self.objects))][0].GetCenter()) if self.objects else np.zeros(3)
        aim = aim + rng.normal(0, .3, 3)
        for _ in range(20):
            angle, distance = rng.uniform(0, 2 * np.pi), np.exp(rng.uniform(np.log(.9), np.log(4.5)))
            at = np.array([aim[0] + distance * np.cos(angle), aim[1] + distance * np.sin(angle), rng.uniform(.7, 1.9)])
            if not self.in_room or np.all(np.abs(at[:2]) < self.half + .35):
                break
        camera.SetPosition(*at)
        camera.SetFocalPoint(*aim)
        camera.SetViewUp(0, 0, 1)
        camera.SetViewAngle(rng.uniform(38, 65))
        camera.SetRoll(camera.GetRoll() + rng.normal(0, 5))
        camera.SetClippingRange(.1, 30)


class Drawer:
    def __init__(self):
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(WIDTH, HEIGHT)

    def grab(self):
        self.window.Render()
        grabber = vtk.vtkWindowToImageFilter()
        grabber.SetInput(self.window)
        grabber.ReadFrontBufferOff()
        grabber.Update()
        return numpy_support.vtk_to_numpy(grabber.GetOutput().GetPointData().GetScalars()).reshape(HEIGHT, WIDTH, 3)[::-1]

    def draw(self, scene):
        """BGR picture, where there is anything, and for each object its visible pixels and how many of it would show alone."""
        scene.renderer.SetBackground(0, 0, 0)
        self.window.AddRenderer(scene.renderer)
        scene.renderer.UseFXAAOn()
        picture = self.grab()[:, :, ::-1].copy()
        scene.renderer.UseFXAAOff()
        everything = [(a, k + 1) for k, (a, _) in enumerate(scene.objects)] + [(a, 255) for a in scene.others]
        for prop in scene.shades:
            prop.VisibilityOff()
        for prop, number in everything:
            for actor in actors_of(prop):
                actor.SetTexture(None)
                actor.GetMapper().ScalarVisibilityOff()
                actor.GetProperty().LightingOff()
                actor.GetProperty().SetOpacity(1)
                actor.GetProperty().SetAmbient(1)
                actor.GetProperty().SetDiffuse(0)
                actor.GetProperty().SetColor(number / 255, 0, 0)
        numbers = self.grab()[:, :, 0].copy()
        alone = []
        for actor, _ in everything:
            actor.VisibilityOff()
        for actor, _ in scene.objects:
            actor.VisibilityOn()
            alone.append(int(np.count_nonzero(self.grab()[:, :, 0])))
            actor.VisibilityOff()
        self.window.RemoveRenderer(scene.renderer)
        return picture, numbers, alone


def boxes_of(scene, numbers, alone):
    for k, (_, category) in enumerate(scene.objects):
        rows, columns = np.nonzero(numbers == k + 1)
        if len(rows) >= LEAST_PIXELS and len(rows) >= LEAST_SHARE * alone[k]:
            yield [category, int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1]


def draw_alone(drawer, rng, photos, models, file):
    """One piece before nothing: FILE.webp, at most PIECE px wide and high, and FILE.json with its category ('' for none of ours)."""
    scene = Scene.__new__(Scene)
    scene.rng, scene.photos, scene.models, scene.renderer = rng, photos, models, vtk.vtkRenderer()
    scene.objects, scene.others, scene.shades, scene.half, scene.in_room = [], [], [], np.array([2., 2.]), False
    category = '' if rng.random() < .3 and models.get('') else rng.choice(list(CHANCE), p=np.array(list(CHANCE.values())) / sum(CHANCE.values()))
    parts = models[''][rng.integers(len(models['']))] if category == '' else scene.shape(category)
    prop = assembly_of(parts, rng, photos, .2)
    prop.SetScale(*rng.uniform(.85, 1.18, 3))
    prop.RotateZ(rng.uniform(0, 360))
    scene.renderer.AddActor(prop)
    scene.objects.append((prop, category))
    scene.light()
    low, high = np.array(prop.GetBounds()).reshape(3, 2).T
    reach, aim = np.linalg.norm(high - low), (low + high) / 2
    up, angle = np.radians(rng.uniform(0, 45)), rng.uniform(0, 2 * np.pi)
    distance = reach * np.exp(rng.uniform(np.log(.9), np.log(2.5)))
    camera = scene.renderer.GetActiveCamera()
    camera.SetPosition(*(aim + distance * np.array([np.cos(up) * np.cos(angle), np.cos(up) * np.sin(angle), np.sin(up)])))
    camera.SetFocalPoint(*aim)
    camera.SetViewUp(0, 0, 1)
    camera.SetViewAngle(2 * np.degrees(np.arctan(reach * .62 / distance)))
    camera.SetRoll(camera.GetRoll() + rng.normal(0, 4))
    camera.SetClippingRange(reach * .05, reach * 6)
    picture, numbers, _ = drawer.draw(scene)
    rows, columns = np.nonzero(numbers)
    if len(rows) < LEAST_PIXELS:
        return
    cut = np.s_[rows.min():rows.max() + 1, columns.min():columns.max() + 1]
    alpha = np.where(numbers[cut] > 0, 255, 0).astype(np.uint8)[:, :, None]
    piece = np.concatenate((np.where(alpha > 0, picture[cut], 0), alpha), 2)
    share = min(1, PIECE / max(piece.shape[:2]))
    piece = cv2.resize(piece, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    cv2.imwrite(file + '.webp', piece, [cv2.IMWRITE_WEBP_QUALITY, 80])
    with open(file + '.new', 'w') as out:
        json.dump(category, out)
    os.replace(file + '.new', file + '.json')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--out', required=True)
    parser.add_argument('--count', type=int, required=True)
    parser.add_argument('--first', type=int, default=0)
    parser.add_argument('--photos', nargs='+', required=True, help='folders of .jpg')
    parser.add_argument('--models', nargs='*', default=[], help='databases of models; those of the demo are left out')
    parser.add_argument('--textures', help='folder of .jpg for floors and walls')
    parser.add_argument('--catalogs', help='folder with the unpacked catalogs of sweethome3d-furniture')
    parser.add_argument('--alone', action='store_true', help='single pieces instead: BGR times alpha, and alpha, as .webp; a third of them nothing of ours')
    args = parser.parse_args()
    photos, models = Photos(args.photos, args.textures), {}
    for folder in args.models:
        for name, category, mesh in shapes.database(folder):
            if category in CHANCE and name not in LEFT_OUT:
                models.setdefault(category, []).append([(mesh, None, None)])
    for category, parts in catalog.models(args.catalogs) if args.catalogs else []:
        models.setdefault(category, []).append(parts)
    os.makedirs(args.out, exist_ok=True)
    drawer = Drawer()
    for number in range(args.first, args.first + args.count):
        file = os.path.join(args.out, '%06d' % number)
        if os.path.exists(file + '.json'):
            continue
        rng = np.random.default_rng([7, number])
        if args.alone:
            draw_alone(drawer, rng, photos, models, file)
            continue
        scene = Scene(rng, photos, models)
        scene.view()
        picture, numbers, alone = drawer.draw(scene)
        if np.any(numbers == 0):
            picture = np.where((numbers > 0)[:, :, None], picture, photos.crop(rng, WIDTH, HEIGHT))
        cv2.imwrite(file + '.jpg', picture, [cv2.IMWRITE_JPEG_QUALITY, 92])
        with open(file + '.new', 'w') as out:
            json.dump(list(boxes_of(scene, numbers, alone)), out)
        os.replace(file + '.new', file + '.json')


if __name__ == '__main__':
    main()
