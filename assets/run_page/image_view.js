// SPDX-License-Identifier: Apache-2.0
// The image of the step with what was believed of it drawn over it, as vectors: the image itself stays as it was taken.

const kTruthColor = "#35b56c";

class ImageView {
  constructor(canvas, page) {
    this.canvas = canvas;
    this.page = page;
    this.zoom = 1;
    this.middle = [run.page.width / 2, run.page.height / 2];
    canvas.addEventListener("wheel", (event) => this.onWheel(event), { passive: false });
    canvas.addEventListener("dblclick", () => this.reset());
    canvas.addEventListener("pointerdown", (event) => this.onDown(event));
    canvas.addEventListener("pointermove", (event) => this.onMove(event));
    canvas.addEventListener("pointerup", (event) => this.onUp(event));
    canvas.addEventListener("pointerleave", () => page.tip(null));
  }

  reset() {
    this.zoom = 1;
    this.page.changed();
  }

  /** Page pixels to canvas pixels: [scale, x, y]. */
  place() {
    const { width, height } = this.canvas;
    const scale = this.zoom * Math.min(width / run.page.width, height / run.page.height);
    if (this.zoom === 1) this.middle = [run.page.width / 2, run.page.height / 2];
    return [scale, width / 2 - scale * this.middle[0], height / 2 - scale * this.middle[1]];
  }
  inImage(event) {
    const box = this.canvas.getBoundingClientRect();
    const ratio = this.canvas.width / box.width;
    const [scale, x, y] = this.place();
    return [((event.clientX - box.left) * ratio - x) / scale, ((event.clientY - box.top) * ratio - y) / scale];
  }

  onWheel(event) {
    event.preventDefault();
    const before = this.inImage(event);
    this.zoom = Math.min(8, Math.max(1, this.zoom * Math.exp(-event.deltaY * 0.0015)));
    const after = this.inImage(event);
    if (this.zoom > 1) this.middle = this.middle.map((m, i) => m + before[i] - after[i]);
    this.page.changed();
  }
  onDown(event) {
    this.press = { x: event.clientX, y: event.clientY, middle: [...this.middle], moved: false };
    if (event.pointerType === "mouse") this.canvas.setPointerCapture(event.pointerId);
  }
  onMove(event) {
    if (this.press && event.buttons) {
      const dx = event.clientX - this.press.x, dy = event.clientY - this.press.y;
      if (Math.hypot(dx, dy) > 4) this.press.moved = true;
      if (this.press.moved && this.zoom > 1) {
        const scale = (this.place()[0] * this.canvas.clientWidth) / this.canvas.width;
        this.middle = [this.press.middle[0] - dx / scale, this.press.middle[1] - dy / scale];
        this.page.changed();
      }
      return;
    }
    const step = this.page.step;
    const [x, y] = this.inImage(event);
    const id = this.objectAt(x, y);
    const box = this.boxAt(x, y);
    const truth = this.page.on.truth ? this.truthAt(x, y) : null;
    const lines = [];
    if (id != null) lines.push(this.page.describe(id));
    if (truth != null) lines.push(`true: ${run.truth[truth].id}`);
    if (box) lines.push(`box: ${box.category} ${box.score.toFixed(2)}, ${fateTexts[box.fate]}${box.fate === 0 || box.fate === 1 ? ` ${nameOf(box.object, step)}` : ""}`);
    this.page.tip(lines.length ? lines.join("\n") : null, event);
    this.canvas.style.cursor = id != null ? "pointer" : "default";
  }
  onUp(event) {
    const press = this.press;
    this.press = null;
    if (!press || press.moved) return;
    this.page.select(this.objectAt(...this.inImage(event)));
  }

  pathOf(contours) {
    const path = new Path2D();
    for (const points of contours) {
      for (let i = 0; i < points.length; i += 2) path[i ? "lineTo" : "moveTo"](points[i], points[i + 1]);
      path.closePath();
    }
    return path;
  }
  shown(outline) {
    const object = this.page.step.objects.get(outline.id);
    return object && (object.state === 1 || this.page.on.tentative);
  }
  within(outlines, x, y) {
    const context = this.canvas.getContext("2d");
    context.save();
    context.setTransform(1, 0, 0, 1, 0, 0);
    const hit = outlines.find((outline) => context.isPointInPath(this.pathOf(outline.contours), x, y, "evenodd"));
    context.restore();
    return hit?.id ?? null;
  }
  objectAt(x, y) {
    return this.within(this.page.step.outlines.filter((outline) => this.shown(outline)), x, y);
  }
  truthAt(x, y) {
    return this.within(this.page.step.truthOutlines, x, y);
  }
  /** The box whose edge is under the mouse. */
  boxAt(x, y) {
    const near = 5 / this.place()[0] + 1;
    return this.boxes().find(({ x0, y0, x1, y1 }) => {
      if (x < x0 - near || x > x1 + near || y < y0 - near || y > y1 + near) return false;
      return Math.min(Math.abs(x - x0), Math.abs(x - x1), Math.abs(y - y0), Math.abs(y - y1)) < near;
    });
  }
  boxes() {
    const { boxes, weak } = this.page.on;
    const isWeak = (box) => box.fate === fates.low || box.fate === fates.unknown;
    return this.page.step.boxes.filter((box) => (isWeak(box) ? weak : boxes));
  }

