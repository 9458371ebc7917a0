// SPDX-License-Identifier: Apache-2.0
#include <cctype>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "engine/annotation/pose_exchange.h"
#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/geometry/reach.h"
#include "engine/models/mesh_file.h"

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

/// Its renderer's table has 13 colours, of which label 0 is the background.
constexpr std::size_t kLabelFusionColors = 12;

/// Letters, digits and _ alone, after a letter: LabelFusion writes names into YAML as they are.
std::string Plain(std::string name) {
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  const bool letter = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0;
  return letter ? name : "object_" + name;
}

/// A name for each instance, all different: its renderer finds an object by its label's name.
std::vector<std::string> LabelFusionNames(const AnnotationDocument& document) {
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (const AnnotatedInstance& instance : document.instances) {
    std::string name = Plain(instance.id);
    while (!taken.insert(name).second) name += "_";
    names.push_back(name);
  }
  return names;
}

void AddObject(const std::string& name, const std::string& mesh, const AnnotatedInstance& instance,
               const Eigen::Isometry3d& first_from_object, YAML::Emitter& yaml) {
  const Eigen::Quaterniond q(first_from_object.linear());
  const Eigen::Vector3d t = first_from_object.translation();
  yaml << YAML::Key << YAML::DoubleQuoted << name << YAML::Value << YAML::BeginMap;
  yaml << YAML::Key << "filename" << YAML::Value << YAML::DoubleQuoted << mesh;
  yaml << YAML::Key << "model" << YAML::Value << YAML::DoubleQuoted << instance.model;
  yaml << YAML::Key << "id" << YAML::Value << YAML::DoubleQuoted << instance.id;
  yaml << YAML::Key << "pose" << YAML::Value << YAML::Flow << YAML::BeginSeq
       << std::vector<double>{t.x(), t.y(), t.z()}
       << std::vector<double>{q.w(), q.x(), q.y(), q.z()} << YAML::EndSeq << YAML::EndMap;
}

/// Rows `t x y z qx qy qz qw`, camera to first camera.
std::string PoseGraphText(const AnnotationDocument& document, const Sequence& sequence,
                          const Eigen::Isometry3d& first_from_scan) {
  std::string text;
  for (int frame = 0; frame < sequence.num_frames(); ++frame) {
    const auto scan_from_cam = ScanFromCam(document, sequence, frame);
    if (!scan_from_cam) continue;
    const Eigen::Isometry3d pose = first_from_scan * *scan_from_cam;
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d t = pose.translation();
    const std::int64_t ns = sequence.stamp_ns(frame);
    text += fmt::format("{}.{:09d} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g}\n",
                        ns / 1'000'000'000, ns % 1'000'000'000, t.x(), t.y(), t.z(), q.x(), q.y(),
                        q.z(), q.w());
  }
  return text;
}

}  // namespace

Status WriteLabelFusion(const AnnotationDocument& document, const ExchangeInputs& inputs,
                        const std::filesystem::path& folder) {
  const Result<Eigen::Isometry3d> scan_from_cam = ScanFromFirstCamera(document, inputs);
  if (!scan_from_cam) return scan_from_cam.error();
  if (!inputs.models) {
    return Error{ErrorCode::kInvalidInput,
                 "LabelFusion's folder holds the models: the project needs a model database (edit "
                 "'inputs')"};
  }
  if (folder.extension() == ".yaml") {
    return Error{ErrorCode::kInvalidInput,
                 "LabelFusion's export is a folder (registration_result.yaml, object_data.yaml, "
                 "object-meshes/); name it without '.yaml': '" +
                     folder.string() + "'"};
  }
  const std::vector<std::string> names = LabelFusionNames(document);
  if (names.size() > kLabelFusionColors) {
    log::warn("{} objects: LabelFusion's own renderer has colours for {} labels and stops at more",
              names.size(), kLabelFusionColors);
  }
  const Eigen::Isometry3d first_from_scan = scan_from_cam->inverse();
  YAML::Emitter result, objects;
  for (YAML::Emitter* yaml : {&result, &objects}) yaml->SetDoublePrecision(17);
  result << YAML::Comment("metres; model to first camera; [[x, y, z], [qw, qx, qy, qz]]")
         << YAML::BeginMap;
  objects << YAML::Comment("meshes relative to this folder, LabelFusion's data folder")
          << YAML::BeginMap;
  std::set<std::string> meshes;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const AnnotatedInstance& instance = document.instances[i];
    const auto id = inputs.models->Find(instance.model);
    if (!id) {
      return Error{ErrorCode::kInvalidInput, "the model '" + instance.model + "' of '" +
                                                 instance.id + "' is not in the database"};
    }
    const std::string mesh = "object-meshes/" + Plain(instance.model) + ".ply";
    AddObject(names[i], mesh, instance, first_from_scan * instance.scan_from_object, result);
    objects << YAML::Key << YAML::DoubleQuoted << names[i] << YAML::Value << YAML::BeginMap
            << YAML::Key << "mesh" << YAML::Value << YAML::DoubleQuoted << mesh << YAML::Key
            << "label" << YAML::Value << i + 1 << YAML::EndMap;
    if (!meshes.insert(mesh).second) continue;
    std::error_code error;
    std::filesystem::create_directories(folder / "object-meshes", error);
    const Status written = WritePly(folder / mesh, inputs.models->model(*id).mesh);
    if (!written.ok()) return written;
  }
  result << YAML::EndMap;
  objects << YAML::EndMap;
  std::error_code ignored;  // found out when a file is written
  std::filesystem::create_directories(folder, ignored);
  Status status =
      WriteFileAtomically(folder / "registration_result.yaml", std::string(result.c_str()) + "\n");
  if (status.ok()) {
    status = WriteFileAtomically(folder / "object_data.yaml", std::string(objects.c_str()) + "\n");
  }
  if (!status.ok()) return status;
  return WriteFileAtomically(folder / "posegraph.posegraph",
                             PoseGraphText(document, *inputs.sequence, first_from_scan));
}

Result<ImportedPoses> ReadLabelFusion(const AnnotationDocument& document,
                                      const ExchangeInputs& inputs,
                                      const std::filesystem::path& given) {
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(given, ignored);
  const std::filesystem::path file = is_folder ? given / "registration_result.yaml" : given;
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
      const YAML::Node id = entry.second["id"];
      instance.id = id && id.IsScalar() ? id.as<std::string>() : name;
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
