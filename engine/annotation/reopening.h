// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/annotation/annotation_edit.h"

namespace plumbline {

/// The edit, and where it changes what a project that is done says, that this is in work again; one
/// step to undo. What only the window or the bookkeeping knows changes nothing: hidden, locked and
/// time spent, the inputs' paths, pairs, the state itself, and findings that are accepted.
/// @param who  Who edits it; "": whoever handed it over.
Edit WithReopening(const Edit& edit, const AnnotationDocument& document, const std::string& who);

}  // namespace plumbline
