#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Exports random networks that end as YOLOs do, and writes which boxes torch finds in an image: yolo_reference.py FOLDER.

Exits with 77 where torch is not installed. Boxes are [px] with pixel centres at integers, clipped to the image.
"""
import json
import pathlib
import sys
import warnings

try:
    import onnx
    import torch
    from torch import nn
except ImportError as error:
    print(error)
    sys.exit(77)

HEIGHT, WIDTH, STRIDES, BINS, MASKS = 96, 160, (8, 16, 32), 16, 32
NAMES = ['chair', 'couch', 'cup', 'vase', 'bed']
ANCHORS = torch.tensor([[10, 13, 16, 30, 33, 23], [30, 61, 62, 45, 59, 119], [116, 90, 156, 198, 373, 326]]).float().view(3, 3, 2)


class Trunk(nn.Module):
    """Three levels; parts by chunk, attention on the last."""

    def __init__(self):
        super().__init__()
        self.stem = nn.Conv2d(3, 16, 8, 8)
        self.down = nn.ModuleList(nn.Conv2d(16, 16, 3, 2, 1) for _ in range(2))
        self.keys = nn.Conv2d(16, 32, 1)

    def forward(self, image):
        levels = [self.stem(image)]
        for down in self.down:
            one, two = levels[-1].chunk(2, 1)
            levels.append(down(torch.cat((two, nn.functional.silu(one)), 1)))
        last = levels[-1]
        batch, channels, rows, columns = last.shape
        query, key, value = self.keys(last).view(batch, 2, 16, rows * columns).split([4, 4, 8], 2)
        weights = (query.transpose(-2, -1) @ key * 0.5).softmax(-1)
        levels[-1] = last + (value @ weights.transpose(-2, -1)).view(batch, channels, rows, columns)
        return levels


class Distances(nn.Module):
    """Heads of YOLOv8 (bins, level by level) to YOLO26 (no bins), perhaps with masks, perhaps choosing boxes."""
    kind = 'yolov8'

    def __init__(self, bins=BINS, by_level=True, masks=0, chosen=0):
        super().__init__()
        self.bins, self.by_level, self.chosen, self.fixed = bins, by_level, chosen, None
        last = lambda channels: nn.ModuleList(nn.Conv2d(16, channels, 1) for _ in STRIDES)
        self.sides, self.scores, self.masks = last(4 * bins), last(len(NAMES)), last(masks) if masks else None
        for sides in self.sides if bins == 1 else ():
            sides.bias.data += 2
        self.mean = nn.Conv2d(bins, 1, 1, bias=False)
        self.mean.weight.data[:] = torch.arange(float(bins)).view(1, bins, 1, 1)

    def grids(self, levels):
        """Middles of all cells, 2 x N, and their strides, 1 x N."""
        middles, strides = [], []
        for level, stride in zip(levels, STRIDES):
            rows, columns = level.shape[2:]
            y, x = torch.meshgrid(torch.arange(rows) + 0.5, torch.arange(columns) + 0.5, indexing='ij')
            middles.append(torch.stack((x, y)).view(2, -1))
            strides.append(torch.full((1, rows * columns), float(stride)))
        return torch.cat(middles, 1), torch.cat(strides, 1)

    def flat(self, parts, channels):
        return torch.cat([part.view(part.shape[0], channels, -1) for part in parts], 2)

    def forward(self, levels):
        sides = [last(level) for last, level in zip(self.sides, levels)]
        scores = [last(level) for last, level in zip(self.scores, levels)]
        if self.by_level:
            both = self.flat([torch.cat(pair, 1) for pair in zip(sides, scores)], 4 * self.bins + len(NAMES))
            sides, scores = both.split((4 * self.bins, len(NAMES)), 1)
        else:
            sides, scores = self.flat(sides, 4 * self.bins), self.flat(scores, len(NAMES))
        batch, _, cells = sides.shape
        if self.bins > 1:
            sides = self.mean(sides.view(batch, 4, self.bins, cells).transpose(2, 1).softmax(1)).view(batch, 4, cells)
        middles, strides = self.fixed or self.grids(levels)
        near, far = sides.chunk(2, 1)
        near, far = middles.unsqueeze(0) - near, middles.unsqueeze(0) + far
        boxes = torch.cat((near, far) if self.chosen else ((near + far) / 2, far - near), 1) * strides
        output = torch.cat((boxes, scores.sigmoid()), 1)
        if self.masks:
            output = torch.cat((output, self.flat([m(level) for m, level in zip(self.masks, levels)], MASKS)), 1)
        return self.choose(output.transpose(1, 2)) if self.chosen else output

    def choose(self, table):
        boxes, scores = table.split([4, len(NAMES)], -1)
        best, index = scores.flatten(1).topk(self.chosen)
        rows = (index // len(NAMES)).unsqueeze(-1)
        return torch.cat((boxes.gather(1, rows.repeat(1, 1, 4)), best.unsqueeze(-1), (index % len(NAMES)).unsqueeze(-1).float()), -1)


class Anchored(nn.Module):
    """The head of YOLOv5."""
    kind = 'yolov5'

    def __init__(self, masks=0):
        super().__init__()
        self.parts = (2, 2, 1 + len(NAMES)) + ((masks,) if masks else ())
        self.numbers, self.fixed = sum(self.parts), None
        self.last = nn.ModuleList(nn.Conv2d(16, 3 * self.numbers, 1) for _ in STRIDES)

    def grids(self, levels):
        """Corners of all cells and sizes of their anchors."""
        grids = []
        for level, anchors in zip(levels, ANCHORS):
            rows, columns = level.shape[2:]
            y, x = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing='ij')
            corners = (torch.stack((x, y), 2).float() - 0.5).expand(1, 3, rows, columns, 2)
            grids.append((corners.contiguous(), anchors.view(1, 3, 1, 1, 2).expand(1, 3, rows, columns, 2).contiguous()))
        return grids

    def forward(self, levels):
        tables = []
        for level, last, stride, (corners, sizes) in zip(levels, self.last, STRIDES, self.fixed or self.grids(levels)):
            rows, columns = level.shape[2:]
            grid = last(level).view(1, 3, self.numbers, rows, columns).permute(0, 1, 3, 4, 2).contiguous()
            middle, size, scores, *masks = grid.split(self.parts, 4)
            parts = ((middle.sigmoid() * 2 + corners) * stride, (size.sigmoid() * 2) ** 2 * sizes, scores.sigmoid(), *masks)
            tables.append(torch.cat(parts, 4).view(1, -1, self.numbers))
        return torch.cat(tables, 1)


class Network(nn.Module):
    def __init__(self, head, masks=0):
        super().__init__()
        self.trunk, self.head = Trunk(), head
        self.masks = nn.Conv2d(16, masks, 1) if masks else None

    def forward(self, image):
        levels = self.trunk(image)
        output = self.head(levels)
        return (output, self.masks(levels[0])) if self.masks else output


def found(output, kind):
    """[corners, score, category] of every cell's best category, as the program proposes them."""
    table = output[0].T if kind == 'yolov8' else output[0]
    scores = table[:, 5:5 + len(NAMES)] * table[:, 4:5] if kind == 'yolov5' else table[:, 4:4 + len(NAMES)]
    best, category = scores.max(1)
    low, high = table[:, :2] - table[:, 2:4] / 2, table[:, :2] + table[:, 2:4] / 2
    size = torch.tensor([float(WIDTH), float(HEIGHT)])
    corners = torch.cat((low.clamp(min=0).minimum(size), high.clamp(min=0).minimum(size)), 1) - 0.5
    keep = (best > 0.11) & (corners[:, 2:] - corners[:, :2] > 0.1).all(1)
    return torch.cat((corners, best[:, None], category[:, None].float()), 1)[keep].double().numpy().round(6).tolist()


