// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/staged_export.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/ground_truth.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

using std::filesystem::path;

constexpr std::size_t kMostNamed = 6;
constexpr double kSame_m = 5e-5, kSame_rad = 5e-5;

/// "3 files will be replaced: a, b, c."
std::string Listed(const std::string& what, const std::vector<std::string>& names) {
  std::string text = what + ": ";
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i)
    text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kMostNamed) text += fmt::format(" and {} more", names.size() - kMostNamed);
  return text + ".";
}

std::string Counted(std::size_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

bool SameContent(const path& a, const path& b) {
  std::error_code error;
  if (std::filesystem::file_size(a, error) != std::filesystem::file_size(b, error) || error)
    return false;
  const auto left = ReadFile(a), right = ReadFile(b);
  return left.ok() && right.ok() && *left == *right;
}

/// The old file under another name, at no cost where the file system can do that.
Status Keep(const path& file, const path& as) {
  std::error_code error;
  std::filesystem::create_directories(as.parent_path(), error);
  std::filesystem::create_hard_link(file, as, error);
  if (error) std::filesystem::copy_file(file, as, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, "cannot keep '" + file.string() + "' as '" + as.string() +
                                   "': " + error.message() + "; nothing was replaced"};
}

/// What else than its pose differs; "" if nothing does.
std::string OtherChange(const GroundTruthInstance& before, const GroundTruthInstance& after) {
  std::vector<std::string> changes;
  const auto note = [&](const char* what, const std::string& from, const std::string& to) {
    if (from != to) changes.push_back(fmt::format("{} {} instead of {}", what, to, from));
  };
  const auto quality = [](bool fine) { return std::string(fine ? "fine" : "coarse"); };
  note("model", before.model, after.model);
  note("category", before.category, after.category);
  note("quality", quality(before.fine), quality(after.fine));
  if (before.scale != after.scale)
    changes.push_back(fmt::format("scale {:g} instead of {:g}", after.scale, before.scale));
  const bool told = before.position_std_m || before.azimuth_std_rad;
  const bool tells = after.position_std_m || after.azimuth_std_rad;
  if (told && !tells) changes.emplace_back("how well it is known is not told any more");
  if (tells && (before.position_std_m != after.position_std_m ||
                before.azimuth_std_rad != after.azimuth_std_rad)) {
    std::string known;
    if (after.position_std_m) known = fmt::format(" {:.1f} cm", 100 * *after.position_std_m);
    if (after.azimuth_std_rad)
      known += fmt::format(" {:.1f}\u00b0", *after.azimuth_std_rad * kDegPerRad);
    changes.push_back("known to" + known);
  }
  std::string text;
  for (const std::string& change : changes) text += (text.empty() ? "" : ", ") + change;
  return text;
}

}  // namespace

std::vector<std::string> TruthDifferences(const path& before, const path& after) {
  const auto old_truth = ReadGroundTruth(before), new_truth = ReadGroundTruth(after);
  if (!old_truth.ok() || !new_truth.ok()) {
    return {"What is there is no ground truth that can be read: " +
            (old_truth.ok() ? new_truth : old_truth).error().message};
  }
  const auto named = [](const GroundTruth& truth, const std::string& id) {
    return std::find_if(truth.instances.begin(), truth.instances.end(),
                        [&](const auto& instance) { return instance.id == id; });
  };
  std::vector<std::string> moved, changed, added, gone;
  std::size_t in_both = 0, far = 0;
  for (const GroundTruthInstance& instance : new_truth->instances) {
    const auto old = named(*old_truth, instance.id);
    if (old == old_truth->instances.end()) {
      added.push_back(instance.id);
      continue;
    }
    ++in_both;
    const Eigen::Isometry3d change = old->world_from_object.inverse() * instance.world_from_object;
    const double shift_m = change.translation().norm();
    const double turn_rad = Eigen::AngleAxisd(change.linear()).angle();
    if (shift_m > kSame_m || turn_rad > kSame_rad) {
      moved.push_back(fmt::format("{} by {:.1f} cm and {:.1f}\u00b0", instance.id, 100 * shift_m,
                                  turn_rad * kDegPerRad));
    }
    if (shift_m > 0.3) ++far;
    if (const std::string other = OtherChange(*old, instance); !other.empty())
      changed.push_back(instance.id + " (" + other + ")");
  }
  for (const GroundTruthInstance& instance : old_truth->instances) {
    if (named(*new_truth, instance.id) == new_truth->instances.end()) gone.push_back(instance.id);
  }
  std::vector<std::string> sentences;
  if (in_both > 1 && far == in_both)
    sentences.emplace_back("Every object is elsewhere: is it in another frame?");
  const auto tell = [&](const std::vector<std::string>& names, const char* what) {
    if (!names.empty())
      sentences.push_back(Listed(Counted(names.size(), "object", "objects") + what, names));
  };
  tell(gone, " would be gone");
  tell(moved, " would be moved");
  tell(changed, " would be changed");
  tell(added, " would be new");
  const double gravity_rad = std::acos(
      std::clamp(old_truth->gravity_in_world.dot(new_truth->gravity_in_world), -1.0, 1.0));
  if (gravity_rad > 1e-6)
    sentences.push_back(fmt::format("Gravity differs by {:.2f}\u00b0.", gravity_rad * kDegPerRad));
  if (sentences.empty()) sentences.emplace_back("The objects are the same; other text differs.");
  return sentences;
}

