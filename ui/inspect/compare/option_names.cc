// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/compare/option_names.h"

namespace plumbline {
namespace {

constexpr std::string_view kScore = "What an image says", kSearch = "How edges are sought",
                           kParticles = "Hypotheses", kMotion = "How hypotheses spread",
                           kBirth = "New objects", kMemory = "Remembered views",
                           kEvidence = "Whether it is there", kLife = "Confirmed or withdrawn",
                           kOutdoors = "Outdoors", kPaper = "Filter as in the paper";

constexpr OptionName kNames[] = {
    {"filter", kScore, "Filter"},
    {"beta", kScore, "Weight of edges"},
    {"alpha", kScore, "Weight of the detector"},
    {"box", kScore, "Box that is scored"},
    {"view_correlation", kScore, "Error that never averages out"},
    {"landmark_drift_m", kScore, "Drift that objects correct"},
    {"telling_contour_px", kScore, "Contour that counts fully"},
    {"crop_sharpness", kScore, "Weight of crops"},
    {"min_visible", kScore, "Least share to show"},

    {"search_radius_px", kSearch, "How far to look"},
    {"search_sigma_px", kSearch, "How fast distance counts less"},
    {"inner_lines", kSearch, "Creases and marks, too"},
    {"edge_power", kSearch, "Power of edge probability"},
    {"occlusion_margin_m", kSearch, "Nearer surface that hides"},

    {"particles", kParticles, "Of a settled object"},
    {"tentative_particles", kParticles, "Until it is confirmed"},
    {"spawn_particles", kParticles, "Tried for a new object"},
    {"resample", kParticles, "When to resample"},
    {"resample_below", kParticles, "Effective share that resamples"},

    {"bearing_noise", kMotion, "Direction"},
    {"log_depth_noise", kMotion, "Distance (logarithm)"},
    {"azimuth_noise_deg", kMotion, "Azimuth"},
    {"jump_rate", kMotion, "Changes of shape"},
    {"jump_scope", kMotion, "Shapes to change to"},
    {"floor_prior", kMotion, "Stand on the floor"},
    {"floor_std_m", kMotion, "Height above the floor"},
    {"scale_std", kMotion, "Size against the model"},
    {"seen_from_behind", kMotion, "Backs that are looked at"},

    {"min_spawn_score", kBirth, "Least score of a box"},
    {"explained_overlap", kBirth, "Overlap that explains a box"},
    {"max_tentative", kBirth, "Candidates at one time"},
    {"max_spawns_per_frame", kBirth, "New ones in a frame"},
    {"prior", kBirth, "First guess of the distance"},
    {"nominal_depth_m", kBirth, "Distance, as in the paper"},
    {"nominal_depth_std", kBirth, "Its spread (logarithm)"},
    {"bearing_std_boxes", kBirth, "Spread of the direction"},

    {"key_frames", kMemory, "Key frames kept"},
    {"key_frame_distance_m", kMemory, "Way between them"},
    {"key_frame_angle_deg", kMemory, "Turn between them"},
    {"views_per_object", kMemory, "Views of an object"},
    {"tentative_search_s", kMemory, "Search again: candidates"},
    {"confirmed_search_s", kMemory, "Search again: confirmed"},

    {"expected_edge", kEvidence, "Edge term that says nothing"},
    {"most_edge_surplus", kEvidence, "Most that edges count"},
    {"evidence_per_edge", kEvidence, "Evidence of edges"},
    {"detection_rate", kEvidence, "Share that the detector finds"},
    {"detectable_px", kEvidence, "Size that it finds"},
    {"false_box_quality", kEvidence, "Quality of a false box"},
    {"most_box_evidence", kEvidence, "Most that a box counts"},
    {"hidden_rate", kEvidence, "Chance of being hidden"},
    {"hidden_s", kEvidence, "Hidden for how long"},
    {"correlation_s", kEvidence, "New look at rest after"},
    {"correlation_m", kEvidence, "New look after moving by"},
    {"correlation_deg", kEvidence, "New look after turning by"},
    {"tentative_odds", kEvidence, "Odds before evidence"},
    {"passing_share", kEvidence, "Share of passing frames"},
    {"remembered_share", kEvidence, "Share of remembered views"},

    {"confirm_evidence", kLife, "Evidence that confirms"},
    {"dismiss_evidence", kLife, "That withdraws a candidate"},
    {"retire_evidence", kLife, "That withdraws a confirmed one"},
    {"confirm_position_std_m", kLife, "Largest spread to confirm"},
    {"confirm_mode_weight", kLife, "Least belief in one place"},
    {"confirm_shown", kLife, "Contour that must have shown"},
    {"confirm_age_s", kLife, "Shortest time to confirm"},
    {"tentative_limit_s", kLife, "Longest time as a candidate"},

    {"room_thing_m", kOutdoors, "Largest thing of a room"},
    {"moving_share", kOutdoors, "Share of cars that move"},
    {"moving_speed_m_s", kOutdoors, "Their speed"},
    {"confirm_standing", kOutdoors, "Belief that it stands"},
    {"left_behind_m", kOutdoors, "Left behind from"},
    {"large_alpha", kOutdoors, "Weight of the detector"},
    {"feigned_speed_m_s", kOutdoors, "Speed that errors feign"},

    {"paper_min_score", kPaper, "Least score of a box"},
    {"paper_min_box_share", kPaper, "Least size of a box"},
    {"paper_particles_per_shape", kPaper, "Hypotheses of a shape"},
    {"paper_bearing_x_std", kPaper, "Birth: X/Z"},
    {"paper_bearing_y_std", kPaper, "Birth: Y/Z"},
    {"paper_depth_m", kPaper, "Birth: distance"},
    {"paper_log_depth_std", kPaper, "Birth: distance (logarithm)"},
    {"paper_bearing_x_noise", kPaper, "Unsettled: X/Z"},
    {"paper_bearing_y_noise", kPaper, "Unsettled: Y/Z"},
    {"paper_log_depth_noise", kPaper, "Unsettled: distance"},
    {"paper_azimuth_noise_rad", kPaper, "Unsettled: azimuth"},
    {"paper_azimuth_redrawn", kPaper, "Azimuths drawn anew"},
    {"paper_label_kept", kPaper, "Unsettled: keeps its shape"},
    {"paper_settled_bearing_noise", kPaper, "Settled: X/Z and Y/Z"},
    {"paper_settled_log_depth_noise", kPaper, "Settled: distance"},
    {"paper_settled_azimuth_noise_rad", kPaper, "Settled: azimuth"},
    {"paper_settled_label_kept", kPaper, "Settled: keeps its shape"},
    {"paper_levels", kPaper, "Image sizes"},
    {"paper_edge_weight", kPaper, "Weight of edges"},
    {"paper_detector_weight", kPaper, "Weight of the detector"},
    {"paper_search_px", kPaper, "How far to look for edges"},
    {"paper_edge_threshold", kPaper, "Least level of an edge"},
    {"paper_edge_agreement", kPaper, "Agreement of directions"},
    {"paper_min_visible", kPaper, "Least share to show"},
    {"paper_max_updates", kPaper, "Updates to settle in"},
    {"paper_max_unmatched", kPaper, "Frames without a box"},
};

}  // namespace

std::span<const OptionName> MapperOptionNames() { return kNames; }

}  // namespace plumbline
