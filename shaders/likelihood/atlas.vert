#version 430 core
// SPDX-License-Identifier: Apache-2.0
// One instance is one hypothesis; it lands in its own tile of the atlas and is cut off at the tile's edges.
layout(location = 0) in vec3 point_in_object;
layout(location = 1) in vec3 rgb;
struct Hypothesis {
  mat4 tile_from_object;
  mat4 cam_from_tile;
  vec4 pixel_step_length_unused;
};
layout(std430, binding = 0) readonly buffer Hypotheses { Hypothesis hypotheses[]; };
layout(std430, binding = 1) readonly buffer Order { uint tile_of_instance[]; };
uniform uint first_instance;
uniform int tile_px;
uniform int tiles_per_row;
uniform float near_m;
out float gl_ClipDistance[4];
out float luminance;

void main() {
  luminance = dot(rgb, vec3(0.299, 0.587, 0.114));
  uint tile = tile_of_instance[first_instance + uint(gl_InstanceID)];
  vec3 p = (hypotheses[tile].tile_from_object * vec4(point_in_object, 1.0)).xyz;
  vec2 in_tile = p.xy * 2.0 / (hypotheses[tile].pixel_step_length_unused.x * float(tile_px));
  gl_ClipDistance[0] = p.z + in_tile.x;
  gl_ClipDistance[1] = p.z - in_tile.x;
  gl_ClipDistance[2] = p.z + in_tile.y;
  gl_ClipDistance[3] = p.z - in_tile.y;
  vec2 place = vec2(int(tile) % tiles_per_row, int(tile) / tiles_per_row);
  vec2 offset = (2.0 * place + 1.0) / float(tiles_per_row) - 1.0;
  gl_Position = vec4(in_tile / float(tiles_per_row) + offset * p.z, p.z - 2.0 * near_m, p.z);
}
