// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/annotation/pose_exchange.h"

namespace plumbline {

/// Something in a document that is probably wrong.
struct AnnotationFinding {
  std::string kind;  ///< tilted, floating, sunk, interpenetrating, duplicate, draft_on_object,
  ///< low_agreement, unknown_model, missing_frames, empty_crop, unmade_crop
  std::vector<std::string> instances;
  double amount = 0;  ///< Of `unit`.
  std::string unit;   ///< deg, m or frames; "" where there is no amount
  std::string sentence;

  /// Whether it says that an object is wrong; else it is only worth knowing.
  bool IsError() const { return kind != "missing_frames" && kind != "empty_crop"; }
};

struct AnnotationCheckOptions {
  double tilt_deg = 0.5;
  double floor_gap_m = 0.02;  ///< For models whose support is the floor.
  double overlap_m = 0.02;    ///< Depth of one object in another.
  double duplicate_m = 0.05;  ///< Between the centres of two instances of one model.
  double draft_m = 0.3;       ///< Between those of a draft and of what was placed, of one category.
  double agreement = 0.2;     ///< With the images, as of MeanAgreement.
};

/// A finding as it is accepted now; nothing if it is not about placed objects.
std::optional<AcceptedFinding> AcceptanceOf(const AnnotationFinding& finding,
                                            const AnnotationDocument& document);
/// Where it was accepted, and still holds: all objects are as they were then, and it has not grown.
/// Null: it is open. Points into the document.
const AcceptedFinding* FindAcceptance(const AnnotationFinding& finding,
                                      const AnnotationDocument& document,
                                      const AcceptanceLimits& limits = {});

/// An instance that came from a run and that nobody has called fine yet.
bool IsDraft(const AnnotatedInstance& instance);
/// The note of a draft begins with it.
inline constexpr const char* kDraftNote = "draft: ";

/// Whether an outline lies on too few edges of images that show it well. @param agreement As of
/// MeanAgreement, in `images` images.
std::optional<AnnotationFinding> CheckAgreement(const std::string& instance, double agreement,
                                                std::size_t images,
                                                const AnnotationCheckOptions& options = {});

/// `models`, `sequence` and `scan` may be null: then what needs them is not looked at.
std::vector<AnnotationFinding> CheckAnnotations(const AnnotationDocument& document,
                                                const ExchangeInputs& inputs,
                                                const AnnotationCheckOptions& options = {});

}  // namespace plumbline
