// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "engine/annotation/annotation_document.h"
#include "engine/annotation/occluders.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// The models of a database made ready for outlines when they are first asked for, and the scan.
/// Not thread-safe; what it returns is.
class OutlineScene {
 public:
  /// @param scan  May be null.
  OutlineScene(std::shared_ptr<const ModelDatabase> models,
               std::shared_ptr<const OccludingScan> scan)
      : models_(std::move(models)), scan_(std::move(scan)) {}

  /// Errors: kNotFound (no such model), kDegenerate (it has no triangles), naming it.
  Result<std::shared_ptr<const OutlineModel>> Model(const std::string& name, double scale = 1);
  /// The scan and all instances of the document but `id`; those without a model hide nothing.
  Occluders OccludersOf(const AnnotationDocument& document, const std::string& id);

 private:
  std::shared_ptr<const ModelDatabase> models_;
  std::shared_ptr<const OccludingScan> scan_;
  std::map<std::pair<std::string, double>, std::shared_ptr<const OutlineModel>> prepared_;
};

}  // namespace plumbline
