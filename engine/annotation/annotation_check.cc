// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "engine/annotation/crop_cut.h"
#include "engine/annotation/scaled_models.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/gravity.h"
#include "engine/registration/model_surface.h"

namespace plumbline {
namespace {

std::string Sentence(const char* format, const std::string& a, double amount,
                     const std::string& b = "") {
  char text[256];
  std::snprintf(text, sizeof(text), format, a.c_str(), amount, b.c_str());
  return text;
}

class Checker {
 public:
  Checker(const AnnotationDocument& document, const ExchangeInputs& inputs,
          const AnnotationCheckOptions& options)
      : document_(document),
        inputs_(inputs),
        options_(options),
        scaled_(WithScaledModels(document, inputs.models).models) {}

  std::vector<AnnotationFinding> Run() {
    for (const AnnotatedInstance& instance : document_.instances) CheckAlone(instance);
    for (std::size_t i = 0; i < document_.instances.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        CheckPair(document_.instances[k], document_.instances[i]);
      }
    }
    for (const Crop& crop : document_.crops) CheckCropAlone(crop);
    CheckFrames();
    return std::move(findings_);
  }

 private:
  const CadModel* ModelOf(const AnnotatedInstance& instance) const {
    const bool scaled = scaled_ != nullptr && instance.scale != 1;
    const ModelDatabase* models = scaled ? scaled_.get() : inputs_.models;
    if (models == nullptr) return nullptr;
    const auto id =
        models->Find(scaled ? ScaledModelName(instance.model, instance.scale) : instance.model);
    return id ? &models->model(*id) : nullptr;
  }

  /// Null for a mesh that has no surface.
  const ModelSurface* SurfaceOf(const CadModel& model) {
    auto [place, is_new] = surfaces_.try_emplace(model.id.value);
    if (is_new) {
      if (auto surface = ModelSurface::Prepare(model.mesh)) place->second = std::move(*surface);
    }
    return place->second.get();
  }

  void CheckAlone(const AnnotatedInstance& instance) {
    const UprightFrame upright(document_.gravity_in_scan);
    const double tilt_deg = kDegPerRad * upright.Tilt(instance.scan_from_object.linear());
    if (tilt_deg > options_.tilt_deg && !instance.may_tilt) {
      findings_.push_back({"tilted",
                           {instance.id},
                           tilt_deg,
                           "deg",
                           Sentence("%s is tilted by %.2f degrees", instance.id, tilt_deg)});
    }
    if (!inputs_.models) return;
    const CadModel* model = ModelOf(instance);
    if (!model) {
      findings_.push_back(
          {"unknown_model",
           {instance.id},
           0,
           "",
           "the model '" + instance.model + "' of " + instance.id + " is not in the database"});
      return;
    }
    if (!document_.floor_in_scan || model->support != Support::kFloor) return;
    const Eigen::Vector4d& floor = *document_.floor_in_scan;
    double lowest_m = 1e30;
    for (const Eigen::Vector3f& vertex : model->mesh.vertices) {
      const Eigen::Vector3d point = instance.scan_from_object * vertex.cast<double>();
      lowest_m = std::min(lowest_m, floor.head<3>().dot(point) + floor[3]);
    }
    if (lowest_m > options_.floor_gap_m) {
      findings_.push_back({"floating",
                           {instance.id},
                           lowest_m,
                           "m",
                           Sentence("%s floats %.3f m above the floor", instance.id, lowest_m)});
    } else if (lowest_m < -options_.floor_gap_m) {
      findings_.push_back({"sunk",
                           {instance.id},
                           -lowest_m,
                           "m",
                           Sentence("%s is sunk %.3f m into the floor", instance.id, -lowest_m)});
    }
  }

  void CheckPair(const AnnotatedInstance& a, const AnnotatedInstance& b) {
    const CadModel* model_a = ModelOf(a);
    const CadModel* model_b = ModelOf(b);
    const auto center = [](const AnnotatedInstance& instance, const CadModel* model) {
      return Eigen::Vector3d(instance.scan_from_object *
                             (model ? model->center() : Eigen::Vector3d(0, 0, 0)));
    };
    const double apart_m = (center(a, model_a) - center(b, model_b)).norm();
    if (a.model == b.model && apart_m < options_.duplicate_m) {
      findings_.push_back(
          {"duplicate",
           {a.id, b.id},
           apart_m,
           "m",
           Sentence("%s is %.3f m from %s and of the same model", a.id, apart_m, b.id)});
      return;
    }
    if (a.category == b.category && IsDraft(a) != IsDraft(b) && apart_m < options_.draft_m) {
      const AnnotatedInstance &draft = IsDraft(a) ? a : b, &placed = IsDraft(a) ? b : a;
      findings_.push_back({"draft_on_object",
                           {draft.id, placed.id},
                           apart_m,
                           "m",
                           Sentence("the draft %s stands %.3f m from %s, which is placed already",
                                    draft.id, apart_m, placed.id)});
      return;
    }
    if (!model_a || !model_b ||
        apart_m > 0.5 * (model_a->bounds.diagonal().norm() + model_b->bounds.diagonal().norm())) {
      return;
    }
    const double depth_m =
        std::max(Depth(a, *model_a, b, *model_b), Depth(b, *model_b, a, *model_a));
    if (depth_m > options_.overlap_m) {
      findings_.push_back({"interpenetrating",
                           {a.id, b.id},
                           depth_m,
                           "m",
                           Sentence("%s reaches %.3f m into %s", a.id, depth_m, b.id)});
    }
  }

