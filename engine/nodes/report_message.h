// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/result.h"
#include "engine/mapping/map_report.h"
#include "engine/transport/plumbline.pb.h"

namespace plumbline {

/// A report of the mapper as a message has it: what people read of it as fields, all of it as the
/// run file keeps it.
/// @param particles  Without them it is small, and nothing can go on from it.
wire::Report ReportToWire(const FrameReport& report, bool particles);

/// The reverse, bit for bit, but for what run files do not keep (`skip_cause`, `landmarks`).
/// @param num_models  Of the run: labels count them.
/// Errors: kCorrupt.
Result<FrameReport> ReportFromWire(const wire::Report& message, int num_models);

}  // namespace plumbline
