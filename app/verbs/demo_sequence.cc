// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/demo_sequence.h"

#include <string>

#include "engine/base/files.h"
#include "engine/synthetic/sequence_writer.h"

namespace plumbline {

Result<std::filesystem::path> BuiltInSequence(int frames, const WorkContext& work) {
  const std::string name = "demo-room-" PLUMBLINE_VERSION "-" + std::to_string(frames);
  const std::filesystem::path folder = CacheDirectory() / name;
  const std::filesystem::path done = CacheDirectory() / (name + ".complete");
  std::error_code error;
  if (std::filesystem::exists(done, error) && std::filesystem::exists(folder, error)) return folder;
  work.report({"filming the built-in room, once"});
  SyntheticOptions options;
  options.frames = frames;
  Result<SyntheticSummary> made = WriteSyntheticSequence(options, folder, work);
  if (!made.ok()) return made.error();
  if (Status status = WriteFileAtomically(done, "complete\n"); !status.ok()) return status.error();
  return folder;
}

}  // namespace plumbline
