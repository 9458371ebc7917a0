// SPDX-License-Identifier: Apache-2.0
// The map in three dimensions: models at their mean states, true ones in green, the scan, the camera and its path.

const kMeshVertex = `#version 300 es
in vec3 position; in vec3 color;
uniform mat4 worldFromMesh, clipFromWorld; uniform vec3 eye; uniform float back;
out vec3 inWorld, own;
void main() {
  inWorld = (worldFromMesh * vec4(position, 1)).xyz;
  own = color;
  gl_Position = clipFromWorld * vec4(inWorld, 1);
  // The scan, and what is true, lie a little behind the models that stand for the same surfaces.
  if (back > 0.) {
    vec4 behind = clipFromWorld * vec4(inWorld + back * normalize(inWorld - eye), 1);
    gl_Position.z = behind.z / behind.w * gl_Position.w;
  }
  gl_PointSize = 2.5;
}`;
const kMeshFragment = `#version 300 es
precision highp float;
in vec3 inWorld, own;
uniform vec3 eye, up, tint; uniform float alpha, ownShare, shade, side; uniform vec3 fade;
out vec4 result;
void main() {
  vec3 color = mix(tint, own, ownShare);
  if (shade > 0.) {
    vec3 normal = normalize(cross(dFdx(inWorld), dFdy(inWorld)));
    vec3 view = normalize(eye - inWorld);
    if (side != 0. && side * (gl_FrontFacing ? 1. : -1.) < 0.) discard;
    float facing = abs(dot(normal, view));
    normal = dot(normal, view) < 0. ? -normal : normal;
    color *= mix(1., .42 + .4 * facing + .24 * max(dot(normal, up), 0.), shade);
  }
  result = vec4(mix(color, fade, ownShare * .35), alpha);
}`;
const kLineVertex = `#version 300 es
in vec3 a, b;
uniform mat4 clipFromWorld; uniform vec2 size; uniform float width, nearest;
void main() {
  vec4 p = clipFromWorld * vec4(a, 1), q = clipFromWorld * vec4(b, 1);
  if (p.w < nearest && q.w < nearest) { gl_Position = vec4(2, 2, 2, 1); return; }
  if (p.w < nearest) p = mix(p, q, (nearest - p.w) / (q.w - p.w));
  if (q.w < nearest) q = mix(q, p, (nearest - q.w) / (p.w - q.w));
  vec2 along = normalize((q.xy / q.w - p.xy / p.w) * size + vec2(1e-6, 0));
  vec4 corner = (gl_VertexID & 1) == 0 ? p : q;
  corner.xy += (gl_VertexID < 2 ? -1. : 1.) * vec2(-along.y, along.x) * width / size * corner.w;
  gl_Position = corner;
}`;
const kLineFragment = `#version 300 es
precision mediump float;
uniform vec4 tint; out vec4 result;
void main() { result = tint; }`;
const kImageVertex = `#version 300 es
uniform vec2 share; out vec2 at;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  at = vec2(corner.x, 1. - corner.y);
  gl_Position = vec4((2. * corner - 1.) * share, .9999, 1);
}`;
const kImageFragment = `#version 300 es
precision mediump float;
uniform sampler2D image; in vec2 at; out vec4 result;
void main() { result = vec4(texture(image, at).rgb, 1); }`;

