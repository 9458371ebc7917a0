// SPDX-License-Identifier: Apache-2.0
#include "app/report/run_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <set>
#include <span>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "app/report/html_page.h"
#include "app/report/run_page_json.h"
#include "app/report/svg_plot.h"
#include "engine/analysis/sequence_view.h"
#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/base/resources.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/vertex_clustering.h"
#include "engine/models/mesh_decimation.h"
#include "engine/pipeline/frame_pictures.h"

void RegisterResources_plumbline();  // made by cmake/Embed.cmake

namespace plumbline {
namespace {

constexpr int kModelFaces = 2500;
constexpr std::size_t kPageScanVertices = 25'000, kPageModelVertices = 20'000;
constexpr std::size_t kPagePoints = 20'000;

Result<std::string> PageResource(const std::string& name) {
  static std::once_flag registered;
  std::call_once(registered, RegisterResources_plumbline);
  return LoadResource("assets/run_page/" + name);
}

/// The template with every {{name}} replaced; what is put in is not looked at again.
std::string Filled(const std::string& page, const std::map<std::string, std::string>& values) {
  std::string filled;
  std::size_t at = 0;
  for (;;) {
    const std::size_t open = page.find("{{", at), close = page.find("}}", open);
    filled.append(page, at, open - at);
    if (open == std::string::npos) return filled;
    filled += values.at(page.substr(open + 2, close - open - 2));
    at = close + 2;
  }
}

/// What the frames of a page are made from.
class StepMaker {
 public:
  static Result<StepMaker> Open(const RunChoice& choice, const RunReview& review,
                                const RunPageOptions& options) {
    StepMaker maker(review, options);
    auto reader = RunReader::Open(choice.run);
    if (!reader.ok()) return reader.error();
    maker.reader_ = std::move(reader).value();
    maker.renderer_ = std::make_unique<OcclusionRenderer>(*review.database);
    // Without it ReviewRun has said why.
    if (auto sequence = OpenSequenceOfRun(choice, review.header); sequence.ok())
      maker.sequence_ = *sequence;
    return maker;
  }

  const Sequence* sequence() const { return sequence_.get(); }
  cv::Size size() const { return size_; }
  std::int64_t first_stamp_ns() const { return first_stamp_ns_; }

  struct Step {
    nlohmann::json json;
    std::vector<std::uint8_t> jpeg;  ///< Empty without an image.
    std::set<int> labels;            ///< Of what it shows.
  };
  Result<Step> Make(int position) {
    auto report = reader_->ReadFrameBrief(position);
    if (!report.ok()) return report.error();
    if (!any_) first_stamp_ns_ = report->stamp_ns;
    any_ = true;
    Step step;
    std::vector<PlacedModel> placed;
    for (const ObjectReport& object : report->objects) {
      if (object.state == ObjectState::kRetired) continue;
      placed.push_back({object.id, object.label, object.world_from_object, object.scale});
      step.labels.insert(object.label.value);
      for (const PoseMode& mode : object.modes) step.labels.insert(mode.label.value);
    }
    const auto& sample = *review_.history.frames[static_cast<std::size_t>(position)];
    const double page_from_image =
        static_cast<double>(size_.width) / std::max(1, review_.header.camera.width);
    step.json = RunPageFrame(*report, sample, Outlines(report->world_from_cam, placed),
                             Outlines(report->world_from_cam, truth_), page_from_image);
    step.json["time"] =
        std::round(static_cast<double>(report->stamp_ns - first_stamp_ns_) * 1e-6) / 1000;
    step.jpeg = Jpeg(position, report->frame);
    return step;
  }

 private:
  StepMaker(const RunReview& review, const RunPageOptions& options)
      : review_(review), quality_(options.quality) {
    const PinholeCamera& camera = review.header.camera;
    size_.width = std::max(1, std::min(options.width, camera.width));
    size_.height = std::max(1, size_.width * camera.height / std::max(1, camera.width));
    for (std::size_t i = 0; i < review.view.truth.size(); ++i) {
      const SequenceView::Truth& truth = review.view.truth[i];
      if (const auto model = review.database->Find(truth.model))
        truth_.push_back({{static_cast<int>(i) + 1}, *model, truth.world_from_object, truth.scale});
    }
  }

  std::vector<OutlineView> Outlines(const std::optional<Eigen::Isometry3d>& world_from_cam,
                                    std::span<const PlacedModel> placed) {
    const PinholeCamera& camera = review_.header.camera;
    if (!world_from_cam || placed.empty() || camera.width == 0) return {};
    const RenderedMaps maps = renderer_->Render(camera, world_from_cam->inverse(), placed);
    return OutlinesOf(maps.id, {camera.width, camera.height});
  }

