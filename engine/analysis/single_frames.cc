// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/single_frames.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/analysis/true_instances.h"
#include "engine/base/check.h"
#include "engine/evaluation/model_point_errors.h"
#include "engine/evaluation/truth_pairing.h"
#include "engine/geometry/diameter.h"
#include "engine/mapping/map_report.h"
#include "engine/render/renderer.h"

namespace plumbline {
namespace {

constexpr double kBopWidth_px = 640;  ///< MSPD is given as if images were so wide.
constexpr float kMillimetre_m = 1e-3f;

/// The image with as much room again on every side: BOP counts what lies outside, too.
PinholeCamera WithRoom(PinholeCamera camera) {
  camera.cx += camera.width;
  camera.cy += camera.height;
  camera.width *= 3;
  camera.height *= 3;
  return camera;
}

/// What is needed of a model, worked out once.
struct TargetModel {
  int mesh = -1;
  ModelPoints points;
  std::vector<Eigen::Isometry3d> turns;
  double diameter_m = 0;
};

class FrameJudge {
 public:
  static Result<std::unique_ptr<FrameJudge>> Create(const RunReview& review,
                                                    const Sequence& sequence,
                                                    const TriangleMesh* scan,
                                                    const SingleFrameOptions& options) {
    std::unique_ptr<FrameJudge> judge(new FrameJudge(review, sequence, options));
    Result<std::unique_ptr<RenderContext>> context = RenderContext::CreateHeadless();
    if (!context) return context.error();
    judge->context_ = std::move(*context);
    Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(*judge->context_);
    if (!renderer) return renderer.error();
    judge->renderer_ = std::move(*renderer);
    for (const CadModel& model : review.database->models()) {
      judge->models_.push_back({judge->renderer_->AddMesh(model.mesh), PointsOf(model.mesh),
                                SymmetricTurns(model.symmetry), Diameter(model.mesh)});
    }
    if (scan != nullptr) judge->scan_mesh_ = judge->renderer_->AddMesh(*scan);
    return judge;
  }

  Status Judge(const FrameReport& report) {
    const Eigen::Isometry3d cam_from_world = report.world_from_cam->inverse();
    const Result<cv::Mat> scene = SceneOf(report.frame, cam_from_world);
    if (!scene) return scene.error();
    const std::vector<std::optional<int>> pairs = TruthsOfObjects(report, review_.view);
    ++result_.frames;
    for (std::size_t j = 0; j < review_.view.truth.size(); ++j) {
      const ObjectReport* estimate = nullptr;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (pairs[i] == static_cast<int>(j) && Holds(report.objects[i], review_.view.truth[j]))
          estimate = &report.objects[i];
      }
      JudgeTarget(review_.view.truth[j], estimate, cam_from_world, *scene);
    }
    return {};
  }

  SingleFrames Take() {
    std::vector<BopErrors> all;
    int targets = 0;
    for (const auto& [id, of] : targets_) {
      result_.by_truth[id] = BopRecallOf(of.errors, of.count);
      all.insert(all.end(), of.errors.begin(), of.errors.end());
      targets += of.count;
    }
    result_.all = BopRecallOf(all, targets);
    return std::move(result_);
  }

 private:
  struct Targets {
    int count = 0;
    std::vector<BopErrors> errors;
  };

  FrameJudge(const RunReview& review, const Sequence& sequence, const SingleFrameOptions& options)
      : review_(review), sequence_(sequence), options_(options), camera_(sequence.camera()) {}

  std::optional<ModelId> ModelOf(const SequenceView::Truth& truth) const {
    return review_.database->Find(truth.model);
  }

  /// Whether the object counts as the instance: confirmed, near it, and of its model.
  bool Holds(const ObjectReport& object, const SequenceView::Truth& truth) const {
    const Eigen::Vector3d offset =
        object.world_from_object.translation() - truth.world_from_object.translation();
    return object.state == ObjectState::kConfirmed && offset.norm() <= kPairReach_m &&
           ModelOf(truth) == object.label;
  }

  cv::Mat Draw(const PinholeCamera& camera, std::span<const RenderInstance> instances) {
    return RayLengths(renderer_->Render(camera, instances, {}).depth, camera);
  }

  /// What hides things in the image: as ray lengths, 0 where nothing is known.
  Result<cv::Mat> SceneOf(int frame, const Eigen::Isometry3d& cam_from_world) {
    const Result<std::optional<cv::Mat>> measured = sequence_.ReadDepth(frame);
    if (!measured) return measured.error();
    if (*measured && (*measured)->cols == camera_.width && (*measured)->rows == camera_.height) {
      ++result_.measured;
      cv::Mat depth;
      (*measured)->convertTo(depth, CV_32F, kMillimetre_m);
      return RayLengths(depth, camera_);
    }
    if (scan_mesh_ >= 0) {
      ++result_.scan;
      const RenderInstance scan{scan_mesh_, cam_from_world * review_.view.world_from_given, 1, 1};
      return Draw(camera_, std::span(&scan, 1));
    }
    ++result_.models;
    std::vector<RenderInstance> truths;
    for (const SequenceView::Truth& truth : review_.view.truth) {
      const std::optional<ModelId> model = ModelOf(truth);
      if (model)
        truths.push_back(InstanceOf(*model, cam_from_world * truth.world_from_object, truth.scale));
    }
    return Draw(camera_, truths);
  }

