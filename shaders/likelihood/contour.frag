#version 330 core
// SPDX-License-Identifier: Apache-2.0
// The rule of engine/render/contour.cc, which says why; keep the two alike.
uniform sampler2D depth_m;
uniform usampler2D pixel_id;
uniform float step_m;
uniform ivec2 size;
layout(location = 0) out float contour;

bool Inside(ivec2 p) { return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size)); }
float Depth(ivec2 p) { return texelFetch(depth_m, p, 0).r; }
uint Id(ivec2 p) { return texelFetch(pixel_id, p, 0).r; }

// Depth one pixel beyond `at`, coming from `before`: planes are linear in inverse depth.
float Continued(float before, float at) {
  float inverse = 2.0 / at - 1.0 / before;
  return inverse > 0.0 ? 1.0 / inverse : at;
}

bool NearSide(ivec2 p, ivec2 step_px) {
  ivec2 q = p + step_px;
  float near_depth = Depth(p), far_depth = Depth(q);
  if (far_depth == 0.0) return true;
  uint id = Id(p), other = Id(q);
  if (id != other) return near_depth < far_depth || (near_depth == far_depth && id < other);
  if (far_depth - near_depth <= step_m) return false;
  float explained = 0.0;
  ivec2 before = p - step_px, beyond = q + step_px;
  if (Inside(before) && Id(before) == id) explained = max(explained, Continued(Depth(before), near_depth) - near_depth);
  if (Inside(beyond) && Id(beyond) == id) explained = max(explained, far_depth - Continued(Depth(beyond), far_depth));
  return far_depth - near_depth > step_m + explained;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  contour = 0.0;
  float depth = Depth(p);
  if (depth == 0.0 || any(equal(p, ivec2(0))) || any(equal(p, size - 1))) return;
  // Most pixels end here, after nine look-ups.
  vec4 depths = vec4(Depth(p + ivec2(1, 0)), Depth(p - ivec2(1, 0)), Depth(p + ivec2(0, 1)), Depth(p - ivec2(0, 1)));
  uvec4 ids = uvec4(Id(p + ivec2(1, 0)), Id(p - ivec2(1, 0)), Id(p + ivec2(0, 1)), Id(p - ivec2(0, 1)));
  if (all(equal(ids, uvec4(Id(p)))) && all(lessThanEqual(depths - depth, vec4(step_m)))) return;
  if (NearSide(p, ivec2(1, 0)) || NearSide(p, ivec2(-1, 0)) || NearSide(p, ivec2(0, 1)) || NearSide(p, ivec2(0, -1))) {
    contour = 1.0;
  }
}
