// SPDX-License-Identifier: Apache-2.0
// What stands beside the pictures: objects, the selected one, events.

class ObjectList {
  constructor(table, page) {
    this.page = page;
    this.withTruth = run.truth.length > 0;
    const heads = ["object", "P(there)", "spread", ...(this.withTruth ? ["error"] : []), "seen"];
    const titles = ["", "Probability that the object exists", "Standard deviation of its position", ...(this.withTruth ? ["From the true object that it stands for"] : []), "How much of its outline shows"];
    const head = make("tr", {}, ...heads.map((text, i) => make("th", { textContent: text, title: titles[i], scope: "col" })));
    this.body = make("tbody");
    table.append(make("thead", {}, head), this.body);
  }

  rows() {
    const { step, on, selected } = this.page;
    const ids = run.objects.filter((o) => o.confirmed != null).map((o) => o.id);
    for (const object of step.objects.values()) {
      if (!everConfirmed(object.id) && (on.tentative || object.id === selected) && object.state !== 2) ids.push(object.id);
    }
    return ids.sort((a, b) => a - b);
  }
  /** Rows of the true objects that no confirmed object of this frame stands for. */
  missing() {
    if (!this.page.on.truth) return [];
    const confirmed = [...this.page.step.objects.values()].filter((object) => object.state === 1);
    const claimed = new Set(confirmed.map((object) => object.error?.truth));
    return run.truth.filter((truth) => !claimed.has(truth.id)).map((truth) => {
      const name = make("td", { title: truth.label == null ? "" : modelName(truth.label) }, dot(kTruthColor), truth.id);
      const row = make("tr", { className: "tentative", title: "A true object; a click centres the map there" }, name, make("td", { textContent: "true, not mapped", colSpan: 4 }));
      row.onclick = () => this.page.map.look(this.page.map.extentOf(truth).middle);
      return row;
    });
  }
  draw() {
    const { step, selected } = this.page;
    this.body.replaceChildren(...this.missing(), ...this.rows().map((id) => {
      const object = step.objects.get(id);
      const here = object && object.state !== 2;
      const row = make("tr", { tabIndex: 0, className: here ? (object.state === 0 ? "tentative" : "") : "absent" });
      if (id === selected) row.classList.add("selected");
      row.dataset.object = id;
      row.setAttribute("aria-selected", id === selected);
      const cell = (text) => make("td", { textContent: text });
      const name = make("td", {}, dot(colorOf(id)), nameOf(id, here ? step : null));
      row.append(name);
      if (!here) {
        const life = lives.get(id);
        const why = object?.state === 2 || step.frame > life.last ? "withdrawn" : "not yet";
        row.append(make("td", { textContent: why, colSpan: this.withTruth ? 4 : 3 }));
      } else {
        row.title = `${nameOf(id, step)}, ${stateNames[object.state]}`;
        row.append(cell(inPercent(object.there)), cell(inCm(object.positionStd)));
        if (this.withTruth) row.append(cell(object.error ? inCm(object.error.distance) : "–"));
        row.append(cell(object.updated ? inPercent(object.visible) : "hidden"));
      }
      row.onclick = () => this.page.select(id === this.page.selected ? null : id);
      row.onkeydown = (event) => event.key === "Enter" && this.page.select(id);
      return row;
    }));
  }
}

class Details {
  constructor(element, page) {
    this.element = element;
    this.page = page;
  }

  /** A name, a bar and a number. */
  share(tag, name, part, color, more = {}) {
    const fill = make("div", { className: "fill" });
    fill.style.width = `${Math.max(0, Math.min(1, part)) * 100}%`;
    fill.style.background = color;
    const track = make("div", { className: "track" }, fill);
    return make(tag, { className: "share", ...more }, make("span", { textContent: name, title: name }), track, make("b", { textContent: inPercent(part) }));
  }