Result<std::unique_ptr<StagedExport>> StagedExport::Write(const AnnotationDocument& document,
                                                          const ExchangeInputs& inputs,
                                                          const path& scan_file,
                                                          const ExportRequest& request,
                                                          const WorkContext& work) {
  if (request.out.empty()) return InvalidInput("an export needs the name of a file or a folder");
  std::error_code error;
  path out = std::filesystem::absolute(request.out, error).lexically_normal();
  if (!out.has_filename()) out = out.parent_path();
  const path folder =
      out.parent_path() / fmt::format(".{}.new-{}", out.filename().string(), ::getpid());
  std::filesystem::remove_all(folder, error);
  std::unique_ptr<StagedExport> staged(new StagedExport(out, folder));
  ExportRequest there = request;
  there.out = folder / out.filename();
  const Status written = ExportAnnotation(document, inputs, scan_file, there, work);
  if (!written.ok()) {
    // People know the place that they chose, not the one where it waits.
    std::string message = written.error().message;
    for (std::size_t at; (at = message.find(there.out.string())) != std::string::npos;)
      message.replace(at, there.out.string().size(), out.string());
    return Error{written.error().code, message};
  }
  staged->Compare();
  const bool other_kind = std::filesystem::exists(out, error) &&
                          std::filesystem::is_directory(out, error) != staged->is_folder_;
  if (other_kind) {
    return InvalidInput("'" + out.string() + "' is a " +
                        (staged->is_folder_ ? "file, and this format needs a folder"
                                            : "folder, and this format needs a file"));
  }
  return staged;
}

StagedExport::~StagedExport() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void StagedExport::Compare() {
  std::error_code ignored;
  const path staged = folder_ / out_.filename();
  is_folder_ = std::filesystem::is_directory(staged, ignored);
  std::vector<path> names;
  if (is_folder_) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(staged, ignored)) {
      if (!entry.is_directory()) names.push_back(entry.path().lexically_relative(staged));
    }
    std::sort(names.begin(), names.end());
  } else {
    names.emplace_back();
  }
  for (path& name : names) {
    const path there = name.empty() ? out_ : out_ / name;
    const path here = name.empty() ? staged : staged / name;
    auto& list = !std::filesystem::exists(there, ignored) ? added_
                 : SameContent(there, here)               ? same_
                                                          : replaced_;
    list.push_back(std::move(name));
  }
}

std::vector<std::string> StagedExport::Differences() const {
  if (replaced_.empty()) return {};
  const path staged = folder_ / out_.filename();
  if (!is_folder_) {
    const bool truth = ReadGroundTruth(staged).ok();
    return truth ? TruthDifferences(out_, staged)
                 : std::vector<std::string>{"There is another file of this name."};
  }
  std::vector<std::string> names;
  for (const path& name : replaced_) names.push_back(name.string());
  std::vector<std::string> sentences = {
      Listed(Counted(names.size(), "file", "files") + " would be replaced", names)};
  if (!added_.empty() || !same_.empty()) {
    sentences.push_back(
        fmt::format("{} would be new, {} stay as they are.", added_.size(), same_.size()));
  }
  return sentences;
}

path StagedExport::FreeBackup() const {
  std::error_code ignored;
  path backup = out_.string() + ".bak";
  for (int i = 2; std::filesystem::exists(backup, ignored); ++i)
    backup = fmt::format("{}.bak-{}", out_.string(), i);
  return backup;
}

Result<path> StagedExport::Take() {
  const path staged = folder_ / out_.filename();
  const path backup = replaced_.empty() ? path() : FreeBackup();
  for (const path& name : replaced_) {
    const Status kept = name.empty() ? Keep(out_, backup) : Keep(out_ / name, backup / name);
    if (!kept.ok()) return kept.error();
  }
  for (const auto* names : {&added_, &replaced_}) {
    for (const path& name : *names) {
      const path to = name.empty() ? out_ : out_ / name;
      std::error_code error;
      std::filesystem::create_directories(to.parent_path(), error);
      std::filesystem::rename(name.empty() ? staged : staged / name, to, error);
      if (error) {
        return Error{
            ErrorCode::kIo,
            "cannot write '" + to.string() + "': " + error.message() +
                (backup.empty() ? "" : "; what was there is kept as '" + backup.string() + "'")};
      }
    }
  }
  return backup;
}

}  // namespace plumbline
