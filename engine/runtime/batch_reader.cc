// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/batch_reader.h"

#include "engine/batch/batch_results.h"
#include "engine/batch/batch_review.h"

namespace plumbline {

bool IsBatch(const std::filesystem::path& path) {
  std::error_code error;
  if (path.extension() == std::filesystem::path(kBatchResults).extension()) return true;
  return std::filesystem::is_regular_file(path / kBatchResults, error);
}

void BatchReader::Read(const std::filesystem::path& path) {
  (void)worker_.Do([this, path] {
    std::error_code error;
    auto shown = std::make_shared<ShownBatch>();
    shown->folder =
        std::filesystem::is_directory(path, error) ? path.string() : path.parent_path().string();
    auto table = ReadBatchResults(path);
    if (table.ok())
      shown->view = ReviewBatch(std::move(*table));
    else
      shown->problem = table.error().message;
    view_.Publish(std::move(shown));
    if (on_publish_) on_publish_();
  });
}

}  // namespace plumbline
