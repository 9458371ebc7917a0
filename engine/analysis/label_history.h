// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/object_history.h"
#include "engine/snapshot/run_history.h"

namespace plumbline {

LabelHistory LabelsOf(const RunHistory& history, ObjectId object);

}  // namespace plumbline
