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
    ExportFormat{"visma", "VISMA", "visma",
                 "A folder as VISMA has it for a sequence: the scan, result_alignment.json, the "
                 "models, and fragments/ with objects.json, alignment.json, the fragments of the "
                 "scan and augmented_scene.ply.",
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
    ExportFormat{"labelfusion", "LabelFusion", "labelfusion",
                 "A folder with registration_result.yaml, object_data.yaml, the meshes and the "
                 "cameras.",
                 "Metres. Model to the first camera, [[x, y, z], [qw, qx, qy, qz]]: the quaternion "
                 "begins with w.",
                 true, false, false, false},
    ExportFormat{"poses", "Poses per frame", "poses.json",
                 "One file with the pose of every object in the camera of every frame.",
                 "Metres. Object to camera (x right, y down, z forward), 4x4 matrices by rows; no "
                 "quaternions.",
                 true, true, false, false},
    ExportFormat{"coco", "COCO", "coco",
                 "A folder with instances.json (boxes, masks, categories), the images, and for "
                 "each an image of instance numbers.",
                 "Pixels. What shows of each object; categories by COCO's numbers.", true, true,
                 false, false},
    ExportFormat{"scan2cad", "Scan2CAD", "scan2cad",
                 "A folder with full_annotations.json, and models and scan where Scan2CAD's "
                 "scripts look for them.",
                 "Metres, y up. CAD to world: translation, rotation (begins with w), scale.", false,
                 false, false, false},
    ExportFormat{"gltf", "glTF", "room.glb",
                 "One file with every model at its place, named, as Blender and others open it.",
                 "Metres, y up. Node by node: translation, rotation (ends with w), scale.", false,
                 false, true, false}};

}  // namespace plumbline
