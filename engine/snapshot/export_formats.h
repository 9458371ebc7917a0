// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace plumbline {

/// A format that annotations are written in, as people choose it.
struct ExportFormat {
  const char* name;   ///< Of `annotate export --format`.
  const char* title;  ///< In the window.
  const char* file;   ///< How the file, or the folder, is called as a rule.
  const char* what;
  const char* conventions;  ///< Unit, direction, order.
  bool needs_sequence, has_frames;
  bool level, world;  ///< Frames that it can be in besides that of the scan.
};

inline constexpr std::array kExportFormats = {
    ExportFormat{"ground_truth", "Ground truth", "ground_truth.json",
                 "One file with gravity, and pose, model, category and quality of every object: "
                 "what 'plumbline evaluate' reads.",
                 "Metres. Object to the chosen frame, 4x4 matrices by rows; no quaternions.", false,
                 false, true, true},
    ExportFormat{"visma", "VISMA", "fragments",
                 "A folder with objects.json, alignment.json, result_alignment.json, the models, "
                 "the fragments of the scan and augmented_scene.ply.",
                 "Metres. Model to scan, 12 numbers of a 3x4 matrix by rows; no quaternions. "
                 "Models are turned y-up, as VISMA has them.",
                 false, false, true, false},
    ExportFormat{"bop", "BOP", "bop",
                 "A data set folder with scene_gt, scene_camera, masks, images and models with "
                 "their symmetries.",
                 "Millimetres. Model to camera (x right, y down, z forward), matrices by rows; no "
                 "quaternions. A model's origin is the middle of its box. The frame is that of "
                 "cam_R_w2c.",
                 true, true, true, false},
    ExportFormat{"labelfusion", "LabelFusion", "registration_result.yaml",
                 "One file with a pose for each object.",
                 "Metres. Model to the first camera, [[x, y, z], [qw, qx, qy, qz]]: the quaternion "
                 "begins with w.",
                 true, false, false, false},
    ExportFormat{"poses", "Poses per frame", "poses.json",
                 "One file with the pose of every object in the camera of every frame.",
                 "Metres. Object to camera (x right, y down, z forward), 4x4 matrices by rows; no "
                 "quaternions.",
                 true, true, false, false}};

}  // namespace plumbline
