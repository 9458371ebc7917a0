// SPDX-License-Identifier: Apache-2.0
// The page as a whole: which frame, which object, what is switched on; keys, playing, and the address that leads back here.

const kSpeeds = [0.25, 0.5, 1, 2, 4, 8];
const kKeys = [
  ["Left, Right", "one frame back, on; with Shift ten"], ["Home, End", "first, last frame"], ["Space", "play or stop"], [", and .", "slower, faster"],
  ["Up, Down", "the object before, the next one"], ["Esc", "no object"], ["O N B W", "outlines, names, boxes, weak boxes"], ["E T S", "tentative objects, truth, scan"],
  ["C or 0", "map through the camera"], ["5", "map from above"], ["F", "frame the selected object"], ["R", "reset map and image"], ["D", "light or dark"], ["?", "this help"],
];
const kLegend = [
  "Image: solid outlines are the mean states of confirmed objects, thin dashed ones those of tentative objects. The wheel zooms, a double click shows everything.",
  "Boxes are those of the detector, in the colour of the object that explains them; white ones spawned an object, red dashed ones had no plausible place for a model.",
  "Map: drag to turn, with the right button (or Shift, or two fingers) to move; wheel or pinch to zoom; a double click on an object sets the centre. The orange line is the camera's path.",
  "Timeline: thin lines are tentative, thick ones confirmed objects, pale where they are hidden; triangles mark events. Drag to go there.",
  "Truth also lists the true objects that no confirmed object of the frame stands for.",
  "Spread is a standard deviation. Errors are from the true object that an object stands for: they are paired one to one, within a metre.",
  "The address of this page follows frame and object, so it can be kept or sent with the file.",
];

class Page {
  constructor() {
    this.index = steps.length - 1;
    this.selected = null;
    this.playing = false;
    this.speed = 1;
    this.on = { outlines: true, names: true, boxes: false, weak: false, tentative: true, truth: false, scan: true, through: false, only: false };
    this.readAddress();
    document.documentElement.style.setProperty("--aspect", `${run.page.width} / ${run.page.height}`);
    this.fillHeader();
    this.fillDialogs();
    this.timeline = new Timeline(byId("timeline"), this);
    this.image = new ImageView(byId("image"), this);
    this.map = new MapView(byId("map"), byId("map-labels"), this);
    this.views = [this.image, this.map, this.timeline, new ObjectList(byId("objects"), this), new Details(byId("details"), this), new EventList(byId("events"), this)];
    this.fillTimeBar();
    this.connect();
    this.changed();
  }
  get step() {
    return steps[this.index];
  }

