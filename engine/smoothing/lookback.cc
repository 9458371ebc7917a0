// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/lookback.h"

#include <algorithm>
#include <cmath>

#include "engine/mapping/association.h"
#include "engine/mapping/birth.h"
#include "engine/mapping/existence.h"
#include "engine/smoothing/object_views.h"

namespace plumbline {
namespace {

constexpr double kUsualSurplus = 0.25;  ///< Of right objects, where the constants were fitted.
constexpr double kMarginalSharpness = 5;
constexpr std::size_t kParticleStep = 4;
constexpr float kSameViewIou = 0.5f;

/// A look at one object.
struct Seen {
  std::size_t look = 0;
  Sighting sighting;
  double surplus = 0;
};

class Observer {
 public:
  Observer(const MapperSetup& setup, OcclusionRenderer& renderer,
           std::span<const MapObject> objects)
      : setup_(setup),
        map_(MapFrameOf(setup)),
        renderer_(renderer),
        objects_(objects.begin(), objects.end()),
        seen_(objects.size()) {
    presences_.resize(objects.size());
    for (Presence& presence : presences_) presence.same_view.assign(objects.size(), 0);
  }

  void See(std::size_t look, const Look& at, const MapperInput& input) {
    const Eigen::Isometry3d cam_from_world = at.at.world_from_cam.inverse();
    const OcclusionMaps solid =
        renderer_.RenderOccluders(setup_.camera, cam_from_world, MeanStates(objects_, true));
    const RenderedMaps all =
        renderer_.Render(setup_.camera, cam_from_world, MeanStates(objects_, false));
    const std::span<const Detection> boxes =
        input.detections ? input.detections->proposals() : std::span<const Detection>{};
    const std::vector<std::optional<std::size_t>> matched = MatchProposals(boxes, objects_, all);
    std::vector<std::size_t> shown;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const ScoringView view =
          ViewOf(setup_, at.at.world_from_cam, solid, objects_[i].id, *input.table);
      const Detection* box = matched[i] ? &boxes[*matched[i]] : nullptr;
      if (SeeObject(i, look, at, view, input, box)) shown.push_back(i);
    }
    for (const std::size_t i : shown) {
      for (const std::size_t j : shown) {
        if (i != j && Iou(objects_[i].visible_box, objects_[j].visible_box) > kSameViewIou)
          ++presences_[i].same_view[j];
      }
    }
  }

  std::vector<Presence> Weigh(std::span<const Look> looks) {
    const double level = Level();
    const MapperOptions& options = setup_.options;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      Existence existence;
      std::size_t last = 0;
      for (Seen& seen : seen_[i]) {
        seen.sighting.edge_surplus = static_cast<float>(seen.surplus * kUsualSurplus / level);
        double dt_s = 0;  // since it was last in view
        for (std::size_t k = last + 1; k <= seen.look; ++k) dt_s += looks[k].dt_s;
        last = seen.look;
        // Only what has been seen to be there can be said to be hidden.
        if (objects_[i].state == ObjectState::kConfirmed) {
          existence.Update(seen.sighting, dt_s, options);
        } else {
          existence.UpdateInView(seen.sighting, options);
        }
        if (seen.sighting.edge_surplus > options.expected_edge &&
            seen.sighting.visible_fraction >= options.confirm_shown) {
          presences_[i].shown += seen.sighting.novelty;
        }
      }
      presences_[i].log_odds = existence.log_odds;
    }
    return std::move(presences_);
  }

