// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/annotation/annotation_document.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// Annotations of which every object is exactly as large as its model.
struct UnscaledAnnotations {
  AnnotationDocument document;
  std::shared_ptr<const ModelDatabase> models;  ///< Null: those that were given do for it.
};

/// Gives each scaled instance a model of its own size, `chair_x1.034`, which is added behind those
/// of the database: so whoever knows models and rigid poses alone sees it as large as it is.
/// Instances of one size share theirs. Without models, or where an instance's is unknown, the scale
/// stays.
UnscaledAnnotations WithScaledModels(const AnnotationDocument& document,
                                     const ModelDatabase* models);

/// What those models stand for, after they were read again: instances of a model that the database
/// does not have, but whose name is that of one it has and a scale, become scaled instances of it.
void TakeScalesFromNames(const ModelDatabase& models, std::vector<AnnotatedInstance>& instances);

/// How that model is called. It ends in the scale, to a ten-thousandth.
std::string ScaledModelName(const std::string& model, double scale);

}  // namespace plumbline