  draw() {
    const { canvas, page } = this;
    const ratio = fitCanvas(canvas);
    const context = canvas.getContext("2d");
    const step = page.step;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    const [scale, x, y] = this.place();
    context.setTransform(scale, 0, 0, scale, x, y);
    const image = pictures.get(step, () => page.changed());
    if (image) {
      this.last = image;
      context.imageSmoothingQuality = "high";
      context.drawImage(image, 0, 0, run.page.width, run.page.height);
    } else if (step.picture && this.last) {
      context.drawImage(this.last, 0, 0, run.page.width, run.page.height);
    } else {
      context.fillStyle = themeColor("--panel");
      context.fillRect(0, 0, run.page.width, run.page.height);
    }
    const unit = ratio / scale;
    if (page.on.boxes || page.on.weak) this.drawBoxes(context, step, unit);
    if (page.on.truth) this.drawTruth(context, step, unit);
    if (page.on.outlines) this.drawOutlines(context, step, unit);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    if (page.on.names) this.drawNames(context, step, scale / ratio, x / ratio, y / ratio);
    if (step.skipped) plate(context, `not used: ${step.skipped}`, canvas.clientWidth / 2, 20, { size: 12 });
    else if (!step.picture) plate(context, hasImages ? "no image of this frame" : "without images", canvas.clientWidth / 2, 20, { size: 12 });
  }

  drawOutlines(context, step, unit) {
    context.lineJoin = "round";
    const order = [...step.outlines].sort((a, b) => (a.id === this.page.selected) - (b.id === this.page.selected));
    for (const outline of order) {
      if (!this.shown(outline)) continue;
      const confirmed = step.objects.get(outline.id).state === 1;
      const selected = outline.id === this.page.selected;
      const path = this.pathOf(outline.contours);
      const width = selected ? 3 : confirmed ? 2 : 1;
      if (selected) {
        context.fillStyle = colorOf(outline.id);
        context.globalAlpha = 0.16;
        context.fill(path, "evenodd");
        context.globalAlpha = 1;
      }
      context.strokeStyle = selected ? "rgba(255,255,255,.95)" : "rgba(255,255,255,.65)";
      context.lineWidth = (width + (confirmed || selected ? 2 : 1.2)) * unit;
      context.stroke(path);
      context.strokeStyle = colorOf(outline.id);
      context.lineWidth = width * unit;
      if (!confirmed) context.setLineDash([4 * unit, 3 * unit]);
      context.stroke(path);
      context.setLineDash([]);
    }
  }
  drawTruth(context, step, unit) {
    for (const outline of step.truthOutlines) {
      const path = this.pathOf(outline.contours);
      context.strokeStyle = "rgba(0,0,0,.45)";
      context.lineWidth = 3 * unit;
      context.stroke(path);
      context.strokeStyle = kTruthColor;
      context.lineWidth = 1.8 * unit;
      context.setLineDash([7 * unit, 4 * unit]);
      context.stroke(path);
      context.setLineDash([]);
    }
  }
  drawBoxes(context, step, unit) {
    for (const box of this.boxes()) {
      const faint = box.fate === fates.low || box.fate === fates.unknown;
      const owned = box.fate === fates.explained;
      const [x0, y0, w, h] = [box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0];
      context.strokeStyle = "rgba(0,0,0,.5)";
      context.lineWidth = (faint ? 2 : 3.4) * unit;
      context.strokeRect(x0, y0, w, h);
      context.strokeStyle = owned ? colorOf(box.object) : box.fate === fates.spawned ? "#ffffff" : box.fate === fates.implausible ? "#e5574a" : "#b8c0c8";
      context.lineWidth = (faint ? 1 : 1.8) * unit;
      if (faint || box.fate === fates.implausible) context.setLineDash([3 * unit, 3 * unit]);
      context.strokeRect(x0, y0, w, h);
      context.setLineDash([]);
    }
  }
  drawNames(context, step, scale, x, y) {
    const labels = [];
    for (const outline of step.outlines) {
      const object = step.objects.get(outline.id);
      const selected = outline.id === this.page.selected;
      if (!object || !(object.state === 1 || selected)) continue;
      let [x0, y0, x1, y1] = [Infinity, Infinity, -Infinity, -Infinity];
      for (const points of outline.contours) {
        for (let i = 0; i < points.length; i += 2) {
          x0 = Math.min(x0, points[i]); x1 = Math.max(x1, points[i]);
          y0 = Math.min(y0, points[i + 1]); y1 = Math.max(y1, points[i + 1]);
        }
      }
      labels.push({ text: nameOf(outline.id, step), color: colorOf(outline.id), selected, area: (x1 - x0) * (y1 - y0), x: x + (scale * (x0 + x1)) / 2, y: y + (scale * (y0 + y1)) / 2 });
    }
    labels.sort((a, b) => b.selected - a.selected || b.area - a.area);
    placeLabels(context, labels, 12, this.canvas.clientWidth, this.canvas.clientHeight);
  }
}
