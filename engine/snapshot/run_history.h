// SPDX-License-Identifier: Apache-2.0
#pragma once

// A run at a glance, for time lines, plots and tables: little of every frame, all frames at once.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/geometry/box.h"
#include "engine/mapping/event_report.h"

namespace plumbline {

enum class ProposalFate : std::uint8_t;  // mapping/map_report.h

/// How far an estimate is from the true instance that it is compared with, one to one.
struct TruthError {
  std::string truth;           ///< Its id.
  bool model_correct = false;  ///< The most likely shape is the true one.
  float translation_m = 0;     ///< Between origins.
  float azimuth_rad = 0;       ///< Modulo the shape's symmetry, >= 0; 0 for a round one.
  /// Share of the belief that is likelier than the truth (evaluation/credible_region.h).
  float credible_level = 0;
  float nees = 0;  ///< Normalised estimation error squared of the mean.
  int degrees_of_freedom = 4;
  bool several_models = true;  ///< The category has more than one: its shape is a question.
};

/// A true instance in one frame.
struct TruthSample {
  float visible_px = 0;    ///< Pixels of it that show; the true models hide one another.
  Box2 box;                ///< Around what shows [px]; empty if nothing does.
  ObjectId object;         ///< Paired with it, one to one; not valid: none.
  bool confirmed = false;  ///< That object is.
  std::optional<ProposalFate> box_fate;  ///< Of the proposal that lies over it best; nothing: none.
  float box_overlap = 0;                 ///< Intersection over union of that proposal and `box`.
  ObjectId box_object;                   ///< That took the proposal.
  /// An object of its category within a metre.
  struct Near {
    ObjectId object;
    float distance_m = 0;   ///< Between origins.
    float azimuth_rad = 0;  ///< As TruthError::azimuth_rad.
  };
  std::vector<Near> near;  ///< By distance.
};

/// An object in one frame.
struct ObjectSample {
  ObjectId id;
  ObjectState state = ObjectState::kTentative;
  bool updated = false;
  ModelId label;
  std::vector<LabelProbability> label_probability;  ///< Those of 2 % at least.
  float position_std_m = 0, azimuth_std_rad = 0;    ///< Over all modes (ObjectSpread).
  bool round = false;                               ///< Its shape has no azimuth.
  float phi_cnn = 0, phi_edge = 0;
  float log_evidence = 0;
  float effective_sample_size = 0;
  float visible_fraction = 0;
  std::optional<TruthError> error;  ///< Nothing without truth, or further than a metre from any.
};

struct FrameSample {
  int frame = 0;
  bool skipped = false;
  std::vector<ObjectSample> objects;
  std::vector<TruthSample> truths;  ///< As in SequenceView::truth; empty where none is known.
  std::vector<StageTiming> timings;
};

/// A small picture of a frame; some frames have one.
struct FrameThumbnail {
  int frame = 0;
  cv::Mat image;  ///< CV_8UC3 BGR, 96 px wide
};

/// Grows while a run is mapped or read. Samples are shared between versions, never written again.
struct RunHistory {
  std::vector<std::shared_ptr<const FrameSample>> frames;  ///< By position; null: not read yet.
  std::vector<FrameThumbnail> thumbnails;                  ///< By frame, evenly spread.
};

}  // namespace plumbline
