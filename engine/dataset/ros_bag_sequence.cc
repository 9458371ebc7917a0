// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/ros_bag_sequence.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/bag_file.h"
#include "engine/dataset/json_fields.h"
#include "engine/dataset/recorded_sequence.h"
#include "engine/dataset/ros_messages.h"
#include "engine/dataset/stamped_rows.h"
#include "engine/dataset/transform_tree.h"
#include "engine/sensor/image_decoding.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kBagDepthWithin_ns = 20'000'000;
constexpr std::size_t kRosHeaderBytes = 4096;

bool IsRosImage(const BagTopic& topic) {
  return topic.type == "sensor_msgs/Image" || topic.type == "sensor_msgs/CompressedImage";
}
bool IsRosDepth(const BagTopic& topic) {
  return IsRosImage(topic) && topic.name.find("depth") != std::string::npos;
}

/// NAME.bag.json and what it lacks.
struct BagChoice {
  nlohmann::json json = nlohmann::json::object();
  fs::path file;
  std::string Text(const char* key) const { return TextFromJson(json, key).value_or(""); }
};

Result<BagChoice> ReadBagChoice(const fs::path& bag) {
  BagChoice choice;
  choice.file = bag.string() + ".json";
  if (!IsThere(choice.file)) return choice;
  Result<nlohmann::json> json = ReadJson(choice.file);
  if (!json.ok()) return json.error();
  if (!json->is_object())
    return Error{ErrorCode::kInvalidInput, "'" + choice.file.string() + "' is not an object"};
  choice.json = std::move(*json);
  return choice;
}

/// A message by the stamp of its own header.
struct SentMessage {
  std::int64_t stamp_ns = 0;
  BagMessage message;
};

class BagReader {
 public:
  BagReader(std::shared_ptr<const BagFile> bag, BagChoice choice)
      : bag_(std::move(bag)), choice_(std::move(choice)) {}

  Result<Recording> Read();

 private:
  /// The name of a topic: the one that is chosen, or that of most messages.
  Result<std::string> Choose(const char* key,
                             const std::function<bool(const BagTopic&)>& fits) const;
  std::vector<const BagMessage*> MessagesOf(const std::string& topic) const;
  Result<std::vector<SentMessage>> ByHeader(const std::string& topic, const char* what);
  Result<Camera> CameraOf(const std::string& image_topic, const SentMessage& first) const;
  Result<cv::Size> SizeOf(const SentMessage& image) const;
  Status AddDepth(const std::vector<SentMessage>& images, cv::Size size);
  Status AddImu(const std::string& camera_frame, Camera& camera);
  void ReadTransforms();
  Status ReadPoses(const std::string& camera_frame);
  std::string FrameOf(const BagMessage& message) const;

  std::shared_ptr<const BagFile> bag_;
  BagChoice choice_;
  Recording recording_;
  TransformTree tree_;
};

Result<cv::Mat> DecodeBagImage(const BagFile& bag, const BagMessage& message, bool depth) {
  const Result<std::string> bytes = bag.Read(message);
  if (!bytes.ok()) return bytes.error();
  const BagTopic& topic = bag.topics()[message.topic];
  const std::string name = bag.path().string() + " " + topic.name;
  if (topic.type == "sensor_msgs/Image") {
    Result<cv::Mat> image = depth ? ParseRosDepth(*bytes) : ParseRosImage(*bytes);
    if (image.ok()) return image;
    return Error{image.error().code, "'" + name + "': " + image.error().message};
  }
  const auto file = ParseRosCompressed(*bytes);
  if (!file) return Error{ErrorCode::kCorrupt, "'" + name + "': an image message is damaged"};
  return DecodeImage(std::string(*file), depth ? ImageKind::kDepth : ImageKind::kColor,
                     std::nullopt, name);
}

Result<std::string> BagReader::Choose(const char* key,
                                      const std::function<bool(const BagTopic&)>& fits) const {
  const std::string chosen = choice_.Text(key);
  std::map<std::string, int> counts;
  for (const BagMessage& message : bag_->messages()) {
    const BagTopic& topic = bag_->topics()[message.topic];
    if (!chosen.empty() ? topic.name == chosen : fits(topic)) ++counts[topic.name];
  }
  if (!chosen.empty() && counts.empty()) {
    return Error{ErrorCode::kInvalidInput, "'" + choice_.file.string() + "' names the " + key +
                                               " '" + chosen +
                                               "', of which the bag has no message"};
  }
  std::string best;
  int most = 0;
  for (const auto& [name, count] : counts) {
    if (count <= most) continue;
    most = count;
    best = name;
  }
  return best;
}

