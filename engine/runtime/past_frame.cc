// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/past_frame.h"

#include <utility>

namespace plumbline {

Result<std::shared_ptr<const MapSnapshot>> PastFrame(int position, RunReader& reader,
                                                     FramePictures& pictures,
                                                     SnapshotMemory& memory) {
  if (auto known = memory.Get(position)) return known;
  Result<FrameReport> report = reader.ReadFrame(position);
  if (!report.ok()) return report.error();
  const std::shared_ptr<MapSnapshot> snapshot = pictures.Make(std::move(report).value());
  if (snapshot->image.empty()) {
    if (auto thumbnail = reader.ReadThumbnail(position); thumbnail.ok())
      snapshot->image = *thumbnail;
  }
  memory.Put(position, snapshot);
  return std::shared_ptr<const MapSnapshot>(snapshot);
}

}  // namespace plumbline
