// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/annotation/annotation_export.h"

namespace plumbline {

/// An export that was written beside its place, so that people can see what it would replace there
/// before it does. What is not taken leaves nothing behind.
class StagedExport {
 public:
  /// Errors: as of ExportAnnotation.
  static Result<std::unique_ptr<StagedExport>> Write(const AnnotationDocument& document,
                                                     const ExchangeInputs& inputs,
                                                     const std::filesystem::path& scan_file,
                                                     const ExportRequest& request,
                                                     const WorkContext& work);
  ~StagedExport();
  StagedExport(const StagedExport&) = delete;
  StagedExport& operator=(const StagedExport&) = delete;

  const std::filesystem::path& out() const { return out_; }
  /// Files that are there and would become other ones.
  bool replaces() const { return !replaced_.empty(); }
  /// What is there and what would be, as sentences; the objects of a ground truth one by one.
  std::vector<std::string> Differences() const;
  /// Puts it into its place. Files that become other ones are kept first, under `OUT.bak`, or
  /// `OUT.bak-2` and so on.
  /// @return Where they are kept; empty: nothing was replaced.
  /// Errors: kIo; then what is there is as it was, or kept.
  Result<std::filesystem::path> Take();

 private:
  StagedExport(std::filesystem::path out, std::filesystem::path folder)
      : out_(std::move(out)), folder_(std::move(folder)) {}
  void Compare();
  std::filesystem::path FreeBackup() const;

  std::filesystem::path out_, folder_;  ///< `folder_`: where it waits.
  bool is_folder_ = false;
  // Relative to `out_` if that is a folder; else the one name is "".
  std::vector<std::filesystem::path> added_, replaced_, same_;
};

/// How the objects of two ground truths of the same scan differ, as sentences.
std::vector<std::string> TruthDifferences(const std::filesystem::path& before,
                                          const std::filesystem::path& after);

}  // namespace plumbline
