// SPDX-License-Identifier: Apache-2.0
// Annotation projects, their journals, and the formats of others.
#include <array>

#include <nlohmann/json.hpp>

#include "engine/annotation/annotation_edit.h"
#include "engine/annotation/annotation_journal.h"
#include "engine/annotation/annotation_project.h"
#include "engine/annotation/bop_files.h"
#include "engine/annotation/pose_exchange.h"
#include "engine/base/files.h"
#include "tests/fuzz/fuzz_targets.h"

namespace plumbline::fuzz {
namespace {

Status Document(std::string_view input) {
  const auto json = ReadJson(FileOf("a.annotation.json", input));
  if (!json.ok()) return json.error();
  const auto document = DocumentFromJson(*json);
  if (!document.ok()) return document.error();
  return StatusOf(DocumentFromJson(DocumentToJson(*document)));  // what is written is read again
}

/// The edits of `annotate apply`, applied to an empty document.
Status Edits(std::string_view input) {
  const auto json = ReadJson(FileOf("edits.json", input));
  if (!json.ok()) return json.error();
  if (!json->is_array()) return InvalidInput("a list of edits begins with [");
  AnnotationDocument document;
  for (const auto& entry : *json) {
    const auto edit = EditFromJson(entry);
    if (!edit.ok()) return edit.error();
    (void)DescribeEdit(*edit);
    const auto undo = ApplyEdit(*edit, document);
    if (!undo.ok()) return undo.error();
    (void)EditToJson(*undo);
  }
  return StatusOf(DocumentFromJson(DocumentToJson(document)));
}

Status Journal(std::string_view input) {
  return StatusOf(ReadJournal(FileOf("a.json.journal", input)));
}

/// A project with what lies beside it, as `annotate` and the window open it: undo and redo, save.
Status Project(std::string_view input) {
  const auto folder = FolderOf(input);
  const auto file = folder / "a.annotation.json";
  (void)AnnotationProject::Open(file, AnnotationProject::Access::kRead);
  const auto opened = AnnotationProject::Open(file);
  if (!opened.ok()) return opened.error();
  AnnotationProject& project = **opened;
  while (project.UndoLabel()) {
    if (const Status undone = project.Undo(); !undone.ok()) return undone;
  }
  while (project.RedoLabel()) {
    if (const Status redone = project.Redo(); !redone.ok()) return redone;
  }
  return project.Save();
}

Status Bop(std::string_view input) { return StatusOf(ReadBop(FolderOf(input))); }

Status Visma(std::string_view input) { return StatusOf(ReadVisma(FolderOf(input))); }

Status LabelFusion(std::string_view input) {
  const auto folder = FolderOf(input);
  const auto sequence = OpenSequence(folder / "sequence");
  ExchangeInputs inputs;
  if (sequence.ok()) inputs.sequence = sequence->get();
  return StatusOf(ReadLabelFusion(AnnotationDocument(), inputs, folder));
}

Status FramePoses(std::string_view input) {
  const auto folder = FolderOf(input);
  const auto sequence = OpenSequence(folder / "sequence");
  ExchangeInputs inputs;
  if (sequence.ok()) inputs.sequence = sequence->get();
  return StatusOf(ReadFramePoses(AnnotationDocument(), inputs, folder / "poses.json"));
}

constexpr std::array kAnnotationTargets = {Target{"annotation_document", Document},
                                           Target{"annotation_edits", Edits},
                                           Target{"annotation_journal", Journal},
                                           Target{"annotation_project", Project},
                                           Target{"bop", Bop},
                                           Target{"visma", Visma},
                                           Target{"labelfusion", LabelFusion},
                                           Target{"frame_poses", FramePoses}};

}  // namespace

std::span<const Target> AnnotationTargets() { return kAnnotationTargets; }

}  // namespace plumbline::fuzz
