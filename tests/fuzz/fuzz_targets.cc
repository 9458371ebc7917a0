// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_targets.h"

#include <unistd.h>

#include <fstream>
#include <string>
#include <system_error>

#include "tests/fuzz/packed_files.h"

namespace plumbline::fuzz {
namespace {

/// Of this process, in memory where the system has such a place; gone at its end.
class Workplace {
 public:
  Workplace() {
    const std::filesystem::path memory = "/dev/shm";
    std::error_code none;
    const auto place = std::filesystem::is_directory(memory, none)
                           ? memory
                           : std::filesystem::temp_directory_path();
    folder_ = place / ("plumbline_fuzz." + std::to_string(getpid()));
  }
  ~Workplace() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;
  /// The same folder each time, with nothing in it.
  const std::filesystem::path& Emptied() const {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directory(folder_);
    return folder_;
  }

 private:
  std::filesystem::path folder_;
};

const std::filesystem::path& EmptyFolder() {
  static const Workplace kPlace;
  return kPlace.Emptied();
}

}  // namespace

std::vector<Target> Targets() {
  std::vector<Target> all;
  for (const std::span<const Target> some :
       {TextTargets(), DatasetTargets(), ModelTargets(), VisionTargets(), AnnotationTargets(),
        RunTargets(), BatchTargets(), NodeTargets(), SessionTargets(), WindowTargets()}) {
    all.insert(all.end(), some.begin(), some.end());
  }
#ifdef PLUMBLINE_FUZZ_PANELS
  for (const Target& target : PanelTargets()) all.push_back(target);
#endif
  return all;
}

std::filesystem::path FileOf(std::string_view name, std::string_view input) {
  const std::filesystem::path file = EmptyFolder() / name;
  std::ofstream(file, std::ios::binary) << input;
  return file;
}

std::filesystem::path FolderOf(std::string_view input) {
  const std::filesystem::path folder = EmptyFolder();
  for (const PackedFile& packed : SplitFiles(input)) {
    const std::filesystem::path file = folder / packed.name;
    std::error_code ignored;  // two names of which one is the folder of the other: the first counts
    std::filesystem::create_directories(file.parent_path(), ignored);
    std::ofstream(file, std::ios::binary) << packed.content;
  }
  return folder;
}

}  // namespace plumbline::fuzz
