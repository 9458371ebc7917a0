// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/own_pose_record.h"

#include <exception>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/json_text.h"
#include "engine/recording/frame_codec.h"

namespace plumbline {
namespace {

/// Files of other runs lack it, and nothing looks for it there: the format's version stays, that of
/// the recipe rose with `poses = vio`.
constexpr const char* kOwnPosesSchema =
    "DROP TABLE IF EXISTS own_poses;"
    "CREATE TABLE own_poses (frame INTEGER PRIMARY KEY, details BLOB NOT NULL);"
    "DROP TABLE IF EXISTS own_pose_loops;"
    "CREATE TABLE own_pose_loops (causal INTEGER NOT NULL, report TEXT NOT NULL);"
    "DROP TABLE IF EXISTS own_pose_moves;"
    "CREATE TABLE own_pose_moves (epoch INTEGER PRIMARY KEY, image INTEGER NOT NULL, moves "
    "BLOB NOT NULL)";

Result<bool> HasTable(sqlite::Database& database, const char* query) {
  const Result<std::int64_t> present = database.QueryInteger(query);
  if (!present) return present.error();
  return *present > 0;
}

Status StoreLoops(sqlite::Database& database, const OwnPoses& poses) {
  Result<sqlite::Statement> insert = database.Prepare("INSERT INTO own_pose_loops VALUES (?1, ?2)");
  if (!insert) return insert.error();
  const std::string report = ToJson(poses.loops).dump();
  insert->Bind(1, static_cast<std::int64_t>(poses.causal));
  insert->BindText(2, report);
  return insert->Run();
}

/// Runs of before loops were closed have none.
Status LoadLoops(sqlite::Database& database, OwnPoses& poses) {
  const Result<bool> present = HasTable(
      database,
      "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND name = 'own_pose_loops'");
  if (!present) return present.error();
  if (!*present) return {};
  const Result<std::int64_t> causal = database.QueryInteger("SELECT causal FROM own_pose_loops");
  if (!causal) return causal.error();
  const Result<std::string> report = database.QueryText("SELECT report FROM own_pose_loops");
  if (!report) return report.error();
  poses.causal = *causal != 0;
  try {  // damage may leave values of another type, or numbers that do not fit
    poses.loops = LoopReportFromJson(ParseJson(*report));
  } catch (const std::exception&) {
    return Error{ErrorCode::kCorrupt, "the closed loops in " + database.file().string() +
                                          " are damaged; repeat the run"};
  }
  return {};
}

Status StoreCorrections(sqlite::Database& database, const OwnPoses& poses) {
  Result<sqlite::Statement> insert =
      database.Prepare("INSERT OR REPLACE INTO own_pose_moves VALUES (?1, ?2, ?3)");
  if (!insert) return insert.error();
  for (const PastCorrection& correction : poses.corrections) {
    const std::string moved = EncodeMoves(correction);
    insert->Bind(1, static_cast<std::int64_t>(correction.epoch));
    insert->Bind(2, static_cast<std::int64_t>(correction.image));
    insert->BindBlob(3, moved);
    if (Status status = insert->Run(); !status.ok()) return status;
  }
  return {};
}

/// Runs of before maps were corrected have none.
Status LoadCorrections(sqlite::Database& database, OwnPoses& poses) {
  const Result<bool> present = HasTable(
      database,
      "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND name = 'own_pose_moves'");
  if (!present) return present.error();
  if (!*present) return {};
  Result<sqlite::Statement> rows =
      database.Prepare("SELECT epoch, image, moves FROM own_pose_moves ORDER BY epoch");
  if (!rows) return rows.error();
  while (true) {
    const Result<bool> row = rows->Step();
    if (!row) return row.error();
    if (!*row) return {};
    PastCorrection correction;
    correction.image = static_cast<int>(rows->Integer(1));
    correction.epoch = static_cast<int>(rows->Integer(0));
    const bool rises =
        poses.corrections.empty() || correction.image > poses.corrections.back().image;
    if (!rises || !DecodeMoves(rows->Blob(2), correction).ok()) {
      return Error{ErrorCode::kCorrupt, "the corrected poses in " + database.file().string() +
                                            " are damaged; repeat the run"};
    }
    poses.corrections.push_back(std::move(correction));
  }
}

/// @param first_image  Of the frames; 0 begins anew.
Status Store(sqlite::Database& database, std::size_t first_image, const OwnPoses& poses) {
  Status status =
      database.Execute(first_image == 0 ? kOwnPosesSchema : "DELETE FROM own_pose_loops");
  if (!status.ok()) return status;
  Result<sqlite::Statement> insert =
      database.Prepare("INSERT OR REPLACE INTO own_poses VALUES (?1, ?2)");
  if (!insert) return insert.error();
  for (std::size_t i = 0; i < poses.frames.size(); ++i) {
    const std::string details = EncodeOwnPose(poses.frames[i]);
    insert->Bind(1, static_cast<std::int64_t>(first_image + i));
    insert->BindBlob(2, details);
    if (status = insert->Run(); !status.ok()) return status;
  }
  if (status = StoreLoops(database, poses); !status.ok()) return status;
  return StoreCorrections(database, poses);
}

}  // namespace

Status StoreOwnPoses(sqlite::Database& database, const OwnPoses& poses) {
  return Store(database, 0, poses);
}

Status AddOwnPoses(sqlite::Database& database, const OwnPoseGrowth& growth) {
  return Store(database, growth.first_image, growth.poses);
}

Result<StoredOwnPoses> CountOwnPoses(sqlite::Database& database) {
  StoredOwnPoses stored;
  const Result<bool> present = HasTable(
      database, "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND name = 'own_poses'");
  if (!present) return present.error();
  if (!*present) return stored;
  for (const auto& [count, query] :
       {std::pair{&stored.images, "SELECT COUNT(*) FROM own_poses"},
        std::pair{&stored.corrections, "SELECT COUNT(*) FROM own_pose_moves"}}) {
    const Result<std::int64_t> found = database.QueryInteger(query);
    if (!found) return found.error();
    *count = static_cast<std::size_t>(*found);
  }
  return stored;
}

Result<std::shared_ptr<const OwnPoses>> LoadOwnPoses(sqlite::Database& database) {
  const Result<bool> present = HasTable(
      database, "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table' AND name = 'own_poses'");
  if (!present) return present.error();
  if (!*present) return std::shared_ptr<const OwnPoses>();
  Result<sqlite::Statement> rows =
      database.Prepare("SELECT frame, details FROM own_poses ORDER BY frame");
  if (!rows) return rows.error();
  auto poses = std::make_shared<OwnPoses>();
  while (true) {
    const Result<bool> row = rows->Step();
    if (!row) return row.error();
    if (!*row) {
      if (Status status = LoadLoops(database, *poses); !status.ok()) return status.error();
      if (Status status = LoadCorrections(database, *poses); !status.ok()) return status.error();
      return std::shared_ptr<const OwnPoses>(std::move(poses));
    }
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
