// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/annotation/annotation_edit.h"
#include "engine/base/random.h"

namespace plumbline {

AnnotatedInstance RandomInstance(const std::string& id, Random& random);

Crop RandomCrop(const std::string& id, Random& random);

/// An edit that fits the document: all kinds, groups included. The same for the same document and
/// state of `random`.
Edit RandomEdit(const AnnotationDocument& document, Random& random);

}  // namespace plumbline