  RenderInstance InstanceOf(ModelId model, const Eigen::Isometry3d& cam_from_object,
                            double scale) const {
    return {models_[static_cast<std::size_t>(model.value)].mesh, cam_from_object, 1, scale};
  }

  void JudgeTarget(const SequenceView::Truth& truth, const ObjectReport* estimate,
                   const Eigen::Isometry3d& cam_from_world, const cv::Mat& scene) {
    const std::optional<ModelId> id = ModelOf(truth);
    if (!id) return;
    const TargetModel& model = models_[static_cast<std::size_t>(id->value)];
    const Eigen::Isometry3d cam_from_truth = cam_from_world * truth.world_from_object;
    const RenderInstance drawn = InstanceOf(*id, cam_from_truth, truth.scale);
    const PinholeCamera wide = WithRoom(camera_);
    const cv::Mat everywhere = Draw(wide, std::span(&drawn, 1));
    VsdImages images;
    images.scene = scene;
    images.truth =
        everywhere(cv::Rect(camera_.width, camera_.height, camera_.width, camera_.height));
    const int whole_px = cv::countNonZero(everywhere);
    if (whole_px == 0 ||
        VisiblePixels(images.truth, scene) < std::max(1.0, options_.least_visible * whole_px))
      return;
    Targets& targets = targets_[truth.id];
    ++targets.count;
    if (estimate == nullptr) return;
    const Eigen::Isometry3d cam_from_estimate = cam_from_world * estimate->world_from_object;
    const RenderInstance estimated = InstanceOf(*id, cam_from_estimate, estimate->scale);
    images.estimate = Draw(camera_, std::span(&estimated, 1));
    const Eigen::Affine3d e = cam_from_estimate * Eigen::Scaling(estimate->scale);
    const Eigen::Affine3d t = cam_from_truth * Eigen::Scaling(truth.scale);
    const double diameter_m = truth.scale * model.diameter_m;
    targets.errors.push_back(
        {VsdErrors(images, diameter_m, kBopShares),
         MssdError(e, t, model.points, model.turns) / diameter_m,
         MspdError(e, t, camera_, model.points, model.turns) * kBopWidth_px / camera_.width});
  }

  const RunReview& review_;
  const Sequence& sequence_;
  const SingleFrameOptions options_;
  const PinholeCamera camera_;
  std::unique_ptr<RenderContext> context_;
  std::unique_ptr<Renderer> renderer_;
  std::vector<TargetModel> models_;
  int scan_mesh_ = -1;
  SingleFrames result_;
  std::map<std::string, Targets> targets_;
};

/// Positions in the run, one from each of `count` equal parts: the first with measured depth, else
/// the first.
std::vector<int> ChooseFrames(const RunHistory& history, const Sequence& sequence, int count) {
  std::vector<int> used, chosen;
  for (std::size_t i = 0; i < history.frames.size(); ++i) {
    if (history.frames[i] != nullptr && !history.frames[i]->skipped)
      used.push_back(static_cast<int>(i));
  }
  const std::size_t parts = std::min(used.size(), static_cast<std::size_t>(count));
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t begin = part * used.size() / parts, end = (part + 1) * used.size() / parts;
    std::size_t best = begin;
    for (std::size_t i = begin; i < end && sequence.has_depth(); ++i) {
      const int frame = history.frames[static_cast<std::size_t>(used[i])]->frame;
      const auto depth = sequence.ReadDepth(frame);
      if (!depth.ok() || !*depth) continue;
      best = i;
      break;
    }
    chosen.push_back(used[best]);
  }
  return chosen;
}

nlohmann::json RecallToJson(const BopRecall& recall) {
  return {{"targets", recall.targets}, {"estimated", recall.estimated}, {"ar_vsd", recall.vsd},
          {"ar_mssd", recall.mssd},    {"ar_mspd", recall.mspd},        {"ar", recall.average()}};
}

}  // namespace

Result<SingleFrames> MeasureSingleFrames(const RunReview& review, RunReader& reader,
                                         const Sequence& sequence, const TriangleMesh* scan,
                                         const SingleFrameOptions& options,
                                         const WorkContext& work) {
  PLB_CHECK(options.frames >= 1) << options.frames;
  auto judge = FrameJudge::Create(review, sequence, scan, options);
  if (!judge) return judge.error();
  const std::vector<int> positions = ChooseFrames(review.history, sequence, options.frames);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    work.report({"Judging single frames", static_cast<int>(i), static_cast<int>(positions.size())});
    const Result<FrameReport> report = reader.ReadFrameBrief(positions[i]);
    if (!report) return report.error();
    if (!report->world_from_cam) continue;
    if (const Status judged = (*judge)->Judge(*report); !judged.ok()) return judged.error();
  }
  return (*judge)->Take();
}

nlohmann::json SingleFramesToJson(const SingleFrames& frames) {
  nlohmann::json json = RecallToJson(frames.all);
  json["frames"] = frames.frames;
  json["hidden_by"] = {
      {"measured_depth", frames.measured}, {"scan", frames.scan}, {"models", frames.models}};
  json["by_instance"] = nlohmann::json::object();
  for (const auto& [id, recall] : frames.by_truth) json["by_instance"][id] = RecallToJson(recall);
  return json;
}

}  // namespace plumbline
