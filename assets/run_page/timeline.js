// SPDX-License-Identifier: Apache-2.0
// Frames from left to right: a lane for each object that was ever confirmed, one for all others, and a plot.

const kQuantities = [
  { id: "error", name: "Error of position", needsTruth: true, of: (o) => (o.error ? 100 * o.error.distance : null), unit: "cm", most: 50 },
  { id: "turned", name: "Error of azimuth", needsTruth: true, of: (o) => (o.error && !isRound(o.label) ? (o.error.azimuth * 180) / Math.PI : null), unit: "°", most: 45 },
  { id: "spread", name: "Spread of position", of: (o) => 100 * o.positionStd, unit: "cm", most: 20 },
  { id: "there", name: "P(there)", of: (o) => 100 * o.there, unit: "%", most: 100 },
  { id: "shape", name: "Probability of the shape", of: (o) => (o.labels.length ? 100 * o.labels[0][1] : null), unit: "%", most: 100 },
  { id: "visible", name: "Visible share", of: (o) => 100 * o.visible, unit: "%", most: 100 },
];
const kLane = 19, kRuler = 22, kPlot = 104;

const niceStep = (range, count) => {
  const power = 10 ** Math.floor(Math.log10(Math.max(range, 1e-9) / count));
  return [1, 2, 5, 10].map((k) => k * power).find((step) => range / step <= count) ?? 10 * power;
};

