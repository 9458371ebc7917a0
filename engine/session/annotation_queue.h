// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/annotation/annotation_document.h"
#include "engine/base/result.h"
#include "engine/snapshot/annotation_queue_view.h"

namespace plumbline {

/// What a project says of its work; name and path stay.
void DescribeWork(const AnnotationDocument& document, QueueEntry& entry);

/// The scans of a folder and of its subfolders (one level) and all projects over them, by name;
/// scans that nobody has begun stand for themselves. Folders of models, hidden ones and those of an
/// export are passed over. Edits that are only in a journal count. Errors: kNotFound, kIo.
Result<std::vector<QueueEntry>> ReadQueue(const std::filesystem::path& folder);

/// Whether a folder holds scans or projects, and is not a sequence itself.
bool IsQueue(const std::filesystem::path& folder);

/// Which one to open first: what is in work, else new, else to review, else the first of all.
/// Nothing of an empty queue.
std::optional<std::size_t> FirstToDo(const std::vector<QueueEntry>& entries);

}  // namespace plumbline