@torch.no_grad()
def main():
    folder = pathlib.Path(sys.argv[1])
    torch.manual_seed(5)
    image = torch.randint(0, 256, (HEIGHT, WIDTH, 3), dtype=torch.uint8)
    (folder / 'image.ppm').write_bytes(f'P6\n{WIDTH} {HEIGHT}\n255\n'.encode() + image.numpy().tobytes())
    image = image.permute(2, 0, 1)[None].float() / 255
    heads = {'v8': Distances, 'v8_apart': lambda: Distances(by_level=False), 'v8_masks': lambda: Distances(masks=MASKS), 'v10': lambda: Distances(chosen=50),
             'v26': lambda: Distances(1, False, chosen=50), 'v26_all': lambda: Distances(1, False), 'v5': Anchored, 'v5_masks': lambda: Anchored(MASKS)}
    reference = {}
    for (name, head), opset, is_open in ((h, o, f) for h in heads.items() for o in (11, 12, 13, 17) for f in (False, True)):
        if is_open and name.startswith('v5'):
            continue
        torch.manual_seed(5)
        network = Network(head(), MASKS if 'masks' in name else 0).eval()
        for part in network.modules():
            if isinstance(part, nn.Conv2d) and part.bias is not None:
                part.weight.mul_(3)
        chosen, network.head.chosen = getattr(network.head, 'chosen', 0), 0
        output = network(image)
        reference[f'{name}_{opset}' + '_open' * is_open] = {
            'kind': network.head.kind, 'boxes': found(output[0] if 'masks' in name else output, network.head.kind)}
        network.head.chosen = chosen
        # As Ultralytics' exporter, which computes the cells' middles before; with open sizes the network does.
        network.head.fixed = None if is_open else network.head.grids(network.trunk(image))
        file = str(folder / f'{name}_{opset}{"_open" * is_open}.onnx')
        torch.onnx.export(network, image, file, opset_version=opset, input_names=['images'],
                          dynamic_axes={'images': {0: 'batch', 2: 'height', 3: 'width'}} if is_open else None)
        model = onnx.load(file)
        onnx.helper.set_model_props(model, {'names': str(dict(enumerate(NAMES))), 'imgsz': str([HEIGHT, WIDTH])})
        onnx.save(model, file)
    (folder / 'reference.json').write_text(json.dumps(reference))


if __name__ == '__main__':
    warnings.simplefilter('ignore')
    main()
