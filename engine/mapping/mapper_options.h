// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "engine/base/options.h"
#include "engine/mapping/paper_options.h"

namespace plumbline {

enum class ScoredBox { kWhole, kBest };
enum class JumpScope { kCategory, kAll };
enum class SpawnPrior { kPaper, kInformed };
enum class ResampleRule { kEveryFrame, kEffectiveSize };

template <>
struct EnumNames<ScoredBox> {
  static constexpr std::string_view names[] = {"whole", "best"};
};
template <>
struct EnumNames<JumpScope> {
  static constexpr std::string_view names[] = {"category", "all"};
};
template <>
struct EnumNames<SpawnPrior> {
  static constexpr std::string_view names[] = {"paper", "informed"};
};
template <>
struct EnumNames<ResampleRule> {
  static constexpr std::string_view names[] = {"every_frame", "effective_size"};
};

struct MapperOptions;
template <>
struct FormerNames<MapperOptions> {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 4> names = {
      {{"infant_particles", "tentative_particles"},
       {"birth_particles", "spawn_particles"},
       {"min_birth_score", "min_spawn_score"},
       {"max_births_per_frame", "max_spawns_per_frame"}}};
};

/// Everything that can be chosen about the semantic filter. docs/algorithms/semantic_filter.md
/// explains each.
struct MapperOptions {
  FilterKind filter = FilterKind::kPosterior;

  // Particles
  int particles = 500;
  int spawn_particles = 4000;
  int tentative_particles = 600;
  ResampleRule resample = ResampleRule::kEffectiveSize;
  double resample_below = 0.5;

  // Likelihood of a view: alpha * Phi_cnn + beta * Phi_edge
  double alpha = 2.5;
  double beta = 10.0;
  double view_correlation = 0.02;
  double tentative_sharpness = 1;
  double landmark_drift_m = 0.02;
  double telling_contour_px = 150;
  double outline_std_px = 0.65;
  double outline_side_std_px = 1;
  double shape_temperature = 8;
  double crop_sharpness = 0;
  bool inner_lines = true;
  ScoredBox scored_box = ScoredBox::kBest;
  double search_radius_px = 7;
  double search_sigma_px = 2.5;
  double far_search_sigma_px = 1.5;
  double far_m = 2.5;
  double edge_power = 1;
  double occlusion_margin_m = 0.05;
  double least_contrast = 0.15;
  double min_visible = 0.05;

  // Dynamics
  double bearing_noise = 0.004;
  double log_depth_noise = 0.008;
  double azimuth_noise_deg = 1.5;
  double jump_rate = 0.05;
  JumpScope jump_scope = JumpScope::kCategory;
  bool floor_prior = true;
  double floor_std_m = 0.015;
  double contact_std_m = 0.005;
  double scale_std = 0.02;
  double seen_from_behind = 1e-12;

  // Birth
  SpawnPrior prior = SpawnPrior::kInformed;
  double min_spawn_score = 0.35;
  double nominal_depth_m = 2.0;
  double nominal_depth_std = 0.35;
  double bearing_std_boxes = 0.1;
  double explained_overlap = 0.5;
  int max_tentative = 12;
  int max_spawns_per_frame = 2;

  // Memory of views
  int key_frames = 40;
  double key_frame_distance_m = 0.2;
  double key_frame_angle_deg = 12;
  int views_per_object = 8;
  double tentative_search_s = 0.2;
  double confirmed_search_s = 1;

  // Life
  double correlation_s = 3;
  double correlation_m = 0.1;
  double correlation_deg = 5;
  double expected_edge = 0.16;
  double telling_box = 0.35;
  double most_edge_surplus = 0.4;
  double evidence_per_edge = 5.0;
  double detection_rate = 0.4;
  double detectable_px = 2500;
  double false_box_quality = 0.15;
  double most_box_evidence = 1.5;
  double hidden_rate = 0.02;
  double hidden_s = 30;
  double tentative_odds = -0.87;
  double passing_share = 0.41;
  double remembered_share = 0.26;
  double shown_odds = 0.9;
  double box_share = 1.8;
  double confirm_evidence = 0.8;
  double dismiss_evidence = -2.0;
  double retire_evidence = 0.0;
  double confirm_position_std_m = 0.10;
  double confirm_mode_weight = 0.95;
  double confirm_held_weight = 0.85;
  double confirm_shown = 0.25;
  double confirm_age_s = 0.5;
  double tentative_limit_s = 6.0;