class Timeline {
  constructor(canvas, page) {
    this.canvas = canvas;
    this.page = page;
    this.lanes = run.objects.filter((object) => object.confirmed != null).map((object) => ({ id: object.id, parts: this.partsOf(object.id) }));
    this.others = steps.map((step) => [...step.objects.values()].filter((o) => !everConfirmed(o.id) && o.state !== 2).length);
    this.hasOthers = this.others.some((count) => count > 0);
    this.marks = run.events.filter((event) => event.object && ["spawned", "confirmed", "retired", "merged", "label changed"].includes(event.kind) && everConfirmed(event.object));
    this.quantities = kQuantities.filter((quantity) => !quantity.needsTruth || run.truth.length);
    this.quantity = this.quantities[0];
    canvas.addEventListener("pointerdown", (event) => {
      const lane = this.laneAt(event);
      if (event.offsetX < this.left() - 4) {
        if (lane) page.select(lane.id);
        return;
      }
      canvas.setPointerCapture(event.pointerId);
      this.dragging = true;
      this.seek(event);
    });
    canvas.addEventListener("pointermove", (event) => (this.dragging ? this.seek(event) : this.hover(event)));
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, () => (this.dragging = false));
    canvas.addEventListener("pointerleave", () => page.tip(null));
  }

  partsOf(id) {
    const parts = [];
    for (const { index, objects } of steps) {
      const object = objects.get(id);
      if (!object || object.state === 2) continue;
      const last = parts.at(-1);
      const same = last && last.to === index - 1 && last.state === object.state && last.seen === Boolean(object.updated);
      if (same) last.to = index;
      else parts.push({ from: index, to: index, state: object.state, seen: Boolean(object.updated) });
    }
    return parts;
  }

  left() {
    return this.canvas.clientWidth < 640 ? 104 : 158;
  }
  height() {
    return kRuler + (this.lanes.length + (this.hasOthers ? 1 : 0)) * kLane + 6 + kPlot;
  }
  xOf(frame) {
    const [first, last] = [steps[0].frame, steps.at(-1).frame];
    return this.left() + ((this.canvas.clientWidth - this.left() - 14) * (frame - first)) / Math.max(1, last - first);
  }
  frameAt(x) {
    const [first, last] = [steps[0].frame, steps.at(-1).frame];
    return first + ((x - this.left()) / (this.canvas.clientWidth - this.left() - 14)) * (last - first);
  }
  seek(event) {
    const frame = this.frameAt(event.offsetX);
    const step = stepOf(frame);
    const next = steps[Math.min(step + 1, steps.length - 1)];
    this.page.go(Math.abs(next.frame - frame) < Math.abs(steps[step].frame - frame) ? next.index : step);
  }
  laneAt(event) {
    return this.lanes[Math.floor((event.offsetY - kRuler) / kLane)];
  }
  markAt(event) {
    const lane = this.laneAt(event);
    return lane && this.marks.find((mark) => mark.object === lane.id && Math.abs(this.xOf(mark.frame) - event.offsetX) < 6);
  }
  hover(event) {
    const mark = this.markAt(event);
    const lane = this.laneAt(event);
    if (mark) return this.page.tip(`frame ${mark.frame}: #${mark.object} ${mark.kind}${mark.text ? `\n${mark.text}` : ""}`, event);
    if (event.offsetX < this.left()) return this.page.tip(lane ? `${nameOf(lane.id, steps.at(-1))}: click selects it` : null, event);
    const step = steps[stepOf(this.frameAt(event.offsetX))];
    const inPlot = event.offsetY > this.height() - kPlot;
    const object = inPlot ? step.objects.get(this.page.selected) : lane && step.objects.get(lane.id);
    const value = object && this.quantity.of(object);
    this.page.tip(`frame ${step.frame}${object ? `, ${nameOf(object.id, step)}: ${inPlot && value != null ? `${rounded(value, 1)} ${this.quantity.unit}` : stateNames[object.state]}` : ""}`, event);
  }

  draw() {
    const { canvas, page } = this;
    canvas.style.height = `${this.height()}px`;
    const ratio = fitCanvas(canvas);
    const context = canvas.getContext("2d");
    const [width, height, left] = [canvas.clientWidth, this.height(), this.left()];
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const colors = Object.fromEntries(["line", "text", "soft", "row", "panel", "accent-back"].map((name) => [name, themeColor(`--${name}`)]));
    context.font = "11.5px system-ui, sans-serif";
    context.textBaseline = "middle";
    this.drawRuler(context, colors, width, height, left);
    this.lanes.forEach((lane, i) => this.drawLane(context, colors, lane, kRuler + i * kLane, width, left));
    if (this.hasOthers) this.drawOthers(context, colors, kRuler + this.lanes.length * kLane, left);
    this.drawPlot(context, colors, height - kPlot, width, left);
    const x = this.xOf(page.step.frame);
    context.strokeStyle = colors.text;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, 4);
    context.lineTo(x, height - 4);
    context.stroke();
    context.fillStyle = colors.text;
    context.beginPath();
    context.arc(x, 6, 4, 0, 2 * Math.PI);
    context.fill();
  }
  drawRuler(context, colors, width, height, left) {
    const [first, last] = [steps[0].frame, steps.at(-1).frame];
    const step = Math.max(1, niceStep(last - first, (width - left) / 80));
    context.fillStyle = colors.soft;
    context.strokeStyle = colors.line;
    context.lineWidth = 1;
    context.textAlign = "right";
    context.fillText("frame", left - 10, 11);
    context.textAlign = "center";
    for (let frame = Math.ceil(first / step) * step; frame <= last; frame += step) {
      const x = this.xOf(frame);
      context.fillText(String(frame), Math.min(x, width - 12), 11);
      context.beginPath();
      context.moveTo(x, kRuler - 4);
      context.lineTo(x, height);
      context.globalAlpha = 0.6;
      context.stroke();
      context.globalAlpha = 1;
    }
  }
  spans(context, parts, y, thickness, filter) {
    for (const part of parts.filter(filter)) {
      const x0 = this.xOf(steps[part.from].frame);
      const x1 = this.xOf(steps[Math.min(part.to + 1, steps.length - 1)].frame);
      context.fillRect(x0, y - thickness / 2, Math.max(1.5, x1 - x0 + 0.3), thickness);
    }
  }
  drawLane(context, colors, lane, y, width, left) {
    const middle = y + kLane / 2;
    if (lane.id === this.page.selected) {
      context.fillStyle = colors["accent-back"];
      context.fillRect(0, y, width, kLane);
    }
    context.fillStyle = colorOf(lane.id);
    this.spans(context, lane.parts, middle, 2.5, (part) => part.state === 0);
    context.globalAlpha = 0.45;
    this.spans(context, lane.parts, middle, 9, (part) => part.state === 1 && !part.seen);
    context.globalAlpha = 1;
    this.spans(context, lane.parts, middle, 9, (part) => part.state === 1 && part.seen);
    for (const mark of this.marks) {
      if (mark.object !== lane.id) continue;
      const x = this.xOf(mark.frame);
      context.fillStyle = colors.text;
      context.strokeStyle = colors.panel;
      context.beginPath();
      context.moveTo(x, middle + 1);
      context.lineTo(x - 4, middle - 6);
      context.lineTo(x + 4, middle - 6);
      context.closePath();
      context.stroke();
      context.fill();
    }
    this.drawName(context, colors, nameOf(lane.id, this.page.step.objects.has(lane.id) ? this.page.step : null), colorOf(lane.id), middle, left, lane.id === this.page.selected);
  }
  drawName(context, colors, text, color, y, left, bold) {
    context.fillStyle = color;
    context.fillRect(12, y - 4.5, 9, 9);
    context.fillStyle = colors.text;
    context.font = `${bold ? 650 : 400} 11.5px system-ui, sans-serif`;
    context.textAlign = "left";
    let shown = text;
    while (context.measureText(shown).width > left - 36 && shown.length > 4) shown = `${shown.slice(0, -2).trimEnd()}…`;
    context.fillText(shown, 27, y + 0.5);
  }
  drawOthers(context, colors, y, left) {
    const most = Math.max(...this.others);
    context.fillStyle = colors.soft;
    this.others.forEach((count, i) => {
      if (!count) return;
      const x = this.xOf(steps[i].frame);
      const h = 2 + ((kLane - 7) * count) / most;
      context.fillRect(x, y + kLane - 3 - h, Math.max(1, this.xOf(steps[Math.min(i + 1, steps.length - 1)].frame) - x), h);
    });
    this.drawName(context, colors, "never confirmed", colors.soft, y + kLane / 2, left, false);
  }
  drawPlot(context, colors, top, width, left) {
    const { quantity } = this;
    const [above, below] = [top + 8, top + kPlot - 8];
    const lines = this.lanes.map(({ id }) => ({ id, values: steps.map((step) => {
      const object = step.objects.get(id);
      return object && object.state !== 2 ? quantity.of(object) : null;
    }) }));
    const largest = Math.max(0, ...lines.flatMap((line) => line.values.filter((value) => value != null)));
    const most = Math.min(quantity.most, Math.max(niceStep(largest, 1), 1));
    const yOf = (value) => below - ((below - above) * Math.min(value, most)) / most;
    context.strokeStyle = colors.line;
    context.lineWidth = 1;
    context.fillStyle = colors.soft;
    context.textAlign = "right";
    for (const share of [0, 0.5, 1]) {
      context.beginPath();
      context.moveTo(left, yOf(most * share));
      context.lineTo(width, yOf(most * share));
      context.stroke();
      context.fillText(`${rounded(most * share, most < 2 ? 1 : 0)} ${quantity.unit}`, left - 8, yOf(most * share));
    }
    lines.sort((a, b) => (a.id === this.page.selected) - (b.id === this.page.selected));
    for (const { id, values } of lines) {
      const selected = id === this.page.selected;
      context.strokeStyle = colorOf(id);
      context.globalAlpha = this.page.selected == null || selected ? 1 : 0.45;
      context.lineWidth = selected ? 2.6 : 1.4;
      context.lineJoin = "round";
      context.beginPath();
      let open = false;
      values.forEach((value, i) => {
        if (value != null) context[open ? "lineTo" : "moveTo"](this.xOf(steps[i].frame), yOf(value));
        open = value != null;
      });
      context.stroke();
    }
    context.globalAlpha = 1;
  }
}
