// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a page of a run holds, as JSON; assets/run_page/run.js reads it. Rows are short because
// there are many: `fields` names their columns.

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "engine/analysis/run_review.h"
#include "engine/geometry/mesh.h"
#include "engine/mapping/map_report.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {

/// Names of the columns of boxes, objects, modes and errors.
nlohmann::json RunPageFields();

/// One frame. Pixels become those of the page.
/// @param sample   Of the same frame.
/// @param outlines, true_outlines  In pixels of the camera; the latter numbered as `view.truth`,
///                                 from 1.
/// @param page_from_image  Pixels of the page for one of the camera.
nlohmann::json RunPageFrame(const FrameReport& report, const FrameSample& sample,
                            std::span<const OutlineView> outlines,
                            std::span<const OutlineView> true_outlines, double page_from_image);

/// Vertices as 16-bit fractions of their box, in base 64. At most 65535 vertices.
nlohmann::json RunPageMesh(const TriangleMesh& mesh);

/// Every object of the run, by id.
nlohmann::json RunPageObjects(const RunReview& review);
nlohmann::json RunPageEvents(const RunReview& review);
nlohmann::json RunPageTruth(const RunReview& review);

/// JSON as it may stand inside a script element: nothing in it can end the element or a line.
std::string InScript(const nlohmann::json& json);

}  // namespace plumbline
