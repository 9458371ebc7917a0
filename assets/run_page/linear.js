// SPDX-License-Identifier: Apache-2.0
// Vectors are arrays, matrices 4x4 by columns, rotations quaternions [x, y, z, w].

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (s, a) => [s * a[0], s * a[1], s * a[2]];
const inner = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(...a);
const unit = (a) => times(1 / (norm(a) || 1), a);

const multiply = (a, b) => {
  const c = new Float32Array(16);
  for (let col = 0; col < 4; ++col) {
    for (let row = 0; row < 4; ++row) {
      let sum = 0;
      for (let k = 0; k < 4; ++k) sum += a[k * 4 + row] * b[col * 4 + k];
      c[col * 4 + row] = sum;
    }
  }
  return c;
};
const transform = (m, p) => [0, 1, 2, 3].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);

/** world_from_object of a position, a rotation and a scale. */
const placed = (position, [x, y, z, w], s = 1) => new Float32Array([
  s * (1 - 2 * (y * y + z * z)), s * 2 * (x * y + w * z), s * 2 * (x * z - w * y), 0,
  s * 2 * (x * y - w * z), s * (1 - 2 * (x * x + z * z)), s * 2 * (y * z + w * x), 0,
  s * 2 * (x * z + w * y), s * 2 * (y * z - w * x), s * (1 - 2 * (x * x + y * y)), 0,
  ...position, 1,
]);
/** The inverse of a rotation and translation. */
const rigidInverse = (m) => {
  const column = (i) => [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
  const t = column(3);
  return new Float32Array([
    m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0,
    -inner(column(0), t), -inner(column(1), t), -inner(column(2), t), 1,
  ]);
};
/** view_from_world of an eye; the view looks along -z with y up. */
const lookingAt = (eye, target, up) => {
  const z = unit(minus(eye, target)), x = unit(cross(up, z)), y = cross(z, x);
  return new Float32Array([
    x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -inner(x, eye), -inner(y, eye), -inner(z, eye), 1,
  ]);
};
const perspective = (tangentX, tangentY, near, far) => new Float32Array([
  1 / tangentX, 0, 0, 0, 0, 1 / tangentY, 0, 0, 0, 0, -(far + near) / (far - near), -1, 0, 0, (-2 * far * near) / (far - near), 0,
]);
/** Clip coordinates of a camera (x right, y down, z forward) whose image fills `share` [x, y] of the view. */
const throughCamera = ({ fx, fy, cx, cy, width, height }, share, near, far) => new Float32Array([
  (2 * fx * share[0]) / width, 0, 0, 0,
  0, (-2 * fy * share[1]) / height, 0, 0,
  ((2 * (cx + 0.5)) / width - 1) * share[0], (1 - (2 * (cy + 0.5)) / height) * share[1], (far + near) / (far - near), 1,
  0, 0, (-2 * far * near) / (far - near), 0,
]);

/** Distance along the ray to the nearest triangle, or Infinity (Moeller and Trumbore 1997). */
const rayMesh = (origin, direction, vertices, triangles) => {
  let nearest = Infinity;
  const at = (i) => [vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]];
  for (let i = 0; i < triangles.length; i += 3) {
    const a = at(triangles[i]), ab = minus(at(triangles[i + 1]), a), ac = minus(at(triangles[i + 2]), a);
    const p = cross(direction, ac), det = inner(ab, p);
    if (Math.abs(det) < 1e-12) continue;
    const t = minus(origin, a), u = inner(t, p) / det;
    if (u < 0 || u > 1) continue;
    const q = cross(t, ab), v = inner(direction, q) / det;
    if (v < 0 || u + v > 1) continue;
    const distance = inner(ac, q) / det;
    if (distance > 0 && distance < nearest) nearest = distance;
  }
  return nearest;
};
