#version 330 core
// SPDX-License-Identifier: Apache-2.0
uniform uint id;
layout(location = 0) out float depth_m;
layout(location = 1) out uint pixel_id;
void main() {
  depth_m = 1.0 / gl_FragCoord.w;
  pixel_id = id;
}
