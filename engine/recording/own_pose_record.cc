// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/own_pose_record.h"

#include "engine/recording/frame_codec.h"

namespace plumbline {
namespace {

/// Files of other runs lack it, and nothing looks for it there: the format's version stays, that of
/// the recipe rose with `poses = vio`.
constexpr const char* kOwnPosesSchema =
    "DROP TABLE IF EXISTS own_poses;"
    "CREATE TABLE own_poses (frame INTEGER PRIMARY KEY, details BLOB NOT NULL)";

}  // namespace

Status StoreOwnPoses(sqlite::Database& database, const OwnPoses& poses) {
  Status status = database.Execute(kOwnPosesSchema);
  if (!status.ok()) return status;
  Result<sqlite::Statement> insert = database.Prepare("INSERT INTO own_poses VALUES (?1, ?2)");
  if (!insert) return insert.error();
  for (std::size_t i = 0; i < poses.frames.size(); ++i) {
    const std::string details = EncodeOwnPose(poses.frames[i]);
    insert->Bind(1, static_cast<std::int64_t>(i));
    insert->BindBlob(2, details);
    if (status = insert->Run(); !status.ok()) return status;
  }
  return {};
}

Result<std::shared_ptr<const OwnPoses>> LoadOwnPoses(sqlite::Database& database) {
  const Result<std::int64_t> present = database.QueryInteger(
      "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND name = 'own_poses'");
  if (!present) return present.error();
  if (*present == 0) return std::shared_ptr<const OwnPoses>();
  Result<sqlite::Statement> rows =
      database.Prepare("SELECT frame, details FROM own_poses ORDER BY frame");
  if (!rows) return rows.error();
  auto poses = std::make_shared<OwnPoses>();
  while (true) {
    const Result<bool> row = rows->Step();
    if (!row) return row.error();
    if (!*row) return std::shared_ptr<const OwnPoses>(std::move(poses));
    OwnPoseReport report;
    if (rows->Integer(0) != static_cast<std::int64_t>(poses->frames.size()) ||
        !DecodeOwnPose(rows->Blob(1), report).ok()) {
      return Error{ErrorCode::kCorrupt, "the poses of the visual-inertial filter in " +
                                            database.file().string() +
                                            " are damaged; repeat the run"};
    }
    poses->frames.push_back(std::move(report));
  }
}

}  // namespace plumbline
