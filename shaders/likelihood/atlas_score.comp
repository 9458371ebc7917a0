#version 430 core
// SPDX-License-Identifier: Apache-2.0
// One work group reduces one tile: it finds the contour (the rule of engine/vision/viewpoint_model.cc), projects its
// samples into the image, looks up what they hit, and sums. Sums run in a fixed order.
layout(local_size_x = 16, local_size_y = 16) in;
struct Hypothesis {
  mat4 tile_from_object;
  mat4 cam_from_tile;
  vec4 pixel_step_length_unused;
};
struct Score {
  vec4 sums;         // hit * length [m], visible length [m], whole length [m], visible samples
  vec4 whole_box;    // x0, y0, x1, y1 [px]
  vec4 visible_box;
};
layout(std430, binding = 0) readonly buffer Hypotheses { Hypothesis hypotheses[]; };
layout(std430, binding = 2) writeonly buffer Scores { Score scores[]; };
uniform sampler2D planes;
uniform usampler2D hits;       // 16 bytes a pixel
uniform sampler2D occluder;    // Z [m], 0 none
uniform bool may_hide;
uniform int tile_px;
uniform int tiles_per_row;
uniform vec4 focal_and_centre;  // fx, fy, cx, cy
uniform float margin_m;
uniform float near_m;

const float kHuge = 1e30;
const float kPi = 3.14159265358979;
shared vec4 sums[256], whole[256], visible[256];

ivec2 origin;
float step_m;

vec3 Plane(ivec2 p) { return texelFetch(planes, origin + p, 0).xyz; }

bool IsStep(vec3 p, vec3 q, vec2 p_to_q) {
  if (q.x == 0.0) return true;
  float p_depth = 1.0 / p.x, q_depth = 1.0 / q.x;
  if (q_depth - p_depth < step_m) return false;
  float p_at_q = p.x + dot(p.yz, p_to_q);
  float q_at_p = q.x - dot(q.yz, p_to_q);
  return p_at_q > 0.0 && q_depth - 1.0 / p_at_q > step_m && (q_at_p <= 0.0 || 1.0 / q_at_p - p_depth > step_m);
}

bool OnContour(ivec2 at, vec3 p) {
  return IsStep(p, Plane(at + ivec2(1, 0)), vec2(1, 0)) || IsStep(p, Plane(at - ivec2(1, 0)), vec2(-1, 0)) ||
         IsStep(p, Plane(at + ivec2(0, 1)), vec2(0, 1)) || IsStep(p, Plane(at - ivec2(0, 1)), vec2(0, -1));
}

// From the side that continues this pixel's surface to the side behind it; zero where that is unclear.
vec2 OutwardNormal(ivec2 at, vec3 p) {
  vec2 toward_near = vec2(0.0);
  float depth = 1.0 / p.x;
  for (int dy = -3; dy <= 3; ++dy) {
    for (int dx = -3; dx <= 3; ++dx) {
      vec3 q = Plane(at + ivec2(dx, dy));
      vec2 offset = vec2(dx, dy);
      if (q.x == 0.0 || 1.0 / q.x >= depth + 2.0 * step_m || IsStep(p, q, offset)) continue;
      toward_near += exp(-0.5 * dot(offset, offset) / 2.25) * offset;
    }
  }
  float norm = length(toward_near);
  return norm > 0.2 ? -toward_near / norm : vec2(0.0);
}

bool Hidden(vec2 pixel, float depth, vec2 image_size) {
  if (!may_hide) return false;
  ivec2 at = ivec2(pixel * vec2(textureSize(occluder, 0)) / image_size);
  float in_front = texelFetch(occluder, at, 0).r;
  return in_front > 0.0 && in_front < depth - margin_m;
}

float Hit(ivec2 pixel, vec2 direction) {
  float turn = atan(direction.y, direction.x) / kPi;
  uint bin = uint(int((turn < 0.0 ? turn + 1.0 : turn) * 16.0)) & 15u;
  uvec4 all = texelFetch(hits, pixel, 0);
  return float((all[bin >> 2] >> (8u * (bin & 3u))) & 255u) / 255.0;
}

void AddSample(uint me, Hypothesis hypothesis, ivec2 at, vec3 p, vec2 normal) {
  float pixel = hypothesis.pixel_step_length_unused.x;
  float length_m = hypothesis.pixel_step_length_unused.z / max(abs(normal.x), abs(normal.y));
  sums[me].z += length_m;
  // The contour crosses half a pixel outwards on average.
  float inverse = p.x + 0.5 * dot(p.yz, normal);
  float tile_depth = 1.0 / (inverse > 0.0 ? inverse : p.x);
  vec2 in_tile = (vec2(at) + 0.5 * normal - 0.5 * float(tile_px - 1)) * pixel;
  vec3 point = mat3(hypothesis.cam_from_tile) * (vec3(in_tile, 1.0) * tile_depth);
  if (point.z < near_m) return;
  vec2 bearing = point.xy / point.z;
  vec2 uv = focal_and_centre.xy * bearing + focal_and_centre.zw;
  whole[me] = vec4(min(whole[me].xy, uv), max(whole[me].zw, uv));
  // Pixel centres are at integers: pixel 0 spans [-0.5, 0.5).
  vec2 image_size = vec2(textureSize(hits, 0));
  vec2 corner = uv + 0.5;
  if (any(lessThan(corner, vec2(0.0))) || any(greaterThanEqual(corner, image_size))) return;
  if (Hidden(corner, point.z, image_size)) return;
  visible[me] = vec4(min(visible[me].xy, uv), max(visible[me].zw, uv));
  vec3 across = mat3(hypothesis.cam_from_tile) * vec3(normal, 0.0);
  vec2 direction = focal_and_centre.xy * (across.xy - across.z * bearing);
  sums[me].xyw += vec3(Hit(ivec2(corner), direction) * length_m, length_m, 1.0);
}

void main() {
  uint tile = gl_WorkGroupID.x;
  uint me = gl_LocalInvocationIndex;
  Hypothesis hypothesis = hypotheses[tile];
  origin = ivec2(int(tile) % tiles_per_row, int(tile) / tiles_per_row) * tile_px;
  step_m = hypothesis.pixel_step_length_unused.y;
  sums[me] = vec4(0.0);
  whole[me] = visible[me] = vec4(kHuge, kHuge, -kHuge, -kHuge);
  for (int y = int(gl_LocalInvocationID.y); y < tile_px - 4; y += 16) {
    for (int x = int(gl_LocalInvocationID.x); x < tile_px - 4; x += 16) {
      ivec2 at = ivec2(x, y);
      if (x < 4 || y < 4) continue;
      vec3 p = Plane(at);
      if (p.x == 0.0 || !OnContour(at, p)) continue;
      vec2 normal = OutwardNormal(at, p);
      if (normal != vec2(0.0)) AddSample(me, hypothesis, at, p, normal);
    }
  }
  barrier();
  for (uint half_size = 128u; half_size > 0u; half_size >>= 1) {
    if (me < half_size) {
      uint other = me + half_size;
      sums[me] += sums[other];
      whole[me] = vec4(min(whole[me].xy, whole[other].xy), max(whole[me].zw, whole[other].zw));
      visible[me] = vec4(min(visible[me].xy, visible[other].xy), max(visible[me].zw, visible[other].zw));
    }
    barrier();
  }
  if (me == 0u) scores[tile] = Score(sums[0], whole[0], visible[0]);
}
