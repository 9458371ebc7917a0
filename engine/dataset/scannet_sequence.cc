// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/scannet_sequence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/rigid_matrix.h"
#include "engine/dataset/sens_file.h"
#include "engine/sensor/image_file.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr double kScanNetRate_hz = 30;

/// The .sens file that the path is or holds; empty without one.
fs::path SensFileAt(const fs::path& path) {
  if (path.extension() == ".sens") return path;
  const fs::path whole = fs::absolute(path).lexically_normal();
  const std::string name = (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  return IsThere(path / (name + ".sens")) ? path / (name + ".sens") : fs::path();
}

bool IsExtractedScan(const fs::path& path) {
  return IsThere(path / "color") && IsThere(path / "pose") &&
         IsThere(path / "intrinsic" / "intrinsic_color.txt");
}

/// scene0000_00 of a folder or file of that scan.
std::string ScanName(const fs::path& path) {
  fs::path whole = fs::absolute(path).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  // The extracted folder may have any name, below that of the scan.
  for (const fs::path& part : {whole, whole.parent_path()}) {
    const std::string stem =
        part.extension() == ".sens" ? part.stem().string() : part.filename().string();
    if (stem.starts_with("scene")) return stem;
  }
  return whole.stem().string();
}

std::optional<fs::path> ScanMeshOf(const fs::path& folder, const std::string& name) {
  for (const fs::path& place : {folder, folder.parent_path()}) {
    const fs::path file = place / (name + "_vh_clean_2.ply");
    if (IsThere(file)) return file;
  }
  return std::nullopt;
}

std::int64_t StampAt(double rate_hz, std::size_t number) {
  return std::llround(static_cast<double>(number) * (1e9 / rate_hz));
}

Result<std::shared_ptr<const Sequence>> OpenSens(const fs::path& path, const fs::path& file,
                                                 const SequenceOptions& options) {
  const auto sens = SensFile::Open(file);
  if (!sens.ok()) return sens.error();
  const Result<Camera> camera = MakeCamera((*sens)->color_camera(), kScanNetRate_hz, file);
  if (!camera.ok()) return camera.error();
  const Result<Camera> depth_camera = MakeCamera((*sens)->depth_camera(), kScanNetRate_hz, file);
  if (!depth_camera.ok()) return depth_camera.error();
  Recording recording;
  recording.path = path;
  recording.calibration.cameras = {{"color", *camera}};
  recording.gravity_in_world = Eigen::Vector3d(0, 0, -1);
  recording.scene_file = ScanMeshOf(file.parent_path(), file.stem().string());
  const std::vector<SensFile::Frame>& frames = (*sens)->frames();
  bool strictly = true;
  for (std::size_t i = 1; i < frames.size(); ++i)
    strictly = strictly && frames[i].color_stamp_us > frames[i - 1].color_stamp_us;
  if (frames.empty() || frames.back().color_stamp_us > 9'000'000'000'000'000ull) strictly = false;
  if (!strictly && !frames.empty())
    recording.warnings.push_back("'" + file.string() +
                                 "' has stamps that do not rise; its frames are taken as 30 Hz");
  if (!(*sens)->same_place())
    recording.warnings.push_back("'" + file.string() +
                                 "' has colour and depth cameras at different places; depth is "
                                 "brought over as if they were at one");
  for (std::size_t i = 0; i < frames.size(); ++i)
    recording.frames.push_back({strictly
                                    ? static_cast<std::int64_t>(frames[i].color_stamp_us) * 1000
                                    : StampAt(kScanNetRate_hz, i),
                                i, frames[i].world_from_cam});
  recording.read_image = [sens = *sens](std::size_t item) { return sens->ReadColor(item); };
  recording.read_depth = [sens = *sens](std::size_t item) -> Result<std::optional<cv::Mat>> {
    Result<std::optional<cv::Mat>> depth = sens->ReadDepth(item);
    if (!depth.ok() || !depth->has_value()) return depth;
    return std::optional(SeenBy(sens->color_camera(), sens->depth_camera(), **depth));
  };
  return MakeSequence(std::move(recording), options);
}

/// The camera of a 4x4 (or 3x3) matrix, whose size is that of the image.
Result<PinholeCamera> ExtractedCamera(const fs::path& matrix, const fs::path& image,
                                      ImageKind kind) {
  const Result<std::vector<double>> k = NumbersOf(matrix);
  if (!k.ok()) return k.error();
  const std::size_t columns = k->size() == 16 ? 4 : 3;
  if (k->size() != 16 && k->size() != 9)
    return Error{ErrorCode::kCorrupt, "'" + matrix.string() + "' is no 4x4 matrix"};
  const Result<cv::Mat> pixels = ReadImage(image, kind);
  if (!pixels.ok()) return pixels.error();
  const Result<Camera> camera = MakeCamera(
      {pixels->cols, pixels->rows, (*k)[0], (*k)[columns + 1], (*k)[2], (*k)[columns + 2]},
      kScanNetRate_hz, matrix);
  if (!camera.ok()) return camera.error();
  return camera->pinhole;
}

fs::path ExtractedFile(const fs::path& folder, const char* kind, std::size_t number,
                       const char* ending) {
  return folder / kind / (std::to_string(number) + ending);
}

Result<std::shared_ptr<const Sequence>> OpenExtractedScan(const fs::path& folder,
                                                          const SequenceOptions& options) {
  Recording recording;
  recording.path = folder;
  recording.gravity_in_world = Eigen::Vector3d(0, 0, -1);
  recording.scene_file = ScanMeshOf(folder, ScanName(folder));
  const char* ending = ".jpg";
  std::vector<std::size_t> numbers;
  for (const std::string& name : NamesIn(folder / "color")) {
    for (const char* possible : {".jpg", ".png"}) {
      const std::optional<int> number = NumberInName(name, "", possible);
      if (number) ending = possible;
      if (number) numbers.push_back(static_cast<std::size_t>(*number));
    }
  }
  std::sort(numbers.begin(), numbers.end());
  if (numbers.empty())
    return Error{ErrorCode::kNotFound,
                 "'" + (folder / "color").string() + "' holds no image N.jpg"};
  int lost = 0;
  for (const std::size_t number : numbers) {
    RecordedFrame frame{StampAt(kScanNetRate_hz, number), number, std::nullopt};
    const Result<std::vector<double>> pose =
        NumbersOf(ExtractedFile(folder, "pose", number, ".txt"));
    if (pose.ok() && pose->size() == 16) frame.world_from_cam = RigidFromRows(*pose);
    lost += !frame.world_from_cam.has_value();
    recording.frames.push_back(frame);
  }
  if (lost > 0)
    recording.warnings.push_back("'" + folder.string() + "' has " + std::to_string(lost) +
                                 " frames without a pose (tracking was lost)");
  const fs::path intrinsic = folder / "intrinsic";
  const Result<PinholeCamera> color =
      ExtractedCamera(intrinsic / "intrinsic_color.txt",
                      ExtractedFile(folder, "color", numbers.front(), ending), ImageKind::kColor);
  if (!color.ok()) return color.error();
  const Result<Camera> camera = MakeCamera(*color, kScanNetRate_hz, intrinsic);
  if (!camera.ok()) return camera.error();
  recording.calibration.cameras = {{"color", *camera}};
  const cv::Size size(color->width, color->height);
  recording.read_image = [folder, ending, size](std::size_t number) {
    return ReadImage(ExtractedFile(folder, "color", number, ending), ImageKind::kColor, size);
  };
  const fs::path first_depth = ExtractedFile(folder, "depth", numbers.front(), ".png");
  if (IsThere(first_depth)) {
    const Result<PinholeCamera> depth =
        ExtractedCamera(intrinsic / "intrinsic_depth.txt", first_depth, ImageKind::kDepth);
    if (!depth.ok()) return depth.error();
    recording.read_depth = [folder, color = *color,
                            depth = *depth](std::size_t number) -> Result<std::optional<cv::Mat>> {
      const fs::path file = ExtractedFile(folder, "depth", number, ".png");
      if (!IsThere(file)) return std::optional<cv::Mat>();
      const Result<cv::Mat> read = DepthFromFile(file, {depth.width, depth.height}, 1000);
      if (!read.ok()) return read.error();
      return std::optional(SeenBy(color, depth, *read));
    };
  }
  return MakeSequence(std::move(recording), options);
}

/// COCO's names for categories of ShapeNet that have one.
std::string CategoryOfShapeNet(const std::string& catid) {
  static const std::map<std::string, std::string> kCategories = {
      {"03001627", "chair"},     {"04379243", "dining table"}, {"04256520", "couch"},
      {"02818832", "bed"},       {"03211117", "tv"},           {"03642806", "laptop"},
      {"03761084", "microwave"}, {"02876657", "bottle"},       {"02880940", "bowl"},
      {"03797390", "cup"},       {"03046257", "clock"},        {"03991062", "potted plant"},
      {"04401088", "cell phone"}};
  const auto found = kCategories.find(catid);
  return found == kCategories.end() ? catid : found->second;
}

struct SimilarityParts {
  Eigen::Isometry3d rigid = Eigen::Isometry3d::Identity();
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< Before the rotation.
};

std::optional<SimilarityParts> PartsOf(const nlohmann::json& owner) {
  if (!owner.is_object() || !owner.contains("trs") || !owner["trs"].is_object()) return {};
  const nlohmann::json& trs = owner["trs"];
  const auto vector = [&trs](const char* key, int size) {
    return trs.contains(key) ? VectorFromJson(trs[key], size) : std::nullopt;
  };
  const auto t = vector("translation", 3), q = vector("rotation", 4), s = vector("scale", 3);
  if (!t || !q || !s || !(std::abs(q->norm() - 1) < 0.01) || !(s->minCoeff() > 1e-3) ||
      !(s->maxCoeff() < 1e3) || !(t->norm() < 1e5))
    return std::nullopt;
  SimilarityParts parts;
  parts.rigid.linear() =
      Eigen::Quaterniond((*q)[0], (*q)[1], (*q)[2], (*q)[3]).normalized().toRotationMatrix();
  parts.rigid.translation() = *t;
  parts.scale = *s;
  return parts;
}

/// The instance, or what is wrong with it.
Result<GroundTruthInstance> InstanceOfScan2Cad(const nlohmann::json& model,
                                               const SimilarityParts& scan,
                                               const ModelFrames& models,
                                               std::vector<std::string>& warnings) {
  const auto bad = [](const char* what) { return Error{ErrorCode::kInvalidInput, what}; };
  const auto parts = PartsOf(model);
  const auto id = TextFromJson(model, "id_cad"), category = TextFromJson(model, "catid_cad");
  if (!parts || !id || !category) return bad("needs texts 'id_cad', 'catid_cad' and a 'trs'");
  const auto vector = [&model](const char* key) {
    return model.contains(key) ? VectorFromJson(model[key], 3) : std::nullopt;
  };
  const auto center = vector("center"), half = vector("bbox");
  if (!center || !half || !(half->minCoeff() > 0) || !(half->maxCoeff() < 1e3) ||
      !(center->norm() < 1e3))
    return bad("needs 'center' and 'bbox' of three numbers");
  const double by = 1 / scan.scale.x();
  // Axes of `object` in those of the CAD model: x its front (-z), z its up (+y).
  Eigen::Matrix3d cad_from_object;
  cad_from_object.col(0) << 0, 0, -1;
  cad_from_object.col(1) << -1, 0, 0;
  cad_from_object.col(2) << 0, 1, 0;
  Eigen::Vector3d foot = *center - Eigen::Vector3d(0, (*half)[1], 0);
  GroundTruthInstance instance;
  instance.model = *id;
  if (const Eigen::Isometry3d* built = FindModelFrame(models, *id, warnings)) {
    cad_from_object = built->linear().transpose();
    foot = built->inverse().translation();
  }
  const Eigen::Vector3d foot_in_scaled = parts->scale.cwiseProduct(foot);
  instance.category = CategoryOfShapeNet(*category);
  const Eigen::Matrix3d scan_from_their_world = scan.rigid.linear().transpose();
  instance.world_from_object.linear() =
      scan_from_their_world * parts->rigid.linear() * cad_from_object;
  instance.world_from_object.translation() =
      by * (scan_from_their_world * (parts->rigid * foot_in_scaled - scan.rigid.translation()));
  const Eigen::Vector3d size = 2 * by * parts->scale.cwiseProduct(Eigen::Vector3d(*half));
  instance.size_m = (cad_from_object.transpose() * size).cwiseAbs();
  instance.scale = by * std::cbrt(parts->scale.prod());
  if (!(instance.scale > 0.1 && instance.scale < 10))
    return bad("has a 'scale' that is not between 0.1 and 10");
  return instance;
}

}  // namespace

Likeness ProbeScanNet(const fs::path& path) {
  const fs::path sens = SensFileAt(path);
  return (!sens.empty() && IsThere(sens)) || IsExtractedScan(path) ? Likeness::kCertain
                                                                   : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenScanNet(const fs::path& path,
                                                    const SequenceOptions& options) {
  if (const fs::path sens = SensFileAt(path); !sens.empty()) return OpenSens(path, sens, options);
  return OpenExtractedScan(path, options);
}

Result<std::optional<GroundTruth>> ReadScan2Cad(const fs::path& file, const ModelFrames& models,
                                                const std::string& scan,
                                                std::vector<std::string>& warnings) {
  const Result<nlohmann::json> json = ReadJson(file);
  if (!json.ok()) return json.error();
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "'" + file.string() + "' " + what};
  };
  if (!json->is_array()) return bad("is no list of scans");
  for (const nlohmann::json& entry : *json) {
    if (TextFromJson(entry, "id_scan") != scan) continue;
    const auto parts = PartsOf(entry);
    if (!parts || !entry.contains("aligned_models") || !entry["aligned_models"].is_array())
      return bad("has no 'trs' and list 'aligned_models' for " + scan);
    if ((parts->scale.array() - parts->scale.x()).abs().maxCoeff() > 1e-6 * parts->scale.x())
      return bad("stretches " + scan + " by different scales along its axes");
    GroundTruth truth;
    // The world of a scan of ScanNet is z up.
    truth.gravity_in_world = Eigen::Vector3d(0, 0, -1);
    for (const nlohmann::json& model : entry["aligned_models"]) {
      Result<GroundTruthInstance> instance = InstanceOfScan2Cad(model, *parts, models, warnings);
      const std::string number = std::to_string(truth.instances.size());
      if (!instance.ok()) {
        warnings.push_back("'" + file.string() + "': a model of " + scan + " " +
                           instance.error().message + "; left out");
        continue;
      }
      instance->id = instance->model + "_" + number;
      truth.instances.push_back(std::move(*instance));
    }
    return std::optional(std::move(truth));
  }
  return std::optional<GroundTruth>();
}

Result<std::optional<GroundTruth>> TruthOfScanNet(const Sequence& sequence,
                                                  const ModelFrames& models,
                                                  std::vector<std::string>& warnings) {
  fs::path folder = fs::absolute(sequence.path()).lexically_normal();
  if (!folder.has_filename() || folder.extension() == ".sens") folder = folder.parent_path();
  for (int level = 0; level < 3; ++level, folder = folder.parent_path()) {
    const fs::path file = folder / "full_annotations.json";
    if (IsThere(file)) return ReadScan2Cad(file, models, ScanName(sequence.path()), warnings);
  }
  return std::optional<GroundTruth>();
}

}  // namespace plumbline