 private:
  bool SeeObject(std::size_t i, std::size_t look, const Look& at, const ScoringView& view,
                 const MapperInput& input, const Detection* box) {
    MapObject& object = objects_[i];
    const PoseHypothesis mean = ToHypothesis(object.mean(), map_);
    const Likelihood likelihood =
        Evaluate(*setup_.scorer, view, map_, nullptr, {&mean, 1}, std::nullopt, setup_.options)
            .front();
    const double depth = (view.cam_from_world * mean.center_in_world).z();
    if (depth <= 0 || likelihood.visible_fraction < setup_.options.min_visible) return false;
    object.visible_box = likelihood.visible_box;
    HypothesisScore score;
    setup_.scorer->Score(view, map_.upright, {&mean, 1}, {&score, 1});
    const double focal = kFocalOfLengths_px / setup_.camera.fx;
    Seen seen;
    seen.look = look;
    seen.sighting.novelty = at.novelty;
    seen.sighting.visible_px = likelihood.visible_box.area() * focal * focal;
    seen.sighting.visible_fraction = likelihood.visible_fraction;
    seen.sighting.edge_fraction = likelihood.visible_fraction;
    seen.sighting.telling = Telling(score, depth, setup_.options);
    seen.sighting.inside_fraction = InsideFraction(setup_.database->model(mean.label), mean, map_,
                                                   setup_.camera, view.cam_from_world);
    if (box != nullptr) {
      seen.sighting.box_score = box->score;
      seen.sighting.box_iou = Iou(box->box, likelihood.visible_box);
    }
    seen.surplus = EdgeSurplus(*setup_.scorer, view, map_, mean) + Undecided(object, view, mean);
    seen_[i].push_back(seen);
    if (likelihood.visible_fraction >= kLeastSight) presences_[i].frames.push_back(input.frame);
    return true;
  }

  /// What the particles expect of the image beyond what the mean does, which may be between modes.
  double Undecided(const MapObject& object, const ScoringView& view,
                   const PoseHypothesis& mean) const {
    std::vector<PoseHypothesis> hypotheses = {mean};
    for (std::size_t k = 0; k < object.particles.size(); k += kParticleStep)
      hypotheses.push_back(ToHypothesis(object.particles[k], object.world_from_reference_cam));
    const std::vector<Likelihood> likelihoods =
        Evaluate(*setup_.scorer, view, map_, nullptr, hypotheses, std::nullopt, setup_.options);
    double expected = 0;
    for (std::size_t k = 1; k < likelihoods.size(); ++k)
      expected += std::exp(kMarginalSharpness * likelihoods[k].phi_edge) /
                  static_cast<double>(likelihoods.size() - 1);
    return std::max(0.0, std::log(expected) / kMarginalSharpness - likelihoods[0].phi_edge);
  }

  /// Strong edges give more to everything, right or wrong: what settled objects get is the measure.
  double Level() const {
    double sum = 0, weight = 0;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (objects_[i].state != ObjectState::kConfirmed) continue;
      for (const Seen& seen : seen_[i]) {
        if (seen.sighting.visible_fraction < setup_.options.confirm_shown) continue;
        sum += seen.sighting.novelty * seen.surplus;
        weight += seen.sighting.novelty;
      }
    }
    return weight > 0 ? std::max(kUsualSurplus, sum / weight) : kUsualSurplus;
  }

  const MapperSetup& setup_;
  MapFrame map_;
  OcclusionRenderer& renderer_;
  std::vector<MapObject> objects_;  ///< Their boxes are those of the look.
  std::vector<std::vector<Seen>> seen_;
  std::vector<Presence> presences_;
};

}  // namespace

Result<std::vector<Presence>> LookBack(const MapperSetup& setup, OcclusionRenderer& renderer,
                                       std::span<const Look> looks,
                                       std::span<const MapObject> objects, const LoadFrame& load,
                                       const WorkContext& work) {
  Observer observer(setup, renderer, objects);
  for (std::size_t k = 0; k < looks.size(); ++k) {
    if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "smoothing was cancelled"};
    const Result<MapperInput> input = load(looks[k].at.frame);
    if (input.ok()) observer.See(k, looks[k], *input);
    work.report({"looking back", static_cast<int>(k + 1), static_cast<int>(looks.size())});
  }
  return observer.Weigh(looks);
}

}  // namespace plumbline
