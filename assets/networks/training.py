# SPDX-License-Identifier: Apache-2.0
"""What every training here does: a running average of the weights, checkpoints, a log; a broken one goes on."""
import csv
import os
import time

import torch


class Training:
    """A network, its average and the optimiser. FILE.pt has all three after every save()."""

    def __init__(self, make_net, rate, decay, file, start=None):
        """Goes on from `file` where it is there, else from the average of `start`."""
        self.net, self.average = make_net(), make_net()
        if start:
            self.net.load_state_dict(torch.load(start, map_location='cpu')['average'])
        self.average.load_state_dict(self.net.state_dict())
        decayed = [p for p in self.net.parameters() if p.ndim > 1]
        plain = [p for p in self.net.parameters() if p.ndim <= 1]
        self.optimizer = torch.optim.AdamW([{'params': decayed, 'weight_decay': decay}, {'params': plain, 'weight_decay': 0}], lr=rate)
        self.file, self.step, spent = file, 0, 0.0
        if os.path.exists(file):
            saved = torch.load(file, map_location='cpu')
            for name in ('net', 'average', 'optimizer'):
                getattr(self, name).load_state_dict(saved[name])
            self.step, spent = saved['step'], saved['seconds']
        self.begun = time.time() - spent

    def descend(self, loss, rate, remember):
        """One step; the average keeps `remember` of itself, less at the start."""
        for group in self.optimizer.param_groups:
            group['lr'] = rate
        self.optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.net.parameters(), 5)
        self.optimizer.step()
        self.step += 1
        keep = min(remember, self.step / (self.step + 10))
        with torch.no_grad():
            pairs = list(zip(self.average.state_dict().values(), self.net.state_dict().values()))
            averaged = [pair for pair in pairs if pair[0].dtype.is_floating_point]
            torch._foreach_mul_([mine for mine, _ in averaged], keep)
            torch._foreach_add_([mine for mine, _ in averaged], [other for _, other in averaged], alpha=1 - keep)
            for mine, other in pairs:
                if not mine.dtype.is_floating_point:
                    mine.copy_(other)

    def save(self, log, means):
        """Writes the checkpoint and a line of the log: step, means, rate, seconds. The seconds are returned."""
        seconds = time.time() - self.begun
        with open(log, 'a', newline='') as out:
            csv.writer(out).writerow([self.step, *['%.4f' % mean for mean in means], '%.6f' % self.optimizer.param_groups[0]['lr'], '%.0f' % seconds])
        state = {name: getattr(self, name).state_dict() for name in ('net', 'average', 'optimizer')}
        torch.save({**state, 'step': self.step, 'seconds': seconds}, self.file + '.new')
        os.replace(self.file + '.new', self.file)
        return seconds
