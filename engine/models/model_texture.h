// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/models/model_database.h"

namespace plumbline {

/// The picture on a model's surface, which its mesh names relative to its own file; "" where it has
/// none, or where the picture is not there.
std::filesystem::path TextureOf(const ModelDatabase& models, const CadModel& model);

}  // namespace plumbline
