#version 330 core
// SPDX-License-Identifier: Apache-2.0
// clip.w is Z in cam, so that 1 / gl_FragCoord.w is the depth in metres.
layout(location = 0) in vec3 point_in_object;
uniform mat4 cam_from_object;
uniform mat4 clip_from_cam;
void main() { gl_Position = clip_from_cam * (cam_from_object * vec4(point_in_object, 1.0)); }
