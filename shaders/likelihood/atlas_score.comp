#version 430 core
// SPDX-License-Identifier: Apache-2.0
// One work group reduces one tile: it finds the contour (the rule of engine/vision/viewpoint_model.cc), projects its
// samples into the image, looks up what they hit, and sums. Inner lines (creases and marks) add what they hit beyond
// chance, but no length. Sums run in a fixed order.
layout(local_size_x = 16, local_size_y = 16) in;
struct Hypothesis {
  mat4 tile_from_object;
  mat4 cam_from_tile;
  vec4 pixel_step_length_unused;
};
struct Score {
  vec4 sums;         // (hit - chance) * length [m], visible length [m], whole length [m], visible samples
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
uniform float chance;
uniform float inner_weight;
uniform float crease_cosine;
uniform float mark_contrast;

const float kHuge = 1e30;
const float kPi = 3.14159265358979;
shared vec4 sums[256], whole[256], visible[256];

ivec2 origin;
float step_m;

vec3 Plane(ivec2 p) { return texelFetch(planes, origin + p, 0).xyz; }
float Luminance(ivec2 p) { return texelFetch(planes, origin + p, 0).w; }

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

// `at` [px] and `inverse` depth are where the line crosses. Counts as length only on the contour.
void AddSample(uint me, Hypothesis hypothesis, vec2 at, float inverse, vec2 normal, bool inner) {
  float pixel = hypothesis.pixel_step_length_unused.x;
  float length_m = hypothesis.pixel_step_length_unused.z / max(abs(normal.x), abs(normal.y));
  if (inner) length_m *= 0.5 * inner_weight;  // seen from the pixels on both sides
  if (!inner) sums[me].z += length_m;
  vec2 in_tile = (at - 0.5 * float(tile_px - 1)) * pixel;
  vec3 point = mat3(hypothesis.cam_from_tile) * (vec3(in_tile, 1.0) / inverse);
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
  sums[me].x += (Hit(ivec2(corner), direction) - chance) * length_m;
  if (!inner) sums[me].yw += vec2(length_m, 1.0);
}

void AddOutline(uint me, Hypothesis hypothesis, ivec2 at, vec3 p, vec2 normal) {
  // The contour crosses half a pixel outwards on average.
  float inverse = p.x + 0.5 * dot(p.yz, normal);
  AddSample(me, hypothesis, vec2(at) + 0.5 * normal, inverse > 0.0 ? inverse : p.x, normal, false);
}

// The normal of a plane at a pixel, towards the camera, in the tile's camera.
vec3 Facing(vec3 p, ivec2 at, float pixel) {
  vec2 from_centre = vec2(at) - 0.5 * float(tile_px - 1);
  return normalize(vec3(p.yz / pixel, p.x - dot(p.yz, from_centre)));
}

bool AddCrease(uint me, Hypothesis hypothesis, ivec2 at, int axis) {
  ivec2 along = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
  vec3 p = Plane(at - along), q = Plane(at + along);
  if (p.x == 0.0 || q.x == 0.0) return false;
  float pixel = hypothesis.pixel_step_length_unused.x;
  if (dot(Facing(p, at - along, pixel), Facing(q, at + along, pixel)) > crease_cosine) return false;
  vec2 across = p.yz - q.yz;
  if (across == vec2(0.0) || abs(across[axis]) < abs(across[1 - axis])) return false;
  vec2 normal = normalize(across);
  // Where the planes meet, along the axis; far away they are two surfaces.
  float meet = ((q.x - q[1 + axis]) - (p.x + p[1 + axis])) / across[axis];
  if (!(abs(meet) <= 1.0)) return false;
  vec2 offset = meet * normal[axis] * normal;
  float inverse = p.x + dot(p.yz, offset + vec2(along));
  if (inverse <= 0.0) return false;
  AddSample(me, hypothesis, vec2(at) + offset, inverse, normal, true);
  return true;
}

// Of the surface that the pixel shows, over a window.
vec2 LuminanceGradient(ivec2 at, vec3 p) {
  vec2 gradient = vec2(0.0);
  float here = Luminance(at);
  for (int dy = -3; dy <= 3; ++dy) {
    for (int dx = -3; dx <= 3; ++dx) {
      float q = Plane(at + ivec2(dx, dy)).x;
      vec2 offset = vec2(dx, dy);
      if (q == 0.0 || abs(1.0 / q - 1.0 / p.x) > 2.0 * step_m) continue;
      gradient += exp(-0.5 * dot(offset, offset) / 2.25) * (Luminance(at + ivec2(dx, dy)) - here) * offset;
    }
  }
  return gradient;
}

void AddMark(uint me, Hypothesis hypothesis, ivec2 at, vec3 p, int axis) {
  const ivec2 neighbours[4] = ivec2[](ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));
  for (int k = 0; k < 4; ++k) {
    float q = Plane(at + neighbours[k]).x;
    if (q == 0.0 || abs(1.0 / q - 1.0 / p.x) > step_m) return;
  }
  ivec2 along = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
  if (abs(Luminance(at + along) - Luminance(at - along)) < mark_contrast) return;
  vec2 normal = normalize(LuminanceGradient(at, p));
  if (!(abs(normal[axis]) >= abs(normal[1 - axis]))) return;
  AddSample(me, hypothesis, vec2(at), p.x, normal, true);
}

void AddInnerLines(uint me, Hypothesis hypothesis, ivec2 at, vec3 p) {
  for (int axis = 0; axis < 2; ++axis) {
    if (!AddCrease(me, hypothesis, at, axis)) AddMark(me, hypothesis, at, p, axis);
  }
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
      if (p.x == 0.0) continue;
      AddInnerLines(me, hypothesis, at, p);
      if (!OnContour(at, p)) continue;
      vec2 normal = OutwardNormal(at, p);
      if (normal != vec2(0.0)) AddOutline(me, hypothesis, at, p, normal);
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