std::vector<const BagMessage*> BagReader::MessagesOf(const std::string& topic) const {
  std::vector<const BagMessage*> messages;
  for (const BagMessage& message : bag_->messages()) {
    if (bag_->topics()[message.topic].name == topic) messages.push_back(&message);
  }
  return messages;
}

Result<std::vector<SentMessage>> BagReader::ByHeader(const std::string& topic, const char* what) {
  std::vector<SentMessage> sent;
  int unreadable = 0;
  for (const BagMessage* message : MessagesOf(topic)) {
    const Result<std::string> bytes = bag_->Read(*message, kRosHeaderBytes);
    const auto header = bytes.ok() ? ParseRosHeader(*bytes) : std::nullopt;
    unreadable += !header.has_value();
    if (header)
      sent.push_back({header->stamp_ns != 0 ? header->stamp_ns : message->stamp_ns, *message});
  }
  if (unreadable > 0) {
    recording_.warnings.push_back("'" + bag_->path().string() + "' has " +
                                  std::to_string(unreadable) + " damaged messages of '" + topic +
                                  "'; left out");
  }
  MakeStampsRise(bag_->path(), what, sent, recording_.warnings);
  return sent;
}

std::string BagReader::FrameOf(const BagMessage& message) const {
  const Result<std::string> bytes = bag_->Read(message, kRosHeaderBytes);
  const auto header = bytes.ok() ? ParseRosHeader(*bytes) : std::nullopt;
  return header ? header->frame : std::string();
}

Result<cv::Size> BagReader::SizeOf(const SentMessage& image) const {
  const Result<cv::Mat> decoded = DecodeBagImage(*bag_, image.message, false);
  if (!decoded.ok()) return decoded.error();
  return decoded->size();
}

/// The topic beside an image topic: of /a/image_raw/compressed and of /a/image_raw it is
/// /a/camera_info.
std::string CameraInfoBeside(std::string topic) {
  for (const char* ending : {"/compressed", "/compressedDepth"}) {
    if (topic.ends_with(ending)) topic.resize(topic.size() - std::string_view(ending).size());
  }
  return topic.substr(0, topic.rfind('/') + 1) + "camera_info";
}

Result<Camera> CameraFromRos(const RosCameraInfo& info, bool rectified, double rate_hz,
                             const fs::path& file) {
  const Eigen::Matrix3d k =
      rectified ? Eigen::Matrix3d(info.projection.leftCols<3>()) : info.intrinsics;
  nlohmann::json json = {{"width", info.width}, {"height", info.height}, {"fx", k(0, 0)},
                         {"fy", k(1, 1)},       {"cx", k(0, 2)},         {"cy", k(1, 2)},
                         {"rate_hz", rate_hz},  {"model", "pinhole"}};
  std::vector<double> distortion = rectified ? std::vector<double>() : info.distortion;
  while (!distortion.empty() && distortion.back() == 0) distortion.pop_back();
  if (!distortion.empty()) {
    const bool equidistant =
        info.distortion_model == "equidistant" || info.distortion_model == "fisheye";
    if ((!equidistant && info.distortion_model != "plumb_bob" &&
         info.distortion_model != "rational_polynomial") ||
        distortion.size() > (equidistant ? 4 : 5)) {
      return Error{ErrorCode::kUnsupported,
                   "'" + file.string() + "' has a camera with '" + info.distortion_model +
                       "' distortion of " + std::to_string(distortion.size()) +
                       " numbers; this version reads plumb_bob and equidistant"};
    }
    distortion.resize(equidistant || distortion.size() <= 4 ? 4 : 5);
    json["model"] = equidistant ? "equidistant" : "radial_tangential";
    json["distortion"] = distortion;
  }
  return CameraFromJson(json, file);
}

Result<Camera> BagReader::CameraOf(const std::string& image_topic, const SentMessage& first) const {
  if (choice_.json.contains("camera")) return CameraFromJson(choice_.json["camera"], choice_.file);
  const std::string topic = CameraInfoBeside(image_topic);
  const std::vector<const BagMessage*> messages = MessagesOf(topic);
  if (messages.empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "the bag '" + bag_->path().string() + "' has no '" + topic + "' for '" +
                     image_topic + "'; describe the camera in '" + choice_.file.string() +
                     "' ({\"camera\": as camera.json}, docs/data_sets.md)"};
  }
  const Result<std::string> bytes = bag_->Read(*messages.front());
  if (!bytes.ok()) return bytes.error();
  std::optional<RosCameraInfo> info = ParseRosCameraInfo(*bytes);
  if (!info || bag_->topics()[messages.front()->topic].type != "sensor_msgs/CameraInfo") {
    return Error{ErrorCode::kCorrupt,
                 "'" + topic + "' in the bag '" + bag_->path().string() + "' is no camera_info"};
  }
  const Result<cv::Size> size = SizeOf(first);
  if (!size.ok()) return size.error();
  // Some drivers leave the size at 0.
  if (info->width == 0 && info->height == 0) {
    info->width = size->width;
    info->height = size->height;
  }
  return CameraFromRos(*info, image_topic.find("rect") != std::string::npos, 30, bag_->path());
}

