#version 430 core
// SPDX-License-Identifier: Apache-2.0
// The plane of the triangle in inverse depth, which is linear in the image: value and slopes. And its luminance.
in float luminance;
layout(location = 0) out vec4 plane;
void main() {
  float inverse_depth = gl_FragCoord.w;
  plane = vec4(inverse_depth, dFdx(inverse_depth), dFdy(inverse_depth), luminance);
}
