#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Trains the detector that ships (README.md beside this file has its recipe).

  train.py --photos bsds500/images/train bsds500/images/val --drawn scenes --rooms office/* --pieces pieces --teacher picodet_s_416.onnx \
    --minutes 8 --out build/networks/detector

It learns three things at once: what the teacher, a published detector of COCO, says and computes of every picture; where
furniture stands in drawn pictures; and, of photographs, the boxes that the teacher is sure of. Writes OUT/detector.pt now and
then (run the same command again to go on), OUT/log.csv and OUT/weights.pt, of which export.py makes the detector. Needs torch,
torchvision, OpenCV and onnx for Python; a GPU or patience.
"""
import argparse
import os
import sys
import time

import torch
from torch import nn
from torch.nn import functional as F
from torchvision.models.detection.image_list import ImageList
from torchvision.ops import batched_nms

import compose
import detector_net
import teacher as teachers

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
from training import Training  # noqa: E402

SIDE = 416  # pixels, of training pictures
EMA = .999
SURE, MAYBE = .4, .25  # a teacher's box of a photograph is one; is neither one nor none
TEACHER_BOXES = 12
ROIS = {'jittered': 20, 'proposed': 32, 'random': 12}  # a picture
HALF_RIGHT = (.35, .65)  # IoU from which a box is a little its object, and from which wholly


class Student(nn.Module):
    """The detector, and adapters that make its features the teacher's, which training alone needs."""

    def __init__(self):
        super().__init__()
        self.detector = detector_net.detector_net()
        self.adapters = nn.ModuleList([nn.Sequential(nn.Conv2d(detector_net.CHANNELS, 96, 1), nn.BatchNorm2d(96), nn.Hardswish(), nn.Conv2d(96, 96, 3, padding=1, groups=96),
                                                     nn.Conv2d(96, 96, 1)) for _ in range(3)])


def iou(a, b):
    """... x n x 4 with ... x m x 4."""
    low = torch.maximum(a[..., :, None, :2], b[..., None, :, :2])
    high = torch.minimum(a[..., :, None, 2:], b[..., None, :, 2:])
    common = (high - low).clamp(min=0).prod(-1)
    area = lambda x: (x[..., 2:] - x[..., :2]).clamp(min=0).prod(-1)  # noqa: E731
    return common / (area(a)[..., :, None] + area(b)[..., None, :] - common).clamp(min=1e-6)


def teacher_boxes(outputs, categories):
    """What the teacher sees of ours: per picture TEACHER_BOXES boxes, categories (0 where there are fewer), scores."""
    numbers = torch.tensor([teachers.COCO[c] for c in categories if c in teachers.COCO], device=outputs[0].device)
    ours = torch.tensor([1 + k for k, c in enumerate(categories) if c in teachers.COCO], device=outputs[0].device)
    scores, corners = [], []
    for output, stride in zip(outputs, teachers.STRIDES):
        score, corner = teachers.boxes_of(output, stride)
        scores.append(score[:, numbers].flatten(2))
        corners.append(corner.flatten(2))
    scores, corners = torch.cat(scores, 2), torch.cat(corners, 2)
    count, kinds, cells = scores.shape
    best, where = scores.flatten(1).topk(100, 1)
    kind, cell = where // cells, where % cells
    boxes = corners.permute(0, 2, 1).gather(1, cell[:, :, None].expand(-1, -1, 4)).clamp(0, SIDE)
    picture = torch.arange(count, device=best.device)[:, None].expand_as(best)
    kept = torch.zeros_like(best, dtype=torch.bool).flatten()
    possible = (best > MAYBE).flatten()
    index = possible.nonzero()[:, 0]
    kept[index[batched_nms(boxes.flatten(0, 1)[index], best.flatten()[index], (picture * kinds + kind).flatten()[index], .5)]] = True
    best = torch.where(kept.view_as(best), best, torch.zeros_like(best))
    best, order = best.topk(TEACHER_BOXES, 1)
    return boxes.gather(1, order[:, :, None].expand(-1, -1, 4)), ours[kind.gather(1, order)] * (best > 0), best


def truths(boxes, categories, real, seen):
    """Drawn boxes, and in photographs what the teacher sees where nothing is drawn: sure ones count, others are neither one nor none."""
    their_boxes, their_categories, scores = seen
    drawn_there = (iou(their_boxes, boxes) * (categories != 0)[:, None]).amax(2) > .3
    use = real[:, None] & (their_categories > 0) & ~drawn_there
    their_categories = torch.where(use, torch.where(scores >= SURE, their_categories, torch.full_like(their_categories, -1)), torch.zeros_like(their_categories))
    return torch.cat((boxes, their_boxes), 1), torch.cat((categories, their_categories), 1)


def rpn_loss(detector, features, anchors, boxes, categories, generator):
    """Of all pictures at once. Also the regions that are proposed now."""
    head, coder = detector.rpn.head, detector.rpn.box_coder
    objectness, deltas = head(features)
    count = len(boxes)
    objectness = torch.cat([o.permute(0, 2, 3, 1).reshape(count, -1) for o in objectness], 1).float()
    deltas = torch.cat([d.view(count, -1, 4, *d.shape[2:]).permute(0, 3, 4, 1, 2).reshape(count, -1, 4) for d in deltas], 1).float()
    with torch.no_grad():
        overlap = iou(anchors[None], boxes)
        ours = overlap * (categories > 0)[:, None]
        neither = (overlap * (categories < 0)[:, None]).amax(2) > .3
        best, which = ours.max(2)
        of_box = ours.amax(1, keepdim=True)
        good = (best >= .6) | ((ours >= of_box - 1e-4) & (ours > .25)).any(2)
        bad = (best < .3) & ~good & ~neither
        luck = torch.rand(best.shape, generator=generator, device=best.device)
        chosen = torch.zeros_like(good)
        for group, most in ((good, 48), (bad, 80)):
            value, index = torch.where(group, luck, torch.full_like(luck, -1)).topk(most, 1)
            chosen.scatter_(1, index, value > 0)
        hard = torch.where(bad, objectness, torch.full_like(objectness, -99)).topk(24, 1).indices
        chosen.scatter_(1, hard, True)
        chosen &= good | bad
        target = boxes.gather(1, which[:, :, None].expand(-1, -1, 4))
    loss = F.binary_cross_entropy_with_logits(objectness[chosen], good[chosen].float())
    positive = good & chosen
    wanted = coder.encode_single(target[positive], anchors[None].expand(count, -1, -1)[positive])
    box_loss = F.smooth_l1_loss(deltas[positive], wanted, beta=1 / 9, reduction='sum') / chosen.sum().clamp(min=1)
    with torch.no_grad():
        top = objectness.topk(160, 1).indices
        at = top[:, :, None].expand(-1, -1, 4)
        proposed = coder.decode_single(deltas.gather(1, at).flatten(0, 1), anchors[None].expand(count, -1, -1).gather(1, at).flatten(0, 1)).view(count, -1, 4).clamp(0, SIDE)
        pick = torch.rand(top.shape, generator=generator, device=top.device).topk(ROIS['proposed'], 1).indices
        proposed = proposed.gather(1, pick[:, :, None].expand(-1, -1, 4))
    return loss, box_loss, proposed


def crops_of(boxes, categories, proposed, generator):
    """Boxes that the head is asked about: near what is there, proposed, anywhere."""
    count, device = len(boxes), boxes.device
    weight = torch.rand(categories.shape, generator=generator, device=device) + (categories > 0) * 2
    pick = weight.topk(min(ROIS['jittered'], weight.shape[1]), 1).indices
    near = boxes.gather(1, pick[:, :, None].expand(-1, -1, 4))
    size = (near[:, :, 2:] - near[:, :, :2]).repeat(1, 1, 2)
    spread = torch.rand((count, near.shape[1], 1), generator=generator, device=device) * .22
    near = near + size * spread * torch.randn(near.shape, generator=generator, device=device)
    middle = torch.rand((count, ROIS['random'], 2), generator=generator, device=device) * SIDE
    half = torch.exp(torch.rand((count, ROIS['random'], 2), generator=generator, device=device) * 3.2 + 2) / 2
    anywhere = torch.cat((middle - half, middle + half), 2)
    crops = torch.cat((near, proposed, anywhere), 1).clamp(0, SIDE)
    low, high = torch.minimum(crops[:, :, :2], crops[:, :, 2:] - 2), crops[:, :, 2:]
    return torch.cat((low.clamp(min=0), torch.maximum(high, low.clamp(min=0) + 2)), 2)


def head_loss(detector, features, crops, boxes, categories):
    """Soft: a box that is half right is its object by half."""
    roi, count = detector.roi_heads, len(boxes)
    with torch.no_grad():
        overlap = iou(crops, boxes)
        best, which = (overlap * (categories > 0)[:, None]).max(2)
        kind = categories.gather(1, which).clamp(min=0)
        share = ((best - HALF_RIGHT[0]) / (HALF_RIGHT[1] - HALF_RIGHT[0])).clamp(0, 1) * (kind > 0)
        neither = ((overlap * (categories < 0)[:, None]).amax(2) > .3) & (best < .5)
        target = torch.zeros((*kind.shape, len(detector_net.CATEGORIES) + 1), device=crops.device)
        target.scatter_(2, kind[:, :, None], share[:, :, None])
        target[:, :, 0] += 1 - share
    logits, deltas = roi.box_predictor(roi.box_head(roi.box_roi_pool(features, list(crops), [(SIDE, SIDE)] * count)))
    logits, deltas = logits.float(), deltas.float()
    cross = -(target.flatten(0, 1) * logits.log_softmax(1)).sum(1)
    counts = ~neither.flatten()
    loss = cross[counts].mean()
    positive = ((best > .45) & (kind > 0)).flatten()
    wanted = roi.box_coder.encode_single(boxes.gather(1, which[:, :, None].expand(-1, -1, 4)).flatten(0, 1)[positive], crops.flatten(0, 1)[positive])
    own = deltas[positive].view(len(wanted), -1, 4).gather(1, kind.flatten()[positive].view(-1, 1, 1).expand(-1, 1, 4))[:, 0]
    return loss, F.smooth_l1_loss(own, wanted, beta=1 / 9, reduction='sum') / counts.sum().clamp(min=1)


def teacher_losses(teacher, student, features, hints, outputs):
    """Features like the teacher's, and what the teacher's own head makes of them like what it says."""
    hint = said = side = 0
    adapted = [adapter(f) for adapter, f in zip(student.adapters, features.values())]
    answers = teacher(teacher.outputs[:3], dict(zip(teacher.features, adapted)))
    for mine, theirs, answer, output in zip(adapted, hints, answers, outputs):
        scores = output[:, :teachers.CATEGORIES].float().sigmoid()
        heat = scores.amax(1, keepdim=True)
        spread = theirs.float().std((0, 2, 3), keepdim=True) + 1e-3
        hint = hint + (F.smooth_l1_loss(mine.float() / spread, theirs.float() / spread, reduction='none') * (.3 + 3 * heat)).mean()
        logits = answer[:, :teachers.CATEGORIES].float()
        cross = F.binary_cross_entropy_with_logits(logits, scores, reduction='none') - torch.special.entr(scores) - torch.special.entr(1 - scores)
        said = said + (cross * (.2 + 4 * (scores - logits.sigmoid()).abs().detach())).sum() / heat.sum().clamp(min=1)
        bins = lambda o: o[:, teachers.CATEGORIES:].float().view(len(o), 4, teachers.BINS, *o.shape[2:])  # noqa: E731
        apart = F.kl_div(bins(answer).log_softmax(2), bins(output).softmax(2), reduction='none').sum(2).mean(1, keepdim=True)
        side = side + (apart * heat).sum() / heat.sum().clamp(min=1)
    return hint, said, side


def keep(training, folder, means):
    """A checkpoint, a line of the log, and the detector's weights alone."""
    training.save(os.path.join(folder, 'log.csv'), means)
    torch.save(training.average.detector.state_dict(), os.path.join(folder, 'weights.pt'))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--photos', nargs='+', required=True, help='folders of photographs')
    parser.add_argument('--drawn', nargs='*', default=[], help='folders of draw.py')
    parser.add_argument('--rooms', nargs='*', default=[], help='sequences of plumbline synth')
    parser.add_argument('--pieces', required=True, help='folder of draw.py --alone')
    parser.add_argument('--teacher', required=True, help='picodet_s_416.onnx')
    parser.add_argument('--real-share', type=float, default=.55, help='of the pictures, how many begin with a photograph')
    parser.add_argument('--minutes', type=float, required=True, help='the rate falls towards the end of this time; or of --steps')
    parser.add_argument('--steps', type=int, default=10 ** 9)
    parser.add_argument('--batch', type=int, default=96)
    parser.add_argument('--rate', type=float, default=2e-3)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--save-every', type=float, default=120, help='seconds')
    parser.add_argument('--start', help='weights.pt of an earlier training, with which this one begins')
    parser.add_argument('--out', required=True)
    args = parser.parse_args()

    if not os.path.exists(args.teacher):
        raise SystemExit("there is no teacher '%s'; it is PicoDet-S of PaddleDetection as ONNX, with the bounds of its Clip nodes as attributes" % args.teacher)
    if args.start and not os.path.exists(args.start):
        raise SystemExit("there is no '%s' to begin with; it is the weights.pt of an earlier training" % args.start)
    device = 'cuda' if torch.cuda.is_available() else 'cpu'
    torch.backends.cudnn.benchmark = True
    torch.manual_seed(args.seed)
    os.makedirs(args.out, exist_ok=True)
    pictures = compose.Pictures(args.photos, args.drawn, args.rooms, args.pieces, device)
    teacher = teachers.Teacher(args.teacher).eval().to(device).requires_grad_(False)
    training = Training(lambda: Student().to(device), args.rate, 2e-2, os.path.join(args.out, 'detector.pt'))
    if args.start and training.step == 0:
        for net in (training.net, training.average):
            net.detector.load_state_dict(torch.load(args.start, map_location=device))
    student = training.net.train()
    student.detector.backbone.to(memory_format=torch.channels_last)
    generator = torch.Generator(device=device).manual_seed(args.seed * 1000003 + training.step)
    shapes = [torch.zeros(1, 1, SIDE // s, SIDE // s, device=device) for s in (8, 16, 32)]
    anchors = student.detector.rpn.anchor_generator(ImageList(torch.zeros(1, 3, SIDE, SIDE, device=device), [(SIDE, SIDE)]), shapes)[0]
    mean, deviation = (torch.tensor(v, device=device).view(1, 3, 1, 1) for v in (student.detector.transform.image_mean, student.detector.transform.image_std))
    names = ('hint', 'said', 'side', 'proposals', 'proposal boxes', 'boxes', 'box sides')
    sums, steps, begun, saved = torch.zeros(len(names), device=device), 0, time.time(), time.time()
    while True:
        share = max((time.time() - begun) / (60 * args.minutes), training.step / args.steps)
        if share >= 1:
            break
        rate = args.rate * min(1., (training.step + 1) / 150, max(.01, (1 - share) / .55))
        with torch.no_grad():
            image, boxes, categories, real = pictures.batch(generator, args.batch, SIDE, args.real_share)
        with torch.autocast(device, torch.bfloat16, enabled=device == 'cuda'):
            with torch.no_grad():
                told = teacher(teacher.features + teacher.outputs, {teacher.image: teachers.prepared(image)})
                hints, outputs = told[:3], told[3:]
                boxes, categories = truths(boxes, categories, real, teacher_boxes(outputs, detector_net.CATEGORIES))
            features = student.detector.backbone(((image - mean) / deviation).contiguous(memory_format=torch.channels_last))
            like = teacher_losses(teacher, student, features, hints, outputs)
        features = {k: v.float() for k, v in features.items()}
        proposal, proposal_box, proposed = rpn_loss(student.detector, list(features.values()), anchors, boxes, categories, generator)
        crops = crops_of(boxes, categories, proposed, generator)
        box, box_side = head_loss(student.detector, features, crops, boxes, categories)
        losses = torch.stack((like[0], like[1], like[2], proposal, proposal_box, box, box_side))
        training.descend((losses * torch.tensor([1., .5, .5, .5, 1., 1., 1.], device=device)).sum(), rate, EMA)
        sums += losses.detach()
        steps += 1
        now = time.time()
        if now - saved > args.save_every or training.step >= args.steps:
            means = (sums / steps).tolist()
            keep(training, args.out, means)
            print('step %d, %.0f s: %s' % (training.step, now - begun, ', '.join('%s %.4f' % pair for pair in zip(names, means))), flush=True)
            sums, steps, saved = torch.zeros_like(sums), 0, now
    if steps:
        keep(training, args.out, (sums / steps).tolist())
    print('%d steps of %d pictures in %.0f s' % (training.step, args.batch, time.time() - begun), flush=True)


if __name__ == '__main__':
    main()
