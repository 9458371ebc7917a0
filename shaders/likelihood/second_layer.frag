#version 330 core
// SPDX-License-Identifier: Apache-2.0
// As depth_id.frag, but looks past everything that has the id of the nearest surface.
uniform uint id;
uniform usampler2D first_id;
layout(location = 0) out float depth_m;
layout(location = 1) out uint pixel_id;
void main() {
  if (texelFetch(first_id, ivec2(gl_FragCoord.xy), 0).r == id) discard;
  depth_m = 1.0 / gl_FragCoord.w;
  pixel_id = id;
}
