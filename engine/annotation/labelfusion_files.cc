// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <yaml-cpp/yaml.h>

#include "engine/annotation/pose_exchange.h"
#include "engine/base/files.h"
#include "engine/geometry/reach.h"

namespace plumbline {
namespace {

/// Of the first frame that has a pose: LabelFusion's world.
Result<Eigen::Isometry3d> ScanFromFirstCamera(const AnnotationDocument& document,
                                              const ExchangeInputs& inputs) {
  if (inputs.sequence) {
    for (int frame = 0; frame < inputs.sequence->num_frames(); ++frame) {
      if (const auto pose = ScanFromCam(document, *inputs.sequence, frame)) return *pose;
    }
  }
  return Error{ErrorCode::kInvalidInput,
               "LabelFusion's poses are in the first camera: the project needs a sequence (edit "
               "'inputs') with camera poses"};
}

/// Numbers of a flat list of `size`.
std::optional<std::vector<double>> Numbers(const YAML::Node& node, std::size_t size) {
  if (!node.IsSequence() || node.size() != size) return std::nullopt;
  std::vector<double> numbers;
  for (const YAML::Node& entry : node) {
    double number = 0;
    if (!YAML::convert<double>::decode(entry, number) || !std::isfinite(number))
      return std::nullopt;
    numbers.push_back(number);
  }
  return numbers;
}

std::optional<Eigen::Isometry3d> PoseOf(const YAML::Node& pose) {
  if (!pose.IsSequence() || pose.size() != 2) return std::nullopt;
  const auto t = Numbers(pose[0], 3), q = Numbers(pose[1], 4);
  if (!t || !q) return std::nullopt;
  const Eigen::Quaterniond quaternion((*q)[0], (*q)[1], (*q)[2], (*q)[3]);
  const Eigen::Vector3d translation((*t)[0], (*t)[1], (*t)[2]);
  if (!(std::abs(quaternion.norm() - 1) < 1e-2) || translation.cwiseAbs().maxCoeff() > kFarthest_m)
    return std::nullopt;
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  isometry.linear() = quaternion.normalized().toRotationMatrix();
  isometry.translation() = translation;
  return isometry;
}

}  // namespace

Status WriteLabelFusion(const AnnotationDocument& document, const ExchangeInputs& inputs,
                        const std::filesystem::path& file) {
  const Result<Eigen::Isometry3d> scan_from_cam = ScanFromFirstCamera(document, inputs);
  if (!scan_from_cam) return scan_from_cam.error();
  YAML::Emitter yaml;
  yaml.SetDoublePrecision(17);
  yaml << YAML::Comment(
              "metres; model to first camera; [[x, y, z], [qw, qx, qy, qz]]; where there is "
              "a scale, the model is enlarged by it first")
       << YAML::BeginMap;
  for (const AnnotatedInstance& instance : document.instances) {
    const Eigen::Isometry3d pose = scan_from_cam->inverse() * instance.scan_from_object;
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d t = pose.translation();
    yaml << YAML::Key << instance.id << YAML::Value << YAML::BeginMap;
    yaml << YAML::Key << "filename" << YAML::Value
         << (inputs.models && inputs.models->Find(instance.model)
                 ? inputs.models->model(*inputs.models->Find(instance.model)).file
                 : instance.model);
    yaml << YAML::Key << "model" << YAML::Value << instance.model;
    if (instance.scale != 1) yaml << YAML::Key << "scale" << YAML::Value << instance.scale;
    yaml << YAML::Key << "pose" << YAML::Value << YAML::Flow << YAML::BeginSeq
         << std::vector<double>{t.x(), t.y(), t.z()}
         << std::vector<double>{q.w(), q.x(), q.y(), q.z()} << YAML::EndSeq << YAML::EndMap;
  }
  yaml << YAML::EndMap;
  return WriteFileAtomically(file, std::string(yaml.c_str()) + "\n");
}

Result<ImportedPoses> ReadLabelFusion(const AnnotationDocument& document,
                                      const ExchangeInputs& inputs,
                                      const std::filesystem::path& file) {
  const Result<Eigen::Isometry3d> scan_from_cam = ScanFromFirstCamera(document, inputs);
  if (!scan_from_cam) return scan_from_cam.error();
  const Result<std::string> text = ReadFile(file);
  if (!text) return text.error();
  ImportedPoses imported;
  std::vector<Eigen::Vector3d> translations;
  try {
    const YAML::Node root = YAML::Load(*text);
    if (!root.IsMap()) {
      return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' must map names to poses"};
    }
    for (const auto& entry : root) {
      if (!entry.second.IsMap()) continue;  // LabelFusion's own file holds a text `frame`
      const auto name = entry.first.as<std::string>();
      const auto pose = entry.second["pose"] ? PoseOf(entry.second["pose"]) : std::nullopt;
      if (!pose) {
        return Error{ErrorCode::kInvalidInput,
                     "'" + file.string() + "': '" + name +
                         "' has no pose [[x, y, z], [qw, qx, qy, qz]] within 1000 km"};
      }
      AnnotatedInstance instance;
      instance.id = name;
      const YAML::Node model = entry.second["model"];
      instance.model = model && model.IsScalar() ? model.as<std::string>() : name;
      instance.scan_from_object = *scan_from_cam * *pose;
      if (const YAML::Node scale = entry.second["scale"]; scale && scale.IsScalar())
        instance.scale = scale.as<double>();
      translations.push_back(pose->translation());
      imported.instances.push_back(std::move(instance));
    }
  } catch (const YAML::Exception& error) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() + "' is not valid YAML: " + error.what()};
  }
  if (auto warning = MetreWarning(translations, file.string())) {
    imported.warnings.push_back(std::move(*warning));
  }
  return imported;
}

}  // namespace plumbline
