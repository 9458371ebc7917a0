// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// What a page of a batch is about, besides what the batch says.
struct BatchReportInputs {
  std::filesystem::path folder;   ///< Of the batch; the page lies there and links into it.
  std::optional<BatchGate> gate;  ///< Against a baseline.
  std::string plan;               ///< As JSON.
};

/// The page of a batch (HtmlPage): figures with intervals, differences, responses to what was
/// swept, the worst runs with what they missed and why, failures with their logs.
std::string BatchReportHtml(const BatchView& view, const BatchReportInputs& inputs);

/// "93.1 [90.2, 95.9]"; "-" where there is none.
std::string EstimateInWords(const std::optional<MeanEstimate>& estimate);

/// "< 0.001", "0.04".
std::string ProbabilityInWords(double p);

}  // namespace plumbline
