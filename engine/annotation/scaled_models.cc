// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/scaled_models.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "engine/models/model_texture.h"

namespace plumbline {

std::string ScaledModelName(const std::string& model, double scale) {
  return fmt::format("{}_x{:.4f}", model, scale);
}

UnscaledAnnotations WithScaledModels(const AnnotationDocument& document,
                                     const ModelDatabase* models) {
  UnscaledAnnotations result{document, nullptr};
  const bool any = std::any_of(document.instances.begin(), document.instances.end(),
                               [](const auto& instance) { return instance.scale != 1; });
  if (models == nullptr || !any) return result;
  std::vector<CadModel> all = models->models();
  for (AnnotatedInstance& instance : result.document.instances) {
    const auto id = models->Find(instance.model);
    if (instance.scale == 1 || !id) continue;
    const std::string name = ScaledModelName(instance.model, instance.scale);
    const bool known = std::any_of(all.begin(), all.end(),
                                   [&](const CadModel& model) { return model.name == name; });
    if (!known) {
      CadModel scaled = Scaled(models->model(*id), instance.scale);
      scaled.id = ModelId{static_cast<int>(all.size())};
      scaled.name = name;
      const std::filesystem::path file = scaled.file;
      scaled.file = (file.parent_path() / (name + file.extension().string())).string();
      all.push_back(std::move(scaled));
    }
    instance.model = name;
    instance.scale = 1;
  }
  if (all.size() == models->models().size()) return result;
  // The new database has no folder that files could be relative to.
  for (CadModel& model : all) {
    if (const auto texture = TextureOf(*models, model); !texture.empty())
      model.mesh.texture_file = std::filesystem::absolute(texture).string();
  }
  result.models = ModelDatabase::FromModels(std::move(all));
  return result;
}

void TakeScalesFromNames(const ModelDatabase& models, std::vector<AnnotatedInstance>& instances) {
  for (AnnotatedInstance& instance : instances) {
    const std::size_t at = instance.model.rfind("_x");
    if (at == std::string::npos || models.Find(instance.model)) continue;
    const auto id = models.Find(instance.model.substr(0, at));
    const char *first = instance.model.data() + at + 2,
               *last = instance.model.data() + instance.model.size();
    double scale = 0;
    const auto [end, error] = std::from_chars(first, last, scale, std::chars_format::fixed);
    if (!id || error != std::errc() || end != last || !(scale > 0)) continue;
    instance.model = models.model(*id).name;
    instance.category = models.model(*id).category;
    instance.scale = scale;
  }
}

}  // namespace plumbline