const decoded = (text, Type) => new Type(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
const rgb = (css) => {
  const number = parseInt(css.slice(1), 16);
  return [(number >> 16) / 255, ((number >> 8) & 255) / 255, (number & 255) / 255];
};

class MapView {
  constructor(canvas, labels, page) {
    this.canvas = canvas;
    this.labels = labels;
    this.page = page;
    this.touches = new Map();
    this.up = unit(run.up);
    const h = unit(minus([1, 0, 0], times(this.up[0], this.up)));
    this.ahead = Math.abs(this.up[0]) > 0.9 ? unit(minus([0, 1, 0], times(this.up[1], this.up))) : h;
    this.aside = cross(this.up, this.ahead);
    this.frameAll();
    this.listen();
    this.gl = canvas.getContext("webgl2", { antialias: true, alpha: false, powerPreference: "low-power" });
    if (!this.gl) {
      byId("map-missing").textContent = "The map needs WebGL 2, which this browser does not offer or has switched off.";
      byId("map-missing").hidden = false;
      return;
    }
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.prepare(); page.changed(); });
    this.prepare();
  }

  prepare() {
    const { gl } = this;
    this.programs = {
      mesh: this.program(kMeshVertex, kMeshFragment, ["position", "color"]),
      line: this.program(kLineVertex, kLineFragment, ["a", "b"]),
      image: this.program(kImageVertex, kImageFragment, []),
    };
    this.meshes = run.models.map((model) => (model.mesh ? this.mesh(model.mesh) : null));
    this.scan = run.scan ? this.mesh(run.scan) : null;
    if (this.scan) this.scanSide = this.sideOfScan();
    this.points = run.points ? this.mesh(run.points) : null;
    this.texture = gl.createTexture();
    this.textureStep = -1;
    const path = steps.filter((step) => step.camera).map((step) => step.camera.position);
    this.path = this.lines(path.slice(1).map((point, i) => [path[i], point]));
    this.grid = this.lines(this.gridLines());
    this.moving = this.lines([]);
  }
  program(vertex, fragment, attributes) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    attributes.forEach((name, i) => gl.bindAttribLocation(program, i, name));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(program));
    const uniforms = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
      const { name } = gl.getActiveUniform(program, i);
      uniforms[name] = gl.getUniformLocation(program, name);
    }
    return { program, uniforms };
  }
  buffer(target, data) {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(target, buffer);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    return buffer;
  }
  /** Vertices are 16-bit fractions of the box from `min` to `max`. */
  mesh({ vertices, triangles, colors, min, max }) {
    const { gl } = this;
    const fractions = decoded(vertices, Uint16Array);
    const positions = new Float32Array(fractions.length);
    for (let i = 0; i < fractions.length; ++i) positions[i] = min[i % 3] + ((max[i % 3] - min[i % 3]) * fractions[i]) / 65535;
    const indices = triangles ? decoded(triangles, Uint16Array) : null;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    this.buffer(gl.ARRAY_BUFFER, positions);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    if (colors) {
      this.buffer(gl.ARRAY_BUFFER, decoded(colors, Uint8Array));
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 3, gl.UNSIGNED_BYTE, true, 0, 0);
    }
    if (indices) this.buffer(gl.ELEMENT_ARRAY_BUFFER, indices);
    gl.bindVertexArray(null);
    return { array, positions, indices, colored: Boolean(colors), min, max };
  }
  lines(segments) {
    const { gl } = this;
    const data = new Float32Array(segments.flat(2));
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const buffer = this.buffer(gl.ARRAY_BUFFER, data);
    for (const i of [0, 1]) {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 24, 12 * i);
      gl.vertexAttribDivisor(i, 1);
    }
    gl.bindVertexArray(null);
    return { array, buffer, count: segments.length };
  }
  /** Scans are hollow: only what faces the camera that took them is drawn, so that walls do not hide the room. */
  sideOfScan() {
    const { positions, indices } = this.scan;
    const seen = steps.find((step) => step.camera)?.camera.position;
    if (!indices || !seen) return 0;
    let sum = 0;
    for (let i = 0; i < indices.length; i += 30) {
      const [a, b, c] = [0, 1, 2].map((k) => Array.from(positions.subarray(3 * indices[i + k], 3 * indices[i + k] + 3)));
      sum += Math.sign(inner(cross(minus(b, a), minus(c, a)), minus(seen, a)));
    }
    return sum < 0 ? -1 : 1;
  }
  gridLines() {
    if (run.floor == null) return [];
    const reach = Math.ceil(this.radius) + 1;
    const middle = [inner(this.home, this.ahead), inner(this.home, this.aside)].map(Math.round);
    const at = (u, v) => add(add(times(u + middle[0], this.ahead), times(v + middle[1], this.aside)), times(run.floor, this.up));
    const segments = [];
    for (let i = -reach; i <= reach; ++i) {
      segments.push([at(i, -reach), at(i, reach)], [at(-reach, i), at(reach, i)]);
    }
    return segments;
  }

  /** The middle and the corner distance of the box of a model at a pose. */
  extentOf({ label, position, rotation, scale = 1 }) {
    const mesh = run.models[label]?.mesh;
    if (!mesh) return { middle: position, radius: 0.4, top: position };
    const middle = times(0.5, add(mesh.min, mesh.max));
    const matrix = placed(position, rotation, scale);
    const top = [middle[0], middle[1], mesh.max[2]];
    return { middle: transform(matrix, middle).slice(0, 3), radius: (scale * norm(minus(mesh.max, mesh.min))) / 2, top: transform(matrix, top).slice(0, 3) };
  }
  frameAll() {
    const last = steps.at(-1);
    const extents = [...(last?.objects.values() ?? [])].filter((o) => o.state === 1).map((o) => this.extentOf(o));
    extents.push(...run.truth.filter((truth) => truth.label != null).map((truth) => this.extentOf(truth)));
    const path = steps.filter((step) => step.camera).map((step) => step.camera.position);
    if (!extents.length) extents.push(...path.map((middle) => ({ middle, radius: 0.2 })));
    if (!extents.length) extents.push({ middle: [0, 0, 0], radius: 2 });
    const low = [0, 1, 2].map((i) => Math.min(...extents.map((e) => e.middle[i] - 0.6 * e.radius)));
    const high = [0, 1, 2].map((i) => Math.max(...extents.map((e) => e.middle[i] + 0.6 * e.radius)));
    this.target = times(0.5, add(low, high));
    this.home = this.target;
    this.radius = Math.max(0.5, norm(minus(high, low)) / 2);
    this.distance = this.radius * 2.6;
    this.elevation = 0.6;
    // From where the camera was on average: what one saw in the images is in front.
    const from = path.length ? minus(times(1 / path.length, path.reduce(add, [0, 0, 0])), this.target) : [0, 0, 0];
    this.azimuth = Math.atan2(inner(from, this.aside), inner(from, this.ahead)) + 0.35;
  }
  frame() {
    this.page.turn("through", false);
    const object = this.page.step.objects.get(this.page.selected);
    if (!object) {
      this.frameAll();
    } else {
      const { middle, radius } = this.extentOf(object);
      this.target = middle;
      this.distance = Math.max(0.6, radius * 4.2);
    }
    this.page.changed();
  }
  look(middle) {
    this.page.turn("through", false);
    this.target = middle;
    this.page.changed();
  }
  above() {
    this.page.turn("through", false);
    this.elevation = Math.PI / 2 - 0.001;
    this.page.changed();
  }

  listen() {
    const { canvas } = this;
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.leaveCamera();
      this.distance = Math.min(200, Math.max(0.2, this.distance * Math.exp(event.deltaY * 0.0012)));
      this.page.changed();
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.touches.set(event.pointerId, [event.clientX, event.clientY]);
      this.press = { x: event.clientX, y: event.clientY, moved: this.touches.size > 1 };
    });
    canvas.addEventListener("pointermove", (event) => this.onMove(event));
    for (const kind of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(kind, (event) => {
        const press = this.press;
        this.touches.delete(event.pointerId);
        if (kind === "pointerup" && press && !press.moved && event.button === 0) this.page.select(this.pick(event)?.id ?? null);
        if (!this.touches.size) this.press = null;
      });
    }
    canvas.addEventListener("pointerleave", () => this.page.tip(null));
    canvas.addEventListener("dblclick", (event) => {
      const hit = this.pick(event);
      if (hit) this.look(hit.point);
    });
  }
  onMove(event) {
    const before = this.touches.get(event.pointerId);
    if (!before) {
      const hit = this.pick(event);
      this.page.tip(hit ? this.page.describe(hit.id) : null, event);
      this.canvas.style.cursor = hit ? "pointer" : "grab";
      return;
    }
    if (this.press && Math.hypot(event.clientX - this.press.x, event.clientY - this.press.y) > 4) this.press.moved = true;
    if (!this.press?.moved) return;
    this.leaveCamera();
    this.page.tip(null);
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    if (this.touches.size === 2) {
      const other = [...this.touches].find(([id]) => id !== event.pointerId)[1];
      const spread = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      this.distance = Math.min(200, Math.max(0.2, (this.distance * spread(before)) / spread(now)));
      this.pan(dx / 2, dy / 2);
    } else if (event.buttons & 6 || event.shiftKey) {
      this.pan(dx, dy);
    } else {
      this.azimuth -= dx * 0.008;
      this.elevation = Math.min(Math.PI / 2 - 0.001, Math.max(-1.4, this.elevation + dy * 0.008));
    }
    this.touches.set(event.pointerId, now);
    this.page.changed();
  }
  pan(dx, dy) {
    const { view } = this.orbit();
    const scale = (0.72 * this.distance) / Math.max(1, this.canvas.clientHeight);
    const right = [view[0], view[4], view[8]], up = [view[1], view[5], view[9]];
    this.target = add(this.target, add(times(-dx * scale, right), times(dy * scale, up)));
  }
  /** Turning the view out of the camera begins where the camera is. */
  leaveCamera() {
    const camera = this.page.on.through && this.page.step.camera;
    if (!camera) return;
    this.page.turn("through", false);
    const matrix = placed(camera.position, camera.rotation);
    const forward = [matrix[8], matrix[9], matrix[10]];
    this.distance = Math.max(1, inner(minus(this.home, camera.position), forward));
    this.target = add(camera.position, times(this.distance, forward));
    const from = times(-1, forward);
    this.azimuth = Math.atan2(inner(from, this.aside), inner(from, this.ahead));
    this.elevation = Math.asin(Math.max(-1, Math.min(1, inner(from, this.up))));
  }

  orbit() {
    const flat = add(times(Math.cos(this.azimuth), this.ahead), times(Math.sin(this.azimuth), this.aside));
    const out = add(times(Math.cos(this.elevation), flat), times(Math.sin(this.elevation), this.up));
    const eye = add(this.target, times(this.distance, out));
    return { eye, view: lookingAt(eye, this.target, this.up) };
  }
  /** { eye, clip } of the view; `share` of the canvas that the image fills, through the camera. */
  viewpoint() {
    const aspect = this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
    const camera = this.page.on.through && this.page.step.camera;
    if (camera) {
      const image = run.camera.width / run.camera.height;
      const share = aspect > image ? [image / aspect, 1] : [1, aspect / image];
      const world = placed(camera.position, camera.rotation);
      return { eye: camera.position, share, clip: multiply(throughCamera(run.camera, share, 0.05, 100), rigidInverse(world)) };
    }
    const { eye, view } = this.orbit();
    const tangent = 0.36;
    const near = Math.max(0.01, this.distance * 0.02);
    const wide = aspect < 1 ? tangent / aspect : tangent;
    return { eye, share: null, clip: multiply(perspective(aspect < 1 ? tangent : tangent * aspect, aspect < 1 ? wide : tangent, near, near * 4000), view) };
  }

  shownObjects() {
    const { page } = this;
    const list = [];
    for (const object of page.step.objects.values()) {
      if (object.state === 2 || (object.state === 0 && !page.on.tentative)) continue;
      list.push({ id: object.id, label: object.label, position: object.position, rotation: object.rotation, scale: object.scale, color: colorOf(object.id), alpha: object.state === 1 ? 1 : 0.12 + 0.45 * object.there });
      if (object.id !== page.selected) continue;
      for (const mode of object.modes.slice(1)) list.push({ ...mode, id: object.id, scale: object.scale, color: colorOf(object.id), alpha: 0.12 + 0.4 * mode.weight, ghost: true });
    }
    return list;
  }

  pick(event) {
    if (!this.gl) return null;
    const box = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1, y = 1 - (2 * (event.clientY - box.top)) / box.height;
    const { eye, clip } = this.viewpoint();
    // The ray is where two planes of the view meet: (row 0 - x row 3) and (row 1 - y row 3).
    const row = (i) => [clip[i], clip[4 + i], clip[8 + i]];
    let ray = unit(cross(minus(row(0), times(x, row(3))), minus(row(1), times(y, row(3)))));
    if (inner(ray, row(3)) < 0) ray = times(-1, ray);
    let best = null;
    for (const object of this.shownObjects()) {
      const mesh = this.meshes[object.label];
      if (!mesh?.indices) continue;
      const into = rigidInverse(placed(object.position, object.rotation));
      const origin = times(1 / (object.scale ?? 1), transform(into, eye).slice(0, 3));
      const direction = times(1 / (object.scale ?? 1), minus(transform(into, add(eye, ray)).slice(0, 3), transform(into, eye).slice(0, 3)));
      const distance = rayMesh(origin, direction, mesh.positions, mesh.indices);
      if (distance < (best?.distance ?? Infinity)) best = { id: object.id, distance, point: add(eye, times(distance, ray)) };
    }
    return best;
  }

  draw() {
    if (!this.gl || this.gl.isContextLost()) return;
    const { gl, page } = this;
    const ratio = fitCanvas(this.canvas);
    this.view = this.viewpoint();
    const fade = rgb(themeColor("--stage"));
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...fade, 1);
    gl.clearDepth(1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const image = this.view.share && this.drawImage();
    const dark = document.documentElement.dataset.theme === "dark";
    this.useMesh(fade);
    if (page.on.scan && !image) {
      if (this.scan) this.drawMesh(this.scan, placed([0, 0, 0], [0, 0, 0, 1]), { own: this.scan.colored, side: this.scanSide, tint: dark ? "#5a646e" : "#b9c1c9", back: 0.06, shade: this.scan.colored ? 0.35 : 1 });
      if (this.points) this.drawMesh(this.points, placed([0, 0, 0], [0, 0, 0, 1]), { tint: dark ? "#8b96a1" : "#7c8791", shade: 0 });
    }
    if (!image) this.drawLines(this.grid, dark ? [1, 1, 1, 0.1] : [0.1, 0.15, 0.2, 0.1], 1 * ratio);
    if (image) {  // nothing is drawn where the camera did not look
      const [w, h] = this.view.share.map((share, i) => Math.round(share * [this.canvas.width, this.canvas.height][i]));
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor((this.canvas.width - w) / 2, (this.canvas.height - h) / 2, w, h);
    }
    const objects = this.shownObjects();
    for (const object of objects) if (object.alpha >= 1) this.drawObject(object, image ? 0.5 : 1);
    for (const object of objects) if (object.alpha < 1) this.drawObject(object, object.alpha);
    if (page.on.truth) {
      for (const truth of run.truth) {
        if (truth.label != null) this.drawObject({ ...truth, color: kTruthColor }, 0.5, 0.01);
      }
    }
    if (!image) {
      this.drawLines(this.path, [0.88, 0.54, 0.17, 0.9], 1.6 * ratio);
      this.drawCamera(ratio);
    }
    this.drawSelection(ratio, dark || image);
    gl.disable(gl.SCISSOR_TEST);
    this.drawLabels(ratio);
  }
  useMesh(fade) {
    const { gl } = this;
    const { program, uniforms } = this.programs.mesh;
    gl.useProgram(program);
    gl.uniformMatrix4fv(uniforms.clipFromWorld, false, this.view.clip);
    gl.uniform3fv(uniforms.eye, this.view.eye);
    gl.uniform3fv(uniforms.up, this.up);
    gl.uniform3fv(uniforms.fade, fade);
  }
  drawMesh(mesh, matrix, { tint, own = false, side = 0, alpha = 1, shade = 1, back = 0 }) {
    const { gl } = this;
    const { program, uniforms } = this.programs.mesh;
    gl.useProgram(program);
    gl.uniformMatrix4fv(uniforms.worldFromMesh, false, matrix);
    gl.uniform3fv(uniforms.tint, rgb(tint));
    gl.uniform1f(uniforms.alpha, alpha);
    gl.uniform1f(uniforms.ownShare, own ? 1 : 0);
    gl.uniform1f(uniforms.shade, shade);
    gl.uniform1f(uniforms.side, side);
    gl.uniform1f(uniforms.back, back);
    gl.bindVertexArray(mesh.array);
    const submit = () => (mesh.indices ? gl.drawElements(gl.TRIANGLES, mesh.indices.length, gl.UNSIGNED_SHORT, 0) : gl.drawArrays(gl.POINTS, 0, mesh.positions.length / 3));
    if (alpha < 1) {  // depth first, so that one sees its nearest surface only
      gl.colorMask(false, false, false, false);
      submit();
      gl.colorMask(true, true, true, true);
      gl.enable(gl.BLEND);
    }
    submit();
    gl.disable(gl.BLEND);
    gl.bindVertexArray(null);
  }
  drawObject(object, alpha, back = 0) {
    const mesh = this.meshes[object.label];
    if (mesh) this.drawMesh(mesh, placed(object.position, object.rotation, object.scale ?? 1), { tint: object.color, alpha, back });
  }
  drawLines(lines, color, width) {
    const { gl } = this;
    if (!lines.count) return;
    const { program, uniforms } = this.programs.line;
    gl.useProgram(program);
    gl.uniformMatrix4fv(uniforms.clipFromWorld, false, this.view.clip);
    gl.uniform2f(uniforms.size, this.canvas.width, this.canvas.height);
    gl.uniform1f(uniforms.width, width);
    gl.uniform1f(uniforms.nearest, 0.02);
    gl.uniform4fv(uniforms.tint, color);
    gl.enable(gl.BLEND);
    gl.bindVertexArray(lines.array);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, lines.count);
    gl.bindVertexArray(null);
    gl.disable(gl.BLEND);
  }
  drawSegments(segments, color, width) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.moving.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(segments.flat(2)), gl.DYNAMIC_DRAW);
    this.drawLines({ array: this.moving.array, count: segments.length }, color, width);
  }
  drawCamera(ratio) {
    const { camera } = this.page.step;
    if (!camera) return;
    const { width, height, fx, fy, cx, cy } = run.camera;
    const matrix = placed(camera.position, camera.rotation);
    const depth = Math.min(0.35, 0.12 * this.radius + 0.05);
    const corner = (u, v) => transform(matrix, [((u - cx) / fx) * depth, ((v - cy) / fy) * depth, depth]).slice(0, 3);
    const c = [corner(0, 0), corner(width, 0), corner(width, height), corner(0, height)];
    const segments = c.flatMap((point, i) => [[camera.position, point], [point, c[(i + 1) % 4]]]);
    this.drawSegments(segments, [0.93, 0.58, 0.18, 1], 2 * ratio);
  }
  drawSelection(ratio, light) {
    const object = this.page.step.objects.get(this.page.selected);
    const mesh = object && run.models[object.label]?.mesh;
    if (!mesh || object.state === 2) return;
    const matrix = placed(object.position, object.rotation, object.scale);
    const corner = (i) => transform(matrix, [0, 1, 2].map((k) => ((i >> k) & 1 ? mesh.max[k] : mesh.min[k]))).slice(0, 3);
    const segments = [];
    for (let i = 0; i < 8; ++i) for (let k = 0; k < 3; ++k) if (!((i >> k) & 1)) segments.push([corner(i), corner(i | (1 << k))]);
    this.drawSegments(segments, light ? [1, 1, 1, 0.85] : [0.1, 0.14, 0.18, 0.75], 1.4 * ratio);
  }
  drawImage() {
    const { gl, page } = this;
    const image = pictures.get(page.step, () => page.changed());
    if (!image) return false;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    if (this.textureStep !== page.step.index) {
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, gl.RGB, gl.UNSIGNED_BYTE, image);
      for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, name, value);
      this.textureStep = page.step.index;
    }
    const { program, uniforms } = this.programs.image;
    gl.useProgram(program);
    gl.uniform2fv(uniforms.share, this.view.share);
    gl.depthMask(false);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.depthMask(true);
    return true;
  }
  drawLabels(ratio) {
    fitCanvas(this.labels);
    const context = this.labels.getContext("2d");
    const [width, height] = [this.labels.clientWidth, this.labels.clientHeight];
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.labels.width, this.labels.height);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const labels = [];
    for (const object of this.shownObjects()) {
      const selected = object.id === this.page.selected;
      if (object.ghost || !(object.alpha >= 1 || selected) || !this.page.on.names) continue;
      const p = transform(this.view.clip, this.extentOf(object).top);
      if (p[3] < 0.05 || Math.abs(p[0]) > p[3] || Math.abs(p[1]) > p[3]) continue;
      labels.push({ text: nameOf(object.id, this.page.step), color: object.color, selected, depth: p[3], x: ((p[0] / p[3] + 1) * width) / 2, y: ((1 - p[1] / p[3]) * height) / 2 - 10 });
    }
    labels.sort((a, b) => b.selected - a.selected || a.depth - b.depth);
    placeLabels(context, labels, 11.5, width, height);
  }
}
