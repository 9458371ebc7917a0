#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Exports a random Faster R-CNN and writes what torchvision itself makes of two images: two_stage_reference.py FOLDER MODEL [SIZE].

Exits with 77 where torch or torchvision are not installed. Boxes are [px of the input] from its edge.
"""
import json
import pathlib
import sys

try:
    import torch
    import torchvision  # noqa: F401
except ImportError as error:
    print(error)
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / 'assets/networks'))
import export_torchvision  # noqa: E402
from torchvision.models.detection.image_list import ImageList  # noqa: E402


def some_boxes(width, height, count):
    """Corners at quarters of a pixel, small and large."""
    sides = torch.rand(count, 2) ** 2 * torch.tensor([width - 2., height - 2.]) + 1
    corners = torch.rand(count, 2) * (torch.tensor([float(width), float(height)]) - sides)
    return ((torch.cat((corners, corners + sides), 1) * 4).round() / 4)


def answers(model, image, size, levels_file):
    """What torchvision says of an image that is padded to `size`; what its trunk says goes into a file of floats."""
    kept = []
    filter_proposals = model.rpn.filter_proposals
    model.rpn.filter_proposals = lambda *args: kept.append(filter_proposals(*args)) or kept[-1]
    shape = tuple(image.shape[-2:])
    padded = torch.zeros(1, 3, size[1], size[0])
    padded[0, :, :shape[0], :shape[1]] = model.transform.normalize(image.float() / 255)
    features = model.backbone(padded)
    levels = export_torchvision.Trunk(model)(padded)
    levels_file.write_bytes(b''.join(level.numpy().tobytes() for level in levels))
    proposals, _ = model.rpn(ImageList(padded, [shape]), features)
    heads = model.roi_heads
    found = heads(features, proposals, [shape])[0][0]
    boxes = some_boxes(shape[1], shape[0], 300)
    logits, deltas = heads.box_predictor(heads.box_head(heads.box_roi_pool(features, [boxes], [shape])))
    moved = heads.box_coder.decode(deltas, [boxes])
    model.rpn.filter_proposals = filter_proposals
    as_list = lambda tensor: tensor.double().numpy().round(7).tolist()
    return {'shapes': [list(level.shape) for level in levels], 'proposals': as_list(proposals[0]), 'proposal_scores': as_list(kept[0][1][0]), 'boxes': as_list(boxes),
            'probabilities': as_list(logits.softmax(-1)), 'moved': as_list(moved[:, 1:4].flatten(1)),
            'found': as_list(found['boxes']), 'found_scores': as_list(found['scores']),
            'found_labels': found['labels'].tolist()}


@torch.no_grad()
def main():
    folder, name = pathlib.Path(sys.argv[1]), sys.argv[2]
    size = ['--size', sys.argv[3]] if len(sys.argv) > 3 else []
    file = str(folder / 'net.onnx')
    model, size, names = export_torchvision.build(
        export_torchvision.options().parse_args([file, '--model', name, '--random', '3'] + size))
    export_torchvision.export(model, file, size, names)
    torch.manual_seed(4)
    cases = []
    # Padded to the right, and below.
    for i, shape in enumerate(((size[0] - 22, size[1]), (size[0], size[1] - 50))):
        image = export_torchvision.random_picture(*shape)
        header = f'P6\n{shape[0]} {shape[1]}\n255\n'.encode()
        (folder / f'{i}.ppm').write_bytes(header + image.permute(1, 2, 0).contiguous().numpy().tobytes())
        cases.append(answers(model, image, size, folder / f'{i}.levels'))
    (folder / 'reference.json').write_text(json.dumps(cases))


if __name__ == '__main__':
    main()