void BagReader::ReadTransforms() {
  int damaged = 0;
  for (const BagMessage& message : bag_->messages()) {
    const BagTopic& topic = bag_->topics()[message.topic];
    if (topic.type != "tf/tfMessage" && topic.type != "tf2_msgs/TFMessage") continue;
    const Result<std::string> bytes = bag_->Read(message);
    const auto transforms = bytes.ok() ? ParseRosTransforms(*bytes) : std::nullopt;
    damaged += !transforms.has_value();
    if (!transforms) continue;
    for (const RosTransform& transform : *transforms)
      tree_.Add(transform, topic.name.ends_with("tf_static"));
  }
  tree_.Finish();
  if (damaged > 0)
    recording_.warnings.push_back("'" + bag_->path().string() + "' has " + std::to_string(damaged) +
                                  " damaged messages of TF; left out");
}

Status BagReader::ReadPoses(const std::string& camera_frame) {
  const std::string chosen = choice_.Text("world_frame");
  const std::string world = chosen.empty() ? tree_.RootAbove(camera_frame) : chosen;
  if (!tree_.Moves(world, camera_frame)) {
    if (!chosen.empty())
      return Error{ErrorCode::kInvalidInput,
                   "'" + choice_.file.string() + "' names the world_frame '" + chosen +
                       "', above which nothing moves towards '" + camera_frame + "' in the bag"};
    return {};
  }
  for (RecordedFrame& frame : recording_.frames)
    frame.world_from_cam = tree_.At(world, camera_frame, frame.stamp_ns);
  recording_.gravity_in_world = Eigen::Vector3d(0, 0, -1);
  return {};
}

Result<ImuRecording> ReadBagImu(const BagFile& bag, const std::vector<BagMessage>& messages) {
  ImuRecording recording;
  int damaged = 0;
  for (const BagMessage& message : messages) {
    const Result<std::string> bytes = bag.Read(message);
    const auto imu = bytes.ok() ? ParseRosImu(*bytes) : std::nullopt;
    damaged += !imu.has_value();
    if (!imu) continue;
    recording.samples.push_back(
        {imu->header.stamp_ns != 0 ? imu->header.stamp_ns : message.stamp_ns,
         imu->angular_velocity_rad_s, imu->specific_force_m_s2});
  }
  if (damaged > 0)
    recording.warnings.push_back("'" + bag.path().string() + "' has " + std::to_string(damaged) +
                                 " damaged messages of the IMU; left out");
  if (recording.samples.empty())
    return Error{ErrorCode::kCorrupt,
                 "the bag '" + bag.path().string() + "' holds no usable IMU sample"};
  MakeStampsRise(bag.path(), "IMU samples", recording.samples, recording.warnings);
  return recording;
}

/// The depth image nearest in time to an image, if it is near.
Result<std::optional<cv::Mat>> ReadBagDepth(const BagFile& bag,
                                            const std::vector<SentMessage>& depths,
                                            std::int64_t stamp_ns, cv::Size size) {
  const auto near = std::min_element(
      depths.begin(), depths.end(), [stamp_ns](const SentMessage& a, const SentMessage& b) {
        return std::abs(a.stamp_ns - stamp_ns) < std::abs(b.stamp_ns - stamp_ns);
      });
  if (near == depths.end() || std::abs(near->stamp_ns - stamp_ns) > kBagDepthWithin_ns)
    return std::optional<cv::Mat>();
  Result<cv::Mat> depth = DecodeBagImage(bag, near->message, true);
  if (!depth.ok()) return depth.error();
  if (depth->size() != size)
    return Error{ErrorCode::kInvalidInput, "depth in '" + bag.path().string() +
                                               "' is not of the size of the images; only "
                                               "registered depth is read"};
  return std::optional(std::move(*depth));
}

