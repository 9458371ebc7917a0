// SPDX-License-Identifier: Apache-2.0
// What RunPage.WorksInABrowser does with the page, as a user would: keys, clicks, drags. What it saw ends up in an attribute of the body.

// Comes before the page's own script: a browser without a window shows no frames by itself, and forgets what WebGL drew once shown.
const beforeThePage = () => {
  window.faults = [];
  addEventListener("error", (event) => faults.push(event.message));
  addEventListener("securitypolicyviolation", (event) => faults.push(`policy: ${event.violatedDirective} ${event.blockedURI}`));
  window.requestAnimationFrame = (then) => setTimeout(() => then(performance.now()), 2);
  const context = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, more) {
    return context.call(this, kind, kind === "2d" ? more : { ...more, preserveDrawingBuffer: true });
  };
  HTMLCanvasElement.prototype.setPointerCapture = () => {};  // there is no real pointer
};

const drive = async () => {
  const said = {};
  const $ = (id) => document.getElementById(id);
  const pause = (ms) => new Promise((done) => setTimeout(done, ms));
  const key = async (name) => {
    document.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true }));
    await pause(8);
  };
  const pixels = (canvas) => {
    const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
    copy.getContext("2d").drawImage(canvas, 0, 0);
    return copy.getContext("2d").getImageData(0, 0, copy.width, copy.height).data;
  };
  const colors = (data) => {
    const seen = new Set();
    for (let i = 0; i < data.length; i += 4) seen.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    return seen.size;
  };
  const differing = (a, b) => {
    let count = 0;
    for (let i = 0; i < a.length; i += 4) count += Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 30;
    return count;
  };
  const point = (element, kind, x, y) => {
    const box = element.getBoundingClientRect();
    const buttons = kind === "pointerup" ? 0 : 1;
    element.dispatchEvent(new PointerEvent(kind, { clientX: box.left + x, clientY: box.top + y, pointerId: 1, button: 0, buttons, bubbles: true }));
  };
  const selectedBy = async (canvas, x, y) => {
    point(canvas, "pointerdown", x, y);
    point(canvas, "pointerup", x, y);
    await pause(8);
    return document.querySelector("#objects .selected")?.dataset.object ?? null;
  };

  await pause(400);
  const [image, map, timeline] = ["image", "map", "timeline"].map($);
  said.summary = $("summary").textContent;
  said.atFirst = $("when").textContent;
  await key("Home");
  await key("ArrowRight");
  await key("ArrowRight");
  said.stepped = $("when").textContent;
  await key("End");
  await pause(300);
  said.imageColors = colors(pixels(image));
  said.mapColors = colors(pixels(map));

  const with_outlines = pixels(image);
  await key("o");
  said.outlinePixels = differing(with_outlines, pixels(image));
  await key("o");
  const without_truth = pixels(image);
  await key("t");
  said.truthPixels = differing(without_truth, pixels(image));
  await key("t");

  said.selected = [];
  for (const id of [...document.querySelectorAll("#objects tbody tr:not(.tentative)")].map((row) => row.dataset.object)) {
    await key("Escape");
    document.querySelector(`#objects tr[data-object="${id}"]`).click();
    await pause(8);
    said.selected.push([id, $("details").querySelector("h3").textContent]);
  }
  said.details = $("details").textContent;

  // What is clicked in the image, the map seen through the camera has in the same place.
  await key("c");
  await pause(100);
  said.agree = said.disagree = said.hits = 0;
  const aspect = innerImageAspect();
  for (let u = 0.08; u < 1; u += 0.16) {
    for (let v = 0.08; v < 1; v += 0.16) {
      const inside = (canvas) => {
        const [w, h] = [canvas.clientWidth, canvas.clientHeight];
        const width = Math.min(w, h * aspect);
        return [(w - width) / 2 + u * width, (h - width / aspect) / 2 + (v * width) / aspect];
      };
      const [here, there] = [await selectedBy(image, ...inside(image)), await selectedBy(map, ...inside(map))];
      said[here === there ? "agree" : "disagree"]++;
      said.hits += here !== null;
    }
  }
  await key("c");

  const before = pixels(map);
  point(map, "pointerdown", 100, 100);
  point(map, "pointermove", 180, 120);
  point(map, "pointerup", 180, 120);
  await pause(50);
  said.turnedPixels = differing(before, pixels(map));

  await key("Home");
  const box = timeline.getBoundingClientRect();
  point(timeline, "pointerdown", box.width - 14, 8);
  point(timeline, "pointerup", box.width - 14, 8);
  await pause(8);
  said.sought = $("when").textContent;
  $("events").querySelector("li:not(.quiet)").click();
  await pause(8);
  said.eventFrame = $("when").textContent;

  await key("Home");
  await key(" ");
  said.playing = $("play").textContent;
  await pause(800);
  said.played = $("when").textContent;
  await key(" ");
  await key("?");
  said.help = $("help").open;
  $("help").close();
  const theme = document.documentElement.dataset.theme;
  await key("d");
  said.otherTheme = theme !== document.documentElement.dataset.theme;
  await key("End");
  await pause(600);
  said.address = location.hash;
  return said;
};

const innerImageAspect = () => {
  const [width, height] = getComputedStyle(document.documentElement).getPropertyValue("--aspect").split("/").map(Number);
  return width / height;
};

if (document.currentScript.dataset.part === "before") {
  beforeThePage();
} else {
  drive()
    .catch((error) => { faults.push(String(error.stack)); return {}; })
    .then((said) => (document.body.dataset.result = encodeURIComponent(JSON.stringify({ ...said, faults }))));
}
