// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/base/result.h"
#include "engine/models/axis_guess.h"
#include "engine/models/model_builder.h"

namespace plumbline {

/// Unit, up and front of a mesh into the report: as the options state them, else as the file does
/// unless that cannot be (a chair of 90 m; one that would fall over), else guessed. `mesh`: in the
/// units and axes of the file, with the colours that it shows. `named`: what its name says that it
/// is; dropped where its size cannot be that. Errors: kInvalidInput for options that contradict
/// each other, kDegenerate.
Status SettleFrame(const TriangleMesh& mesh, const FileFrame& frame, const std::string& extension,
                   const ModelBuildOptions& options, const Thing*& named, ModelBuildReport& report);

/// "m", "cm", "mm" or the number with "m".
std::string UnitText(double metres);

}  // namespace plumbline