  std::vector<std::uint8_t> Jpeg(int position, int frame) {
    cv::Mat image;
    if (sequence_ != nullptr) {
      if (auto read = sequence_->ReadFrame(frame); read.ok()) image = read->image;
    } else if (auto thumbnail = reader_->ReadThumbnail(position); thumbnail.ok()) {
      image = *thumbnail;
    }
    std::vector<std::uint8_t> bytes;
    if (image.empty()) return bytes;
    if (image.cols > size_.width) cv::resize(image, image, size_, 0, 0, cv::INTER_AREA);
    cv::imencode(".jpg", image, bytes,
                 {cv::IMWRITE_JPEG_QUALITY, quality_, cv::IMWRITE_JPEG_OPTIMIZE, 1,
                  cv::IMWRITE_JPEG_PROGRESSIVE, 1});
    return bytes;
  }

  const RunReview& review_;
  int quality_;
  cv::Size size_;
  std::vector<PlacedModel> truth_;  ///< By its number in the view, from 1.
  std::unique_ptr<RunReader> reader_;
  std::unique_ptr<OcclusionRenderer> renderer_;
  std::shared_ptr<const Sequence> sequence_;  ///< Null: it is gone.
  std::int64_t first_stamp_ns_ = 0;
  bool any_ = false;
};

/// Coarse enough for a page. What cannot be decimated is clustered.
nlohmann::json ModelMesh(const TriangleMesh& mesh) {
  DecimationReport report;
  const auto coarse = DecimateMesh(mesh, kModelFaces, report);
  TriangleMesh small = coarse.ok() ? *coarse : mesh;
  if (small.vertices.size() > 65535) small = ClusterToAbout(small, kPageModelVertices);
  small.colors.clear();  // models have the colours of their objects
  return RunPageMesh(small);
}

nlohmann::json Models(const RunReview& review, const std::set<int>& labels) {
  nlohmann::json models = nlohmann::json::array();
  for (std::size_t i = 0; i < review.view.models.size(); ++i) {
    const ModelView& model = review.view.models[i];
    nlohmann::json json = {{"name", model.name},
                           {"symmetry", model.any_azimuth ? 0 : model.symmetry_order}};
    if (labels.contains(static_cast<int>(i)) && model.mesh != nullptr && !model.mesh->empty())
      json["mesh"] = ModelMesh(*model.mesh);
    models.push_back(std::move(json));
  }
  return models;
}

nlohmann::json Scan(const Sequence* sequence, const RunReview& review, const WorkContext& work) {
  if (sequence == nullptr || !sequence->scene_file()) return nullptr;
  const SequenceView view = MakeSequenceView(*sequence, *review.database, work);
  if (view.scan_coarse == nullptr || view.scan_coarse->empty()) return nullptr;
  TriangleMesh scan = ClusterToAbout(*view.scan_coarse, kPageScanVertices);
  // The review knows what corrected poses on the way.
  const Eigen::Isometry3f move(review.view.world_from_given * view.world_from_given.inverse());
  for (Eigen::Vector3f& vertex : scan.vertices) vertex = move * vertex;
  return RunPageMesh(scan);
}

/// Of the visual-inertial filter, where the run found its own poses.
nlohmann::json Points(const RunReview& review) {
  if (review.view.own_poses == nullptr) return nullptr;
  TriangleMesh all, some;
  for (const OwnPoseReport& frame : review.view.own_poses->frames)
    all.vertices.insert(all.vertices.end(), frame.points_in_world.begin(),
                        frame.points_in_world.end());
  if (all.empty()) return nullptr;
  const std::size_t stride = all.vertices.size() / kPagePoints + 1;
  for (std::size_t i = 0; i < all.vertices.size(); i += stride)
    some.vertices.push_back(all.vertices[i]);
  return RunPageMesh(some);
}

std::string Ordinal(int number) {
  return number == 2 ? "2nd" : number == 3 ? "3rd" : fmt::format("{}th", number);
}

std::string Summary(const RunReview& review, const std::optional<MapEvaluation>& evaluation,
                    int every) {
  int confirmed = 0;
  for (const ObjectReport& object : review.last->objects)
    confirmed += object.state == ObjectState::kConfirmed;
  std::string text =
      fmt::format("{}{} frames of {} \u00b7 {} confirmed {}",
                  every > 1 ? "every " + Ordinal(every) + " of " : "", review.history.frames.size(),
                  review.view.name, confirmed, confirmed == 1 ? "object" : "objects");
  if (!evaluation) return text;
  text += fmt::format(" \u00b7 matched {}, missed {}, spurious {}", evaluation->matched.size(),
                      evaluation->missed.size(), evaluation->spurious.size());
  if (const auto mean = evaluation->mean_all.translation_m)
    text += fmt::format(" \u00b7 off by {:.1f} cm", 100 * *mean);
  if (const auto mean = evaluation->mean_all.rotation_rad)
    text += fmt::format(" and {:.1f}\u00b0 on average", kDegPerRad * *mean);
  return text;
}

/// A source or the name of a file, without the folders of this machine.
template <typename Source>
std::string LastName(const InputChoice<Source>& choice) {
  return choice.file.empty() ? ToText(choice) : choice.file.filename().string();
}

nlohmann::json Facts(const RunReview& review) {
  const RunHeader& header = review.header;
  const RunRecipe& recipe = header.recipe;
  const auto folder = [](const std::filesystem::path& path) {
    return (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
  };
  const double seconds = review.timings.empty() ? 0 : review.timings.back().elapsed_s;
  nlohmann::json facts = nlohmann::json::array(
      {{"sequence", review.view.name},
       {"models", folder(recipe.models)},
       {"edges", LastName(recipe.edges.value_or(EdgeChoice()))},
       {"detector", LastName(recipe.detector.value_or(DetectorChoice()))},
       {"poses", LastName(recipe.poses)},
       {"seed", fmt::format("{}", recipe.seed)},
       {"pace", recipe.live_speed ? fmt::format("live, speed {:g}: frames that came while the "
                                                "mapper was busy were passed over",
                                                *recipe.live_speed)
                                  : "every frame"},
       {"frames", fmt::format("{}", review.history.frames.size())}});
  if (seconds > 0)
    facts.push_back({"time", fmt::format("{:.1f} s, {:.1f} frames/s", seconds,
                                         static_cast<double>(review.timings.size()) / seconds)});
  facts.push_back({"program", "Plumbline " + header.program_version});
  facts.push_back({"started", header.started});
  return facts;
}

std::string Notice(const StepMaker& maker, bool images) {
  if (maker.sequence() != nullptr)
    return images ? "" : "The sequence has no images that could be read: the page has none.";
  return images ? "The images were not there when this page was made; the small pictures that the "
                  "run file keeps stand in for them."
                : "The images were not there when this page was made: the page has none.";
}

Result<std::string> Script() {
  std::string script;
  for (const char* file : {"run.js", "linear.js", "image_view.js", "map_view.js", "timeline.js",
                           "lists.js", "page.js"}) {
    auto text = PageResource(file);
    if (!text.ok()) return text.error();
    script += *text;
  }
  return script;
}

}  // namespace

Result<RunPage> MakeRunPage(const RunChoice& choice, const RunReview& review,
                            const std::optional<MapEvaluation>& evaluation,
                            const RunPageOptions& options, const WorkContext& work) {
  auto maker = StepMaker::Open(choice, review, options);
  if (!maker.ok()) return maker.error();
  const int frames = static_cast<int>(review.history.frames.size());
  const int every = options.every.value_or((frames + kMostSteps - 1) / kMostSteps);
  RunPage page;
  nlohmann::json list = nlohmann::json::array();
  std::string images;
  std::set<int> labels;
  for (int position = 0; position < frames; position += every) {
    if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    work.report({"Making the page", position, frames});
    auto step = maker->Make(position);
    if (!step.ok()) return step.error();
    list.push_back(std::move(step->json));
    images += (page.steps++ == 0 ? "" : "\n") + Base64(step->jpeg);
    page.image_bytes += (step->jpeg.size() + 2) / 3 * 4;
    labels.merge(step->labels);
  }
  work.report({"Making the page", frames, frames});
  nlohmann::json truth = RunPageTruth(review);
  for (const nlohmann::json& instance : truth)
    if (instance["label"].is_number()) labels.insert(instance["label"].get<int>());

  const PinholeCamera& camera = review.header.camera;
  const Eigen::Vector3d& up = review.view.up_in_world;
  nlohmann::json data = {
      {"name", choice.run.filename().string()},
      {"summary", Summary(review, evaluation, every)},
      {"notice", Notice(*maker, page.image_bytes > 0)},
      {"camera", IntrinsicsToJson(camera)},
      {"page", {{"width", maker->size().width}, {"height", maker->size().height}}},
      {"up", {up.x(), up.y(), up.z()}},
      {"floor", review.view.floor_height_m ? nlohmann::json(*review.view.floor_height_m) : nullptr},
      {"models", Models(review, labels)},
      {"objects", RunPageObjects(review)},
      {"truth", std::move(truth)},
      {"events", RunPageEvents(review)},
      {"fields", RunPageFields()},
      {"frames", std::move(list)},
      {"scan", Scan(maker->sequence(), review, work)},
      {"points", Points(review)},
      {"facts", Facts(review)},
      {"options", OptionsToJson(review.header.recipe.options).dump(1)}};
  if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};

  auto script = Script();
  if (!script.ok()) return script.error();
  const auto html = PageResource("page.html"), style = PageResource("page.css");
  if (!html.ok()) return html.error();
  if (!style.ok()) return style.error();
  const std::string text = InScript(data);
  page.html = Filled(*html, {{"title", Escaped(choice.run.filename().string())},
                             {"nonce", HashHex(text + images)},
                             {"style", *style},
                             {"script", *script},
                             {"data", text},
                             {"images", images}});
  return page;
}

}  // namespace plumbline
