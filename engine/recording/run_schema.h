// SPDX-License-Identifier: Apache-2.0
#pragma once

// What writer and reader of the run file must agree on; docs/run_file.md explains the tables.

namespace plumbline {

inline constexpr int kRunApplicationId = 0x504C4252;  // "PLBR", in SQLite's header
inline constexpr int kRunFormatVersion = 2;

/// Run inside one transaction, so that a file either is a run file or is empty.
inline constexpr const char* kRunSchema = R"(
PRAGMA application_id = 0x504C4252;
PRAGMA user_version = 2;
CREATE TABLE run (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE frames (
  position INTEGER PRIMARY KEY,
  frame INTEGER NOT NULL UNIQUE,
  stamp_ns INTEGER NOT NULL,
  skipped TEXT NOT NULL,
  num_objects INTEGER NOT NULL,
  elapsed_s REAL NOT NULL,
  details BLOB NOT NULL,
  thumbnail BLOB NOT NULL);
CREATE TABLE objects (
  position INTEGER NOT NULL,
  object INTEGER NOT NULL,
  state INTEGER NOT NULL,
  category TEXT NOT NULL,
  label INTEGER NOT NULL,
  confirmed_frame INTEGER,
  weighed INTEGER NOT NULL,
  details BLOB NOT NULL,
  particles_at INTEGER,
  particles BLOB,
  PRIMARY KEY (position, object));
CREATE INDEX objects_by_id ON objects (object, position, weighed);
CREATE TABLE events (
  position INTEGER NOT NULL,
  ordinal INTEGER NOT NULL,
  kind INTEGER NOT NULL,
  object INTEGER NOT NULL,
  other INTEGER NOT NULL,
  text TEXT NOT NULL,
  PRIMARY KEY (position, ordinal)) WITHOUT ROWID;
)";

}  // namespace plumbline