  // Outdoors (docs/algorithms/outdoors.md)
  double room_thing_m = 3.0;
  double moving_share = 0.3;
  double moving_speed_m_s = 8;
  double confirm_standing = 0.9;
  double left_behind_m = 20;
  double large_alpha = 10;
  double feigned_speed_m_s = 1.5;

  PaperOptions paper;  ///< Of filter = paper.
};

template <typename Visitor>
void VisitFields(MapperOptions& o, Visitor&& visit) {
  visit(o.filter, {"filter", "", "posterior, or paper: as the authors of the paper had it"});
  visit(o.particles, {"particles", "", "hypotheses of an object once it has settled", 50, 20000});
  visit(o.spawn_particles,
        {"spawn_particles", "", "hypotheses tried when an object is spawned", 100, 100000});
  visit(o.tentative_particles,
        {"tentative_particles", "", "hypotheses of an object until it is confirmed", 50, 20000});
  visit(o.resample,
        {"resample", "", "every_frame as in the paper, or when the effective sample size is low"});
  visit(o.resample_below,
        {"resample_below", "", "effective sample size, as a share of the particles, that resamples",
         0, 1});
  visit(o.alpha, {"alpha", "", "weight of the detector term, per independent view", 0, 1000});
  visit(o.beta, {"beta", "", "weight of the edge term, per independent view", 0, 1000});
  visit(o.landmark_drift_m,
        {"landmark_drift_m", "m",
         "a settled object that poses have drifted from by so much (standard deviation) is located "
         "again by the newest views alone, and poses are corrected by it; 0: never",
         0, 100});
  visit(o.view_correlation,
        {"view_correlation", "",
         "correlation of the errors of any two views: what never averages out", 0, 1});
  visit(o.tentative_sharpness,
        {"tentative_sharpness", "",
         "how much sharper than stated the views of a tentative object are taken, at most, where "
         "those of settled objects are sharper",
         1, 16});
  visit(o.telling_contour_px,
        {"telling_contour_px", "px",
         "visible contour from which a view counts fully, at a focal length of 500", 1, 100000});
  visit(o.outline_std_px,
        {"outline_std_px", "px",
         "how far outside or inside of an outline its edges lie all around, in all views alike "
         "(standard deviation, at a focal length of 500)",
         0, 20});
  visit(o.outline_side_std_px,
        {"outline_side_std_px", "px",
         "the same of the sides of an outline that face right, down, left and up, each its own", 0,
         20});
  visit(o.shape_temperature,
        {"shape_temperature", "",
         "what another shape in a confirmed object's place falls short by in the log of the "
         "posterior tells shapes apart as if it were so many times less; 1: as it is",
         1, 1000});
  visit(
      o.crop_sharpness,
      {"crop_sharpness", "",
       "log odds per unit of likeness (a cosine) by which a shape or quarter turn looks more like "
       "a crop, 30 as measured; 0: crops are not looked at",
       0, 1000});
  visit(o.inner_lines, {"inner_lines", "", "creases and marks inside the contour count too"});
  visit(o.scored_box,
        {"box", "",
         "whole: the detector scores the whole projection; best: or its visible part, the better"});
  visit(o.search_radius_px,
        {"search_radius_px", "px",
         "length of the search along contour normals, at a focal length of 500", 1, 60});
  visit(o.search_sigma_px,
        {"search_sigma_px", "px",
         "how fast a hit counts less with distance, at a focal length of 500", 0.5, 60});
  visit(o.far_search_sigma_px, {"far_search_sigma_px", "px",
                                "the same where confirmed objects are placed from afar", 0.5, 60});
  visit(o.far_m, {"far_m", "m", "from where on objects are afar", 0, 1e6});
  visit(o.edge_power, {"edge_power", "", "a hit counts probability^power", 0.1, 10});
  visit(o.occlusion_margin_m,
        {"occlusion_margin_m", "m", "a contour hides only behind surfaces this much nearer", 0, 1});
  visit(o.least_contrast,
        {"least_contrast", "",
         "an outline counts before a known thing whose luminance (0 .. 1) differs by this", 0, 1});
  visit(o.min_visible, {"min_visible", "",
                        "share of the contour that must show for an object to be updated", 0, 1});
  visit(o.bearing_noise, {"bearing_noise", "per sqrt(s)", "diffusion of the bearing", 0, 1});
  visit(o.log_depth_noise, {"log_depth_noise", "per sqrt(s)", "diffusion of the log-depth", 0, 1});
  visit(o.azimuth_noise_deg,
        {"azimuth_noise_deg", "deg/sqrt(s)", "diffusion of the azimuth", 0, 180});
  visit(o.jump_rate, {"jump_rate", "1/s", "rate at which the label jumps", 0, 100});
  visit(o.jump_scope, {"jump_scope", "",
                       "labels that a jump may reach: of the category, or all as in the paper"});
  visit(o.floor_prior,
        {"floor_prior", "", "models that stand on floors stand on the floor, where one is known"});
  visit(o.floor_std_m,
        {"floor_std_m", "m", "standard deviation of the base's height above the floor", 0.0001, 1});
  visit(o.contact_std_m,
        {"contact_std_m", "m",
         "standard deviation of the base's height above a mapped object that it stands on, beside "
         "what is known of that object's top",
         0.0001, 1});
  visit(o.scale_std,
        {"scale_std", "",
         "standard deviation of how much larger than its model an object is, 0.03 for 3 %; 0: as "
         "large",
         0, 0.2});
  visit(o.seen_from_behind,
        {"seen_from_behind", "",
         "chance that an object whose model has a back is looked at from behind; 1: as any other",
         1e-12, 1});
  visit(o.prior,
        {"prior", "", "paper: nominal depth; informed: from box size, model size and floor"});
  visit(o.min_spawn_score,
        {"min_spawn_score", "", "lowest score of a proposal that spawns an object", 0, 1});
  visit(o.nominal_depth_m, {"nominal_depth_m", "m", "depth of the paper's prior", 0.1, 100});
  visit(o.nominal_depth_std,
        {"nominal_depth_std", "", "standard deviation of log-depth of the paper's prior", 0, 3});
  visit(o.bearing_std_boxes, {"bearing_std_boxes", "box sizes",
                              "standard deviation of the bearing when an object is spawned", 0, 2});
  visit(o.explained_overlap,
        {"explained_overlap", "", "share of a box or mask that explains a proposal", 0, 1});
  visit(o.max_tentative, {"max_tentative", "", "tentative objects at one time", 1, 1000});
  visit(o.max_spawns_per_frame,
        {"max_spawns_per_frame", "", "objects spawned in one frame", 1, 1000});
  visit(o.key_frames,
        {"key_frames", "", "past frames kept for re-scoring; 0 turns resample-move off", 0, 200});
  visit(o.key_frame_distance_m,
        {"key_frame_distance_m", "m", "camera motion that makes a key frame", 0, 100});
  visit(o.key_frame_angle_deg,
        {"key_frame_angle_deg", "deg", "camera rotation that makes a key frame", 0, 180});
  visit(o.views_per_object,
        {"views_per_object", "", "key frames that an object remembers as views of it", 1, 200});
  visit(o.tentative_search_s, {"tentative_search_s", "s",
                               "between searches for other poses of a tentative object", 0, 1000});
  visit(o.confirmed_search_s, {"confirmed_search_s", "s",
                               "between searches for other poses of a confirmed object", 0, 1000});
  visit(o.correlation_s,
        {"correlation_s", "s", "time after which a resting camera is credited with a second view",
         0.001, 1000});
  visit(o.correlation_m,
        {"correlation_m", "m", "camera motion after which a view of an object is new evidence",
         0.001, 100});
  visit(o.correlation_deg, {"correlation_deg", "deg",
                            "camera rotation after which a view is new evidence", 0.001, 360});
  visit(o.expected_edge,
        {"expected_edge", "",
         "edge term beyond that of places around that speaks neither for nor against an object", -1,
         1});
  visit(o.telling_box,
        {"telling_box", "",
         "score times overlap of a box that speaks for edges that are weak: then half of "
         "expected_edge makes a look",
         0, 1});
  visit(o.most_edge_surplus, {"most_edge_surplus", "",
                              "edge term beyond that of places around that counts at most", 0, 1});
  visit(o.evidence_per_edge,
        {"evidence_per_edge", "", "log odds per independent look and unit of edge term", 0, 1000});
  visit(o.detection_rate,
        {"detection_rate", "", "share of objects in full view that the detector boxes", 0, 0.99});
  visit(o.detectable_px,
        {"detectable_px", "px",
         "area from which the detector boxes objects, at a focal length of 500", 1, 1e7});
  visit(o.false_box_quality,
        {"false_box_quality", "", "score times overlap of a typical false box", 0.001, 1});
  visit(o.most_box_evidence, {"most_box_evidence", "",
                              "log odds that a box adds at most in an independent look", 0, 100});
  visit(o.hidden_rate,
        {"hidden_rate", "", "chance per independent look that something unmapped hides an object",
         0, 1});
  visit(o.hidden_s,
        {"hidden_s", "s", "how long an object stays hidden by something unmapped", 0.01, 10000});
  visit(o.tentative_odds,
        {"tentative_odds", "", "log odds of what a box spawned, before evidence", -100, 100});
  visit(o.passing_share,
        {"passing_share", "",
         "share of the evidence of frames, as they passed, in the log odds of a tentative object",
         0, 10});
  visit(o.remembered_share,
        {"remembered_share", "",
         "share of the evidence of remembered views, for its present pose, in them", 0, 10});
  visit(o.shown_odds, {"shown_odds", "",
                       "log odds, before evidence, of a tentative object of which enough has shown "
                       "at one pose",
                       -100, 100});
  visit(o.box_share,
        {"box_share", "", "share of the evidence of the boxes of remembered views in them", 0, 10});
  visit(o.confirm_evidence, {"confirm_evidence", "", "log odds that confirm an object", -100, 100});
  visit(o.dismiss_evidence,
        {"dismiss_evidence", "", "log odds that retire a tentative object", -100, 100});
  visit(o.retire_evidence,
        {"retire_evidence", "", "log odds that retire a confirmed object", -100, 100});
  visit(o.confirm_position_std_m,
        {"confirm_position_std_m", "m",
         "largest uncertainty of an object to be confirmed (half of its largest side at most)", 0,
         100});
  visit(o.confirm_mode_weight,
        {"confirm_mode_weight", "", "least belief in the mean pose of a confirmed object", 0, 1});
  visit(o.confirm_held_weight,
        {"confirm_held_weight", "",
         "the same, of an object that has shown in two whole looks while it was believed", 0, 1});
  visit(
      o.confirm_shown,
      {"confirm_shown", "",
       "share of the contour that must have shown, with support of edges, for a whole look", 0, 1});
  visit(o.confirm_age_s,
        {"confirm_age_s", "s", "shortest time in view before confirmation", 0, 100});
  visit(o.tentative_limit_s, {"tentative_limit_s", "s",
                              "time in view after which a tentative object is retired", 0, 1000});
  visit(o.room_thing_m,
        {"room_thing_m", "m",
         "horizontal diagonal of the largest things that the filter's lengths (of searches, of "
         "poses that are one, confirm_position_std_m) are meant for; they grow with larger ones "
         "of kinds that move by themselves (cars)",
         0.1, 1000});
  visit(
      o.moving_share,
      {"moving_share", "",
       "share of the things that move by themselves (cars, people) that do move; 0: nothing moves",
       0, 0.99});
  visit(o.moving_speed_m_s,
        {"moving_speed_m_s", "m/s",
         "standard deviation of the velocity of what moves, along each axis", 0.01, 100});
  visit(o.confirm_standing,
        {"confirm_standing", "",
         "least probability that a thing of a kind that moves by itself stands still, for it to be "
         "confirmed",
         0, 1});
  visit(o.left_behind_m,
        {"left_behind_m", "m",
         "distance from the camera at which a tentative object out of view is given up: no room is "
         "as long, and on a street it makes place for what comes",
         1, 1e6});
  visit(o.large_alpha, {"large_alpha", "",
                        "alpha of what moves by itself and is larger than room_thing_m: in a "
                        "street boxes tell places better than "
                        "edges, until it is near",
                        0, 1000});
  visit(o.feigned_speed_m_s,
        {"feigned_speed_m_s", "m/s",
         "speed at which standing things seem to move, as their boxes err alike for a while "
         "(standard deviation)",
         0.01, 100});
  VisitFields(o.paper, visit);
}

}  // namespace plumbline