Status BagReader::AddDepth(const std::vector<SentMessage>& images, cv::Size size) {
  const auto topic = Choose("depth_topic", IsRosDepth);
  if (!topic.ok()) return topic.error();
  if (topic->empty()) return {};
  const Result<std::vector<SentMessage>> depths = ByHeader(*topic, "depth images");
  if (!depths.ok()) return depths.error();
  recording_.read_depth = [bag = bag_, images, depths = *depths, size](std::size_t item) {
    return ReadBagDepth(*bag, depths, images[item].stamp_ns, size);
  };
  return {};
}

Status BagReader::AddImu(const std::string& camera_frame, Camera& camera) {
  if (choice_.json.contains("imu")) {
    const Result<ImuCalibration> imu = ImuCalibrationFromJson(choice_.json["imu"], choice_.file);
    if (!imu.ok()) return imu.error();
    recording_.calibration.imu = *imu;
  }
  const auto name =
      Choose("imu_topic", [](const BagTopic& topic) { return topic.type == "sensor_msgs/Imu"; });
  if (!name.ok()) return name.error();
  if (name->empty()) return {};
  std::vector<BagMessage> messages;
  for (const BagMessage* message : MessagesOf(*name)) messages.push_back(*message);
  if (!camera.body_from_cam)
    camera.body_from_cam = tree_.Rigid(FrameOf(messages.front()), camera_frame);
  recording_.read_imu = [bag = bag_, messages] { return ReadBagImu(*bag, messages); };
  return {};
}

Result<Recording> BagReader::Read() {
  recording_.path = bag_->path();
  const auto image_topic = Choose(
      "image_topic", [](const BagTopic& topic) { return IsRosImage(topic) && !IsRosDepth(topic); });
  if (!image_topic.ok()) return image_topic.error();
  if (image_topic->empty())
    return Error{ErrorCode::kInvalidInput, "the bag '" + bag_->path().string() +
                                               "' has no images (sensor_msgs/Image or "
                                               "CompressedImage)"};
  const Result<std::vector<SentMessage>> images = ByHeader(*image_topic, "images");
  if (!images.ok()) return images.error();
  if (images->empty())
    return Error{ErrorCode::kCorrupt,
                 "no image of '" + *image_topic + "' in '" + bag_->path().string() + "' is whole"};
  for (std::size_t i = 0; i < images->size(); ++i)
    recording_.frames.push_back({(*images)[i].stamp_ns, i, std::nullopt});
  Result<Camera> camera = CameraOf(*image_topic, images->front());
  if (!camera.ok()) return camera.error();
  const cv::Size size(camera->pinhole.width, camera->pinhole.height);
  recording_.read_image = [bag = bag_, images = *images,
                           size](std::size_t item) -> Result<cv::Mat> {
    Result<cv::Mat> image = DecodeBagImage(*bag, images[item].message, false);
    if (image.ok() && image->size() != size)
      return Error{ErrorCode::kInvalidInput,
                   "an image of '" + bag->path().string() + "' is not of the size of its camera"};
    return image;
  };
  if (Status added = AddDepth(*images, size); !added.ok()) return added.error();
  ReadTransforms();
  const std::string named = choice_.Text("camera_frame");
  const std::string camera_frame = named.empty() ? FrameOf(images->front().message) : named;
  if (Status read = ReadPoses(camera_frame); !read.ok()) return read.error();
  if (Status added = AddImu(camera_frame, *camera); !added.ok()) return added.error();
  recording_.calibration.cameras = {{*image_topic, *camera}};
  return std::move(recording_);
}

}  // namespace

Likeness ProbeRosBag(const fs::path& path) {
  if (path.extension() != ".bag") return Likeness::kNone;
  constexpr std::string_view kBegin = "#ROSBAG ";
  const auto file = RandomAccessFile::Open(path);  // does not wait, as a pipe would have it
  if (!file.ok() || file->size() < kBegin.size()) return Likeness::kNone;
  const auto begin = file->Read(0, kBegin.size());
  return begin.ok() && *begin == kBegin ? Likeness::kCertain : Likeness::kNone;
}

Result<std::shared_ptr<const Sequence>> OpenRosBag(const fs::path& file,
                                                   const SequenceOptions& options) {
  const auto bag = BagFile::Open(file);
  if (!bag.ok()) return bag.error();
  Result<BagChoice> choice = ReadBagChoice(file);
  if (!choice.ok()) return choice.error();
  Result<Recording> recording = BagReader(*bag, std::move(*choice)).Read();
  if (!recording.ok()) return recording.error();
  return MakeSequence(std::move(*recording), options);
}

}  // namespace plumbline