  draw() {
    const { step, selected } = this.page;
    const parts = [];
    if (selected == null) {
      parts.push(make("p", { className: "quiet", textContent: "Click an object in the image, the map, the timeline or the list." }));
    } else {
      const object = step.objects.get(selected);
      const life = lives.get(selected);
      parts.push(make("h3", {}, dot(colorOf(selected)), nameOf(selected, step)));
      if (!object || object.state === 2) {
        const gone = object || step.frame > life.last;
        parts.push(make("p", { className: "quiet", textContent: gone ? `It was withdrawn: it last existed in frame ${life.last}.` : `It does not exist yet: it was spawned in frame ${life.first}.` }));
      } else {
        this.addFacts(parts, object, life);
      }
    }
    this.element.replaceChildren(...parts);
  }
  addFacts(parts, object, life) {
    const color = colorOf(object.id);
    const list = make("dl", { className: "pairs" });
    const fact = (name, value, className = "") => list.append(make("dt", { textContent: name }), make("dd", { textContent: value, className }));
    fact("state", stateNames[object.state]);
    fact("category", life.category);
    fact("spawned, confirmed", `${life.first}, ${life.confirmed ?? "never"}`);
    fact("P(there)", inPercent(object.there));
    fact("evidence", `${object.evidence >= 0 ? "+" : ""}${rounded(object.evidence, 1)}`);
    fact("spread", isRound(object.label) ? `${inCm(object.positionStd)}, round` : `${inCm(object.positionStd)}, ${inDegrees(object.azimuthStd)}`);
    fact("visible", object.updated ? inPercent(object.visible) : "hidden or out of view");
    fact("score, edges and boxes", `${rounded(object.edges, 2)}, ${rounded(object.detector, 2)}`);
    if (object.scale !== 1) fact("size", `${rounded(100 * object.scale, 1)} % of the model`);
    fact("position", `${object.position.map((x) => rounded(x, 2)).join(", ")} m`);
    if (object.error) {
      const { distance, azimuth, right, truth } = object.error;
      fact("off the truth", isRound(object.label) ? inCm(distance) : `${inCm(distance)}, ${inDegrees(azimuth)}`, distance < 0.05 ? "good" : distance > 0.2 ? "bad" : "");
      fact("true object", `${truth}, ${right ? "right shape" : "another shape"}`, right ? "" : "bad");
    } else if (run.truth.length) {
      fact("off the truth", "it stands for no true object", "bad");
    }
    parts.push(list);
    if (object.labels.length) {
      parts.push(make("h4", { textContent: "Shape" }));
      for (const [label, part] of object.labels) parts.push(this.share("div", modelName(label), part, color));
    }
    if (object.modes.length > 1) {
      parts.push(make("h4", { textContent: "Places where it may be" }));
      object.modes.forEach((mode, i) => parts.push(this.share("button", `${i + 1}: ${modelName(mode.label)}`, mode.weight, color, {
        title: `± ${inCm(mode.positionStd)}, ${inDegrees(mode.azimuthStd)}; click centres the map there`,
        onclick: () => this.page.map.look(this.page.map.extentOf({ ...mode, scale: object.scale }).middle),
      })));
    }
  }
}

class EventList {
  constructor(element, page) {
    this.element = element;
    this.page = page;
    this.items = run.events.map((event) => {
      const who = event.object ? `#${event.object} ` : "";
      const text = make("span", {}, `${who}${event.kind}`);
      if (event.object) text.prepend(dot(colorOf(event.object)));
      if (event.text) text.append(make("small", { textContent: event.text }));
      const item = make("li", { tabIndex: 0 }, make("i", { textContent: event.frame }), text);
      const go = () => {
        if (event.object) page.select(event.object, false);
        page.go(stepOf(event.frame));
      };
      item.onclick = go;
      item.onkeydown = (key) => key.key === "Enter" && go();
      return { event, item };
    });
    this.none = make("li", { className: "quiet", textContent: "" }, make("i"), "None.");
    element.append(this.none, ...this.items.map(({ item }) => item));
  }

  draw() {
    const { step, selected, on, playing } = this.page;
    let newest = null, any = false;
    for (const { event, item } of this.items) {
      const shown = on.only ? event.object === selected : on.tentative || !event.object || everConfirmed(event.object);
      item.hidden = !shown;
      any ||= shown;
      item.className = event.frame > step.frame ? "future" : "";
      if (shown && event.frame <= step.frame) newest = item;
    }
    this.none.hidden = any;
    newest?.classList.add("now");
    if (newest !== this.newest && !playing) {
      const box = this.element.parentElement;
      if (newest) box.scrollTop = newest.offsetTop - box.offsetTop - box.clientHeight / 2;
    }
    this.newest = newest;
  }
}