  /// How far the surface of `inner` reaches into the material of `outer`: into what no ray leaves.
  double Depth(const AnnotatedInstance& inner, const CadModel& inner_model,
               const AnnotatedInstance& outer, const CadModel& outer_model) {
    const ModelSurface* moving = SurfaceOf(inner_model);
    const ModelSurface* standing = SurfaceOf(outer_model);
    if (!moving || !standing) return 0;
    const Eigen::Isometry3d outer_from_inner =
        outer.scan_from_object.inverse() * inner.scan_from_object;
    double depth_m = 0;
    for (std::size_t i = 0; i < moving->samples().points.size(); i += 4) {
      const Eigen::Vector3d point = outer_from_inner * moving->samples().points[i].cast<double>();
      if (!standing->bounds().contains(point)) continue;
      bool inside = true;
      for (int corner = 0; corner < 14 && inside; ++corner) {
        const Eigen::Vector3d direction =
            corner < 8
                ? Eigen::Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)
                : (corner & 1 ? 1.0 : -1.0) * Eigen::Vector3d::Unit((corner - 8) / 2);
        inside =
            standing->triangles().Blocked(point, direction + Eigen::Vector3d(0.01, 0.02, 0.03));
      }
      if (inside) depth_m = std::max(depth_m, standing->triangles().Find(point).distance_m);
    }
    return depth_m;
  }

  void CheckCropAlone(const Crop& crop) {
    if (inputs_.models && crop.into == Crop::Into::kModel && !inputs_.models->Find(crop.id)) {
      findings_.push_back({"unmade_crop",
                           {crop.id},
                           0,
                           "",
                           "the model '" + crop.id + "' that was cut out is not in the database"});
    }
    if (!inputs_.scan) return;
    if (const auto cut = CutOut(*inputs_.scan, crop); !cut) {
      findings_.push_back({"empty_crop", {crop.id}, 0, "", cut.error().message});
    }
  }

  void CheckFrames() {
    if (!inputs_.sequence) return;
    const int count = inputs_.sequence->num_frames();
    int without = 0;
    for (int i = 0; i < count; ++i) without += !inputs_.sequence->world_from_cam(i).has_value();
    if (without > 0) {
      findings_.push_back({"missing_frames",
                           {},
                           static_cast<double>(without),
                           "frames",
                           std::to_string(without) + " of " + std::to_string(count) +
                               " frames of the sequence have no camera pose"});
    }
    for (const std::string& warning : inputs_.sequence->warnings()) {
      findings_.push_back({"missing_frames", {}, 0, "", warning});
    }
  }

  const AnnotationDocument& document_;
  const ExchangeInputs& inputs_;
  const AnnotationCheckOptions& options_;
  std::shared_ptr<const ModelDatabase> scaled_;  ///< With models of scaled instances; may be null.
  std::map<int, std::shared_ptr<const ModelSurface>> surfaces_;
  std::vector<AnnotationFinding> findings_;
};

}  // namespace

std::optional<AcceptedFinding> AcceptanceOf(const AnnotationFinding& finding,
                                            const AnnotationDocument& document) {
  AcceptedFinding accepted{finding.kind, {}, finding.amount, finding.unit, "", ""};
  for (const std::string& id : finding.instances) {
    const AnnotatedInstance* instance = document.Find(id);
    if (instance == nullptr) return std::nullopt;
    accepted.objects.push_back({id, instance->model, instance->scale, instance->scan_from_object});
  }
  if (accepted.objects.empty()) return std::nullopt;
  return accepted;
}

const AcceptedFinding* FindAcceptance(const AnnotationFinding& finding,
                                      const AnnotationDocument& document,
                                      const AcceptanceLimits& limits) {
  const double growth = finding.unit == "m"     ? limits.growth_m
                        : finding.unit == "deg" ? limits.growth_deg
                                                : std::numeric_limits<double>::infinity();
  const auto is_as_it_was = [&](const AcceptedFinding::Object& object) {
    const AnnotatedInstance* now = document.Find(object.id);
    if (now == nullptr || now->model != object.model || now->scale != object.scale) return false;
    const Eigen::Isometry3d change = object.scan_from_object.inverse() * now->scan_from_object;
    return change.translation().norm() <= limits.shift_m &&
           kDegPerRad * Eigen::AngleAxisd(change.linear()).angle() <= limits.turn_deg;
  };
  for (const AcceptedFinding& accepted : document.accepted) {
    if (!accepted.IsAbout(finding.kind, finding.instances)) continue;
    const bool holds = finding.amount <= accepted.amount + growth &&
                       std::all_of(accepted.objects.begin(), accepted.objects.end(), is_as_it_was);
    return holds ? &accepted : nullptr;
  }
  return nullptr;
}

bool IsDraft(const AnnotatedInstance& instance) {
  return !instance.fine && instance.note.starts_with(kDraftNote);
}

std::optional<AnnotationFinding> CheckAgreement(const std::string& instance, double agreement,
                                                std::size_t images,
                                                const AnnotationCheckOptions& options) {
  if (agreement >= options.agreement) return std::nullopt;
  char text[256];
  std::snprintf(text, sizeof(text), "%.0f %% of the outline of %s lies on edges, in %zu images",
                100 * agreement, instance.c_str(), images);
  return AnnotationFinding{"low_agreement", {instance}, agreement, "", text};
}

std::vector<AnnotationFinding> CheckAnnotations(const AnnotationDocument& document,
                                                const ExchangeInputs& inputs,
                                                const AnnotationCheckOptions& options) {
  return Checker(document, inputs, options).Run();
}

}  // namespace plumbline
