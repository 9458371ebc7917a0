// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/annotate_register.h"

#include <cstdio>
#include <numbers>

#include <nlohmann/json.hpp>

#include "app/verbs/annotation_inputs.h"
#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/annotation/reopening.h"
#include "engine/models/mesh_file.h"
#include "engine/session/registration_pairs.h"
#include "engine/session/sequence_registration.h"

namespace plumbline {
namespace {

Result<SequenceAlignment> Align(const AnnotationProject& project, const Sequence& sequence,
                                const RegisterArguments& arguments,
                                std::vector<std::string>& names) {
  const AnnotationDocument& document = project.document();
  if (!arguments.pairs.empty()) {
    const auto pairs = ReadRegistrationPairs(arguments.pairs);
    if (!pairs) return pairs.error();
    auto found = RegisterByPicks(document, sequence, pairs->in_frames, pairs->in_world);
    if (found) return found;
    return Error{found.error().code, "'" + arguments.pairs + "': " + found.error().message};
  }
  if (!arguments.run.empty()) return RegisterByObjects(document, sequence, arguments.run, names);
  const auto scan = ReadMesh(project.Resolve(document.scan));
  if (!scan) return scan.error();
  const auto target = ScanTarget::Prepare(*scan);
  if (!target) return target.error();
  ConsoleWork work;
  return RegisterByPoints(document, sequence, **target, arguments.points, work.context());
}

nlohmann::json ToJson(const SequenceAlignment& found, const std::vector<std::string>& names) {
  nlohmann::json rows = nlohmann::json::array();
  const Eigen::Matrix4d matrix = found.scan_from_world.matrix();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
  }
  const Eigen::Vector3d& std_m = found.position_std_m;
  nlohmann::json result = {{"scan_from_world", rows},
                           {"position_std_m", {std_m.x(), std_m.y(), std_m.z()}},
                           {"azimuth_std_rad", found.azimuth_std_rad},
                           {"rmse_m", found.rmse_m},
                           {"share", found.share},
                           {"residuals", found.residuals}};
  if (!names.empty()) result["objects"] = names;
  return result;
}

}  // namespace

void AddRegisterOptions(CLI::App& command, RegisterArguments& arguments) {
  CLI::Option_group* by = command.add_option_group("by");
  by->add_option("--pairs", arguments.pairs,
                 "The same points in both: a JSON list of {in_scan: [x, y, z], frame, pixel: [u, "
                 "v]} or {in_scan, in_world: [x, y, z]}")
      ->type_name("PAIRS.json");
  by->add_option("--points", arguments.points,
                 "Sparse points of the sequence's map, in its world (.ply, .pcd), laid onto the "
                 "scan")
      ->type_name("MAP.ply");
  by->add_option("--run", arguments.run,
                 "A run of the sequence: its objects are brought onto the annotated ones")
      ->type_name("RUN.plb");
  by->require_option(1);
}

Status RegisterSequence(const std::string& file, const RegisterArguments& arguments,
                        const std::string& json_file) {
  auto project = OpenProject(file, AnnotationProject::Access::kWrite);
  if (!project) return project.error();
  const auto inputs = OpenInputs(**project);
  if (!inputs) return inputs.error();
  if (!inputs->sequence) {
    return Error{ErrorCode::kInvalidInput, "'" + file + "' has no sequence to register"};
  }
  std::vector<std::string> names;
  const auto found = Align(**project, *inputs->sequence, arguments, names);
  if (!found) return found.error();
  if (json_file != "-") {
    std::printf("registered to +- %.1f cm and %.2f degrees, %.0f %% used, %.1f cm rms\n",
                100 * found->position_std_m.norm(), found->azimuth_std_rad * 180 / std::numbers::pi,
                100 * found->share, 100 * found->rmse_m);
  }
  const Edit edit =
      WithReopening(SetSceneAlignment{found->scan_from_world}, (*project)->document(), "");
  const Status applied = (*project)->Apply(edit);
  if (!applied.ok()) return applied;
  if (const Status saved = (*project)->Save(); !saved.ok()) return saved;
  return json_file.empty() ? Status() : WriteJsonResult(json_file, ToJson(*found, names));
}

}  // namespace plumbline
