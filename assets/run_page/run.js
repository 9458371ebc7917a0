// SPDX-License-Identifier: Apache-2.0
// The run that this page carries, as the views read it. What came with it (names, reasons, paths) is text and stays text:
// nothing of it is ever made into markup.

const take = (id) => {
  const element = document.getElementById(id);
  const text = element.textContent;
  element.remove();
  return text;
};

const run = JSON.parse(take("run-data"));
const pictureLines = take("run-images").split("\n");

const zip = (fields, row) => Object.fromEntries(fields.map((field, i) => [field, row[i]]));

// Contours are [x, y, dx, dy, dx, dy ..] in halves of a pixel of the page's images.
const contoursOf = (rows) =>
  rows.map((row) => {
    const points = new Float32Array(row.length);
    for (let i = 0, x = 0, y = 0; i + 1 < row.length; i += 2) {
      points[i] = (x += row[i]) / 2;
      points[i + 1] = (y += row[i + 1]) / 2;
    }
    return points;
  });

const steps = run.frames.map((frame, index) => ({
  index,
  frame: frame.frame,
  time: frame.time,
  skipped: frame.skipped ?? "",
  camera: frame.camera ? { position: frame.camera.slice(0, 3), rotation: frame.camera.slice(3) } : null,
  boxes: (frame.boxes ?? []).map((row) => zip(run.fields.box, row)),
  objects: new Map(
    (frame.objects ?? []).map((row) => {
      const object = zip(run.fields.object, row);
      object.error = object.error ? zip(run.fields.error, object.error) : null;
      object.modes = (object.modes ?? []).map((mode) => zip(run.fields.mode, mode));
      return [object.id, object];
    })
  ),
  outlines: (frame.outlines ?? []).map(([id, ...rows]) => ({ id, contours: contoursOf(rows) })),
  truthOutlines: (frame.truth ?? []).map(([id, ...rows]) => ({ id, contours: contoursOf(rows) })),
  picture: pictureLines[index] || "",
}));

const lives = new Map(run.objects.map((object) => [object.id, object]));
const hasImages = steps.some((step) => step.picture);
const modelName = (label) => run.models[label]?.name ?? "?";
const colorOf = (id) => lives.get(id)?.color ?? "#808890";
const everConfirmed = (id) => lives.get(id)?.confirmed != null;

/** The step that shows a frame of the sequence, or the last one before it. */
const stepOf = (frame) => {
  let low = 0, high = steps.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (steps[middle].frame <= frame) low = middle;
    else high = middle - 1;
  }
  return low;
};

const nameOf = (id, step) => {
  const object = step?.objects.get(id);
  return `#${id} ${object ? modelName(object.label) : lives.get(id)?.model ?? ""}`;
};

const stateNames = ["tentative", "confirmed", "retired"];
const fates = { explained: 0, spawned: 1, unknown: 2, low: 3, implausible: 4 };
const fateTexts = [
  "explained by", "spawned", "there is no model of this category", "the score is too low",
  "no place for a model of the category in this box",
];

const rounded = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
const inCm = (metres) => `${rounded(100 * metres, metres < 0.1 ? 1 : 0)} cm`;
const inDegrees = (radians) => `${rounded((radians * 180) / Math.PI, Math.abs(radians) < 0.175 ? 1 : 0)}°`;
const inPercent = (share) => `${rounded(100 * share, 0)} %`;
const isRound = (label) => run.models[label]?.symmetry === 0;

/** Makes an element; text never becomes markup. */
const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children.filter((child) => child != null));
  return element;
};
const dot = (color) => {
  const element = make("span", { className: "dot" });
  element.style.background = color;
  element.style.borderColor = color;
  return element;
};
const byId = (id) => document.getElementById(id);
const themeColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Fits a canvas's buffer to its size on the screen. */
const fitCanvas = (canvas) => {
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  return ratio;
};

/** Decoded images of the steps that were used last. */
const pictures = {
  kept: new Map(),
  get(step, ready) {
    if (!step.picture) return null;
    let image = this.kept.get(step.index);
    if (image) {
      this.kept.delete(step.index);
    } else {
      image = new Image();
      image.src = `data:image/jpeg;base64,${step.picture}`;
    }
    this.kept.set(step.index, image);
    if (this.kept.size > 48) this.kept.delete(this.kept.keys().next().value);
    const complete = image.complete && image.naturalWidth > 0;
    if (!complete && ready) image.onload = ready;
    return complete ? image : null;
  },
  /** Whether the image is still on its way; one that cannot be decoded is not. */
  awaited(step) {
    return Boolean(step.picture) && !this.get(step) && !this.kept.get(step.index).complete;
  },
};

const plateBox = (context, text, x, y, { size, bold, color }) => {
  context.font = `${bold ? 650 : 500} ${size}px system-ui, sans-serif`;
  const width = context.measureText(text).width + (color ? size : 0);
  return [x - width / 2 - 5, y - size / 2 - 4, width + 10, size + 8];
};
/** Text on a dark plate, which reads on photographs and on both themes; `color` is a swatch before it. */
const plate = (context, text, x, y, style) => {
  const box = plateBox(context, text, x, y, style);
  const { size, bold, color } = style;
  context.fillStyle = bold ? "rgba(12,15,18,.92)" : "rgba(20,25,30,.74)";
  context.beginPath();
  context.roundRect(...box, 5);
  context.fill();
  if (color) {
    context.fillStyle = color;
    context.beginPath();
    context.roundRect(box[0] + 5, y - size * 0.32, size * 0.64, size * 0.64, 2);
    context.fill();
  }
  context.fillStyle = "#f2f5f7";
  context.textBaseline = "middle";
  context.textAlign = "left";
  context.fillText(text, box[0] + 5 + (color ? size : 0), y + 0.5);
  return box;
};
const overlaps = (a, b) => a[0] < b[0] + b[2] && b[0] < a[0] + a[2] && a[1] < b[1] + b[3] && b[1] < a[1] + a[3];

/** Places labels, the first ones first; those without room are left out, the selected one never is. */
const placeLabels = (context, labels, size, width, height) => {
  const taken = [];
  for (const label of labels) {
    const style = { size, bold: label.selected, color: label.color };
    const [, , w, h] = plateBox(context, label.text, label.x, label.y, style);
    const x = Math.min(Math.max(label.x, w / 2 + 3), width - w / 2 - 3);
    const inside = (y) => Math.min(Math.max(y, h / 2 + 3), height - h / 2 - 3);
    const places = [0, -1.1, 1.1, -2.2].map((rows) => inside(label.y + rows * h));
    const free = places.find((y) => taken.every((box) => !overlaps(box, plateBox(context, label.text, x, y, style))));
    if (free === undefined && !label.selected) continue;
    taken.push(plate(context, label.text, x, free ?? places[0], style));
  }
};