  /** Everything is drawn again, once, before the browser shows its next picture. */
  changed() {
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => {
      this.waiting = null;
      this.draw();
    });
  }
  draw() {
    const { step } = this;
    byId("when").textContent = `frame ${step.frame}, ${rounded(step.time, 2)} s  (${this.index + 1} of ${steps.length})`;
    byId("play").textContent = this.playing ? "Stop" : "Play";
    for (const button of document.querySelectorAll("[data-switch]")) button.setAttribute("aria-pressed", this.on[button.dataset.switch]);
    for (const view of this.views) view.draw();
    for (let i = 1; i <= 3; ++i) if (steps[this.index + i]) pictures.get(steps[this.index + i]);
  }

  go(index) {
    const next = Math.max(0, Math.min(steps.length - 1, Math.round(index)));
    if (next === this.index) return;
    this.index = next;
    this.keepAddress();
    this.changed();
  }
  select(id, reveal = true) {
    this.selected = id;
    this.keepAddress();
    if (reveal && id != null) {
      const box = document.querySelector(".lanes");
      const lane = this.timeline.lanes.findIndex((one) => one.id === id);
      const y = kRuler + lane * kLane;
      if (lane >= 0 && (y < box.scrollTop || y + kLane > box.scrollTop + box.clientHeight)) box.scrollTop = y - box.clientHeight / 2;
    }
    this.changed();
  }
  selectNext(by) {
    const ids = run.objects.map((o) => o.id).filter((id) => everConfirmed(id) || (this.on.tentative && this.step.objects.get(id)?.state === 0));
    if (!ids.length) return;
    const at = ids.indexOf(this.selected);
    this.select(ids[at < 0 ? (by > 0 ? 0 : ids.length - 1) : (at + by + ids.length) % ids.length]);
  }
  turn(name, value = !this.on[name]) {
    if (name === "through" && value && !this.step.camera) return;
    this.on[name] = value;
    this.changed();
  }

  play(on = !this.playing) {
    this.playing = on;
    if (on) {
      if (this.index === steps.length - 1) this.go(0);
      this.clock = { at: performance.now(), time: this.step.time };
      requestAnimationFrame((now) => this.tick(now));
    }
    this.changed();
  }
  tick(now) {
    if (!this.playing) return;
    const time = this.clock.time + ((now - this.clock.at) / 1000) * this.speed;
    let index = this.index;
    while (index + 1 < steps.length && steps[index + 1].time <= time) ++index;
    const next = steps[index];
    // A frame waits for its image; the clock then waits with it.
    if (pictures.awaited(next)) this.clock = { at: now, time: this.step.time };
    else this.go(index);
    if (this.index === steps.length - 1) return this.play(false);
    requestAnimationFrame((later) => this.tick(later));
  }
  setSpeed(speed) {
    this.speed = speed;
    byId("speed").value = speed;
    this.clock = { at: performance.now(), time: this.step.time };
  }

  describe(id) {
    const object = this.step.objects.get(id);
    if (!object) return nameOf(id, null);
    const error = object.error ? `\n${inCm(object.error.distance)} off ${object.error.truth}` : "";
    return `${nameOf(id, this.step)}, ${stateNames[object.state]}\nP(there) ${inPercent(object.there)}, spread ${inCm(object.positionStd)}${error}`;
  }
  tip(text, event) {
    const tip = byId("tip");
    tip.hidden = !text;
    if (!text) return;
    tip.textContent = text;
    const { offsetWidth: w, offsetHeight: h } = tip;
    tip.style.left = `${Math.max(4, Math.min(event.clientX + 14, innerWidth - w - 6))}px`;
    tip.style.top = `${event.clientY + 18 + h > innerHeight ? event.clientY - h - 10 : event.clientY + 18}px`;
  }

  fillHeader() {
    byId("name").textContent = run.name;
    byId("summary").textContent = run.summary;
    byId("notice").textContent = run.notice;
    byId("notice").hidden = !run.notice;
  }
  fillDialogs() {
    byId("facts").append(...run.facts.map(([name, value]) => make("tr", {}, make("td", { textContent: name }), make("td", { textContent: value }))));
    byId("options").textContent = run.options;
    byId("keys").append(...kKeys.map(([key, text]) => make("tr", {}, make("td", {}, make("kbd", { textContent: key })), make("td", { textContent: text }))));
    byId("legend").append(...kLegend.map((text) => make("p", { textContent: text })));
  }
  fillTimeBar() {
    byId("speed").append(...kSpeeds.map((speed) => make("option", { value: speed, textContent: `${speed}x`, selected: speed === 1 })));
    byId("speed").onchange = (event) => this.setSpeed(Number(event.target.value));
    byId("quantity").append(...this.timeline.quantities.map((quantity) => make("option", { value: quantity.id, textContent: quantity.name })));
    byId("quantity").onchange = (event) => {
      this.timeline.quantity = this.timeline.quantities.find((quantity) => quantity.id === event.target.value);
      this.changed();
    };
  }

  connect() {
    const click = (id, action) => (byId(id).onclick = action);
    click("first", () => this.go(0));
    click("before", () => this.go(this.index - 1));
    click("next", () => this.go(this.index + 1));
    click("last", () => this.go(steps.length - 1));
    click("play", () => this.play());
    click("map-above", () => this.map.above());
    click("map-frame", () => this.map.frame());
    click("theme", () => this.setTheme());
    click("about-open", () => byId("about").showModal());
    click("help-open", () => byId("help").showModal());
    for (const button of document.querySelectorAll("[data-switch]")) button.onclick = () => this.turn(button.dataset.switch);
    const useless = { boxes: !steps.some((step) => step.boxes.length), truth: !run.truth.length, scan: !run.scan && !run.points, through: !steps.some((step) => step.camera) };
    useless.weak = useless.boxes;
    for (const [name, hide] of Object.entries(useless)) document.querySelector(`[data-switch="${name}"]`).hidden = hide;
    document.addEventListener("keydown", (event) => this.onKey(event));
    addEventListener("hashchange", () => { this.readAddress(); this.changed(); });
    new ResizeObserver(() => this.changed()).observe(document.body);
    for (const canvas of document.querySelectorAll("canvas")) new ResizeObserver(() => this.changed()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => this.setTheme(event.matches ? "dark" : "light"));
  }
  onKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    if (["SELECT", "INPUT"].includes(event.target.tagName)) return;
    if (event.target.tagName === "BUTTON" && [" ", "Enter"].includes(event.key)) return;
    const far = event.shiftKey ? 10 : 1;
    const letters = { o: "outlines", n: "names", b: "boxes", w: "weak", e: "tentative", t: "truth", s: "scan", c: "through", 0: "through" };
    const actions = {
      ArrowLeft: () => this.go(this.index - far), ArrowRight: () => this.go(this.index + far), Home: () => this.go(0), End: () => this.go(steps.length - 1),
      ArrowUp: () => this.selectNext(-1), ArrowDown: () => this.selectNext(1), " ": () => this.play(), Escape: () => this.select(null),
      ",": () => this.setSpeed(kSpeeds[Math.max(0, kSpeeds.indexOf(this.speed) - 1)]), ".": () => this.setSpeed(kSpeeds[Math.min(kSpeeds.length - 1, kSpeeds.indexOf(this.speed) + 1)]),
      5: () => this.map.above(), f: () => this.map.frame(), d: () => this.setTheme(), "?": () => byId("help").showModal(),
      r: () => { this.on.through = false; this.map.frameAll(); this.image.reset(); },
    };
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const action = letters[key] ? () => !document.querySelector(`[data-switch="${letters[key]}"]`).hidden && this.turn(letters[key]) : actions[key];
    if (!action) return;
    event.preventDefault();
    action();
  }
  setTheme(theme = document.documentElement.dataset.theme === "dark" ? "light" : "dark") {
    document.documentElement.dataset.theme = theme;
    this.changed();
  }

  /** #frame=118&object=6&theme=dark&through&boxes, as it is kept while one steps; anything else is ignored. */
  readAddress() {
    const words = new URLSearchParams(location.hash.slice(1));
    const frame = Number.parseInt(words.get("frame"), 10), object = Number.parseInt(words.get("object"), 10);
    if (Number.isFinite(frame)) this.index = stepOf(frame);
    if (words.has("object")) this.selected = lives.has(object) ? object : null;
    for (const name of Object.keys(this.on)) if (words.has(name)) this.on[name] = words.get(name) !== "0";
    const wanted = words.get("theme") ?? document.documentElement.dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    document.documentElement.dataset.theme = wanted === "dark" ? "dark" : "light";
  }
  keepAddress() {
    clearTimeout(this.keeping);  // browsers turn away a page that does this all the time
    this.keeping = setTimeout(() => {
      const object = this.selected == null ? "" : `&object=${this.selected}`;
      try {
        history.replaceState(null, "", `#frame=${this.step.frame}${object}`);
      } catch {}  // where a page from disk may not
    }, 400);
  }
}

if (steps.length) {
  new Page();
} else {
  byId("name").textContent = run.name;
  byId("notice").textContent = "This run holds no frames.";
  byId("notice").hidden = false;
}
