// SPDX-License-Identifier: Apache-2.0
#include "tests/app/graph_run.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/recording/frame_codec.h"
#include "engine/recording/run_file.h"
#include "engine/recording/sqlite.h"
#include "engine/vio/own_pose_report.h"
#include "tests/support/drawn_sequence.h"
#include "tests/support/program_process.h"
#include "tests/support/report_bytes.h"

namespace plumbline {
namespace {

/// All rows of a table as text.
std::vector<std::string> Rows(const std::string& file, const std::string& columns,
                              const std::string& table) {
  auto database = sqlite::Database::OpenToRead(file);
  PLB_CHECK(database.ok());
  auto rows = (*database)->Prepare(("SELECT " + columns + " FROM " + table).c_str());
  PLB_CHECK(rows.ok()) << rows.error().message;
  std::vector<std::string> text;
  while (rows->Step().value()) text.emplace_back(rows->Text(0));
  return text;
}

std::string WithoutTimes(OwnPoseReport report) {
  report.tracking_ms = report.vio.step.propagate_ms = report.vio.step.update_ms = 0;
  return EncodeOwnPose(report);
}

}  // namespace

GraphRun::GraphRun(int frames) {
  WriteDrawnSequence(folder_.path() / "sequence", {.frames = frames});
}

pid_t GraphRun::Start(std::vector<std::string> arguments) const {
  return StartProgram(std::move(arguments), Path("output.txt"));
}

std::string GraphRun::Output() const { return ReadFile(Path("output.txt")).value(); }

int GraphRun::FramesIn(const std::string& file) const {
  const auto reader = RunReader::Open(Path(file));
  if (!reader.ok()) return 0;
  const Result<int> frames = (*reader)->NumFrames();
  return frames.ok() ? *frames : 0;
}

std::vector<pid_t> GraphRun::ChildrenOf(pid_t process) {
  std::vector<pid_t> children;
  std::error_code error;
  const std::filesystem::path tasks = "/proc/" + std::to_string(process) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks, error)) {
    std::ifstream list(task.path() / "children");
    for (pid_t child = 0; list >> child;) children.push_back(child);
  }
  return children;
}

std::string GraphRun::CommandOf(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/cmdline", std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  for (char& c : text)
    if (c == '\0') c = ' ';
  return text;
}

std::string GraphRun::Difference(const std::string& one, const std::string& other,
                                 Pictures pictures) const {
  std::string of_frames = "frame || ' ' || stamp_ns || skipped || num_objects";
  if (pictures == Pictures::kCompare) of_frames += " || hex(thumbnail)";
  const auto a = RunReader::Open(Path(one)).value(), b = RunReader::Open(Path(other)).value();
  const int frames = a->NumFrames().value();
  if (b->NumFrames().value() != frames)
    return std::to_string(frames) + " and " + std::to_string(b->NumFrames().value()) + " frames";
  if (a->Finished().value() != b->Finished().value()) return "one has not ended";
  nlohmann::json header_a = HeaderToJson(a->header()), header_b = HeaderToJson(b->header());
  header_a.erase("started");
  header_b.erase("started");
  if (header_a != header_b) return "headers: " + header_a.dump() + "\n" + header_b.dump();
  for (int i = 0; i < frames; ++i) {
    if (BytesOf(a->ReadFrame(i).value()) != BytesOf(b->ReadFrame(i).value()))
      return "the frame at position " + std::to_string(i);
  }
  const auto poses_a = a->ReadOwnPoses().value(), poses_b = b->ReadOwnPoses().value();
  if ((poses_a == nullptr) != (poses_b == nullptr)) return "one found no poses";
  if (poses_a != nullptr) {
    if (poses_a->frames.size() != poses_b->frames.size() || poses_a->causal != poses_b->causal)
      return "the poses found are of other images";
    for (std::size_t i = 0; i < poses_a->frames.size(); ++i) {
      if (WithoutTimes(poses_a->frames[i]) != WithoutTimes(poses_b->frames[i]))
        return "the pose found of image " + std::to_string(i);
    }
  }
  // A resumed run stores once more what it has; all else is the same, row for row.
  for (const auto& [table, columns] :
       {std::pair{"frames", of_frames.c_str()},
        std::pair{"events", "position || ' ' || kind || ' ' || object || ' ' || other || text"},
        std::pair{"objects",
                  "position || ' ' || object || ' ' || state || category || label || "
                  "IFNULL(confirmed_frame, '-') || weighed || hex(details)"}}) {
    if (Rows(Path(one), columns, table) != Rows(Path(other), columns, table))
      return std::string("table ") + table;
  }
  return "";
}

}  // namespace plumbline
