// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "engine/base/options.h"

namespace plumbline {

/// How the mapper updates what it believes.
enum class FilterKind {
  kPosterior,  ///< Plumbline's own: remembered views, moves that leave the posterior unchanged.
  kPaper       ///< The authors' (paper_filter.md).
};

template <>
struct EnumNames<FilterKind> {
  static constexpr std::string_view names[] = {"posterior", "paper"};
};

/// Settings of the authors' filter: those for chairs in the files that they published
/// (github.com/feixh/VISMA-tracker, commit b52c94b). Used with `filter` = paper alone;
/// docs/algorithms/paper_filter.md explains each.
struct PaperOptions {
  // Proposals
  double min_score = 0.8;
  double min_box_share = 0.01;

  // Particles
  int particles_per_shape = 1000;
  double bearing_x_std = 0.1;
  double bearing_y_std = 0.2;
  double depth_m = 2.5;
  double log_depth_std = 1.0;

  // Diffusion for each update, before it has settled and after
  double bearing_x_noise = 0.01;
  double bearing_y_noise = 0.02;
  double log_depth_noise = 0.05;
  double azimuth_noise_rad = 1.0;
  double azimuth_redrawn = 1.0;
  double label_kept = 0.6;
  double settled_bearing_noise = 0.001;
  double settled_log_depth_noise = 0.005;
  double settled_azimuth_noise_rad = 0.01;
  double settled_label_kept = 0.9999;

  // Score
  int levels = 2;
  double edge_weight = 200;
  double detector_weight = 50;
  double search_px = 20;
  int edge_threshold = 64;
  double edge_agreement = 0.8;

  // Life
  double min_visible = 0.8;
  int max_updates = 150;
  int max_unmatched = 15;
};

template <typename Visitor>
void VisitFields(PaperOptions& o, Visitor&& visit) {
  visit(o.min_score,
        {"paper_min_score", "", "filter = paper: proposals of a lower score are not seen", 0, 1});
  visit(o.min_box_share, {"paper_min_box_share", "",
                          "filter = paper: least share of the image of a proposal", 0, 1});
  visit(o.particles_per_shape,
        {"paper_particles_per_shape", "",
         "filter = paper: hypotheses of each shape until an object has settled", 10, 5000});
  visit(o.bearing_x_std,
        {"paper_bearing_x_std", "", "filter = paper: standard deviation of X/Z at birth", 0, 1});
  visit(o.bearing_y_std,
        {"paper_bearing_y_std", "", "filter = paper: standard deviation of Y/Z at birth", 0, 1});
  visit(o.depth_m, {"paper_depth_m", "m", "filter = paper: depth at birth", 0.1, 100});
  visit(o.log_depth_std, {"paper_log_depth_std", "",
                          "filter = paper: standard deviation of log-depth at birth", 0, 3});
  visit(o.bearing_x_noise, {"paper_bearing_x_noise", "per update",
                            "filter = paper: diffusion of X/Z until it has settled", 0, 1});
  visit(o.bearing_y_noise, {"paper_bearing_y_noise", "per update",
                            "filter = paper: diffusion of Y/Z until it has settled", 0, 1});
  visit(o.log_depth_noise, {"paper_log_depth_noise", "per update",
                            "filter = paper: diffusion of log-depth until it has settled", 0, 1});
  visit(o.azimuth_noise_rad,
        {"paper_azimuth_noise_rad", "rad per update",
         "filter = paper: diffusion of azimuths that are not drawn anew", 0, 10});
  visit(
      o.azimuth_redrawn,
      {"paper_azimuth_redrawn", "",
       "filter = paper: share of azimuths drawn anew at every update until it has settled", 0, 1});
  visit(o.label_kept,
        {"paper_label_kept", "",
         "filter = paper: chance per update that a label stays, until settled", 0, 1});
  visit(o.settled_bearing_noise, {"paper_settled_bearing_noise", "per update",
                                  "filter = paper: diffusion of X/Z and Y/Z once settled", 0, 1});
  visit(o.settled_log_depth_noise, {"paper_settled_log_depth_noise", "per update",
                                    "filter = paper: diffusion of log-depth once settled", 0, 1});
  visit(o.settled_azimuth_noise_rad,
        {"paper_settled_azimuth_noise_rad", "rad per update",
         "filter = paper: diffusion of the azimuth once settled", 0, 10});
  visit(o.settled_label_kept,
        {"paper_settled_label_kept", "",
         "filter = paper: chance per update that a label stays, once settled", 0, 1});
  visit(o.levels, {"paper_levels", "",
                   "filter = paper: image sizes, each half the next; one update on each", 1, 4});
  visit(o.edge_weight, {"paper_edge_weight", "",
                        "filter = paper: weight of the edge score at full size", 0, 10000});
  visit(o.detector_weight,
        {"paper_detector_weight", "",
         "filter = paper: weight of the logarithm of the detector's score at full size", 0, 10000});
  visit(o.search_px, {"paper_search_px", "px",
                      "filter = paper: length of the search along contour normals, halved for each "
                      "level from the coarsest on",
                      1, 100});
  visit(o.edge_threshold,
        {"paper_edge_threshold", "", "filter = paper: least level of an edge, of 255", 1, 255});
  visit(o.edge_agreement,
        {"paper_edge_agreement", "",
         "filter = paper: least |cos| of the angle between contour normal and edge normal", 0, 1});
  visit(o.min_visible, {"paper_min_visible", "",
                        "filter = paper: share of the contour that must not be hidden for an "
                        "object to be updated",
                        0, 1});
  visit(o.max_updates,
        {"paper_max_updates", "",
         "filter = paper: updates after which an object that has not settled goes", 1, 100000});
  visit(o.max_unmatched,
        {"paper_max_unmatched", "",
         "filter = paper: frames without a box after which an object goes", 1, 100000});
}

}  // namespace plumbline
