// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// What figures do as swept options change, for the page of a batch: lines with intervals over the
/// first option and, where two are swept, tables of means as well. "" without a sweep.
std::string BatchResponsesHtml(const BatchView& view);

}  // namespace plumbline
