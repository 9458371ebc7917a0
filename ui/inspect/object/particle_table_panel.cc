// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/particle_table_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/geometry/angle_text.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/framework/table_heads.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

struct ParticleColumn {
  const char* name;
  const char* help;
  double (*value)(const Particle& particle);  ///< Null: index or rank.
};
constexpr ParticleColumn kParticleColumns[] = {
    {"#", "Index among the object's particles.", nullptr},
    {"Rank", "1 is the best: by weight times what this frame says of it.", nullptr},
    {"Weight", "Share of the posterior, in thousandths.",
     [](const Particle& p) { return 1000 * std::exp(double{p.log_weight}); }},
    {"\u03a6 det", "Detector term.", [](const Particle& p) { return double{p.phi_cnn}; }},
    {"\u03a6 edge", "Edge term.", [](const Particle& p) { return double{p.phi_edge}; }},
    {"Distance", "Depth in the reference camera [m].",
     [](const Particle& p) { return std::exp(double{p.rho}); }},
    {"x", "Bearing to the right, X/Z.", [](const Particle& p) { return double{p.x_c}; }},
    {"y", "Bearing down, Y/Z.", [](const Particle& p) { return double{p.y_c}; }},
    {"Azimuth", "About up.", [](const Particle& p) { return kDegPerRad * p.azimuth; }},
    {"Model", "Its shape.", [](const Particle& p) { return double(p.label); }},
    {"From", "The particle of the last updated frame that it comes from.",
     [](const Particle& p) { return double(p.ancestor); }},
};

constexpr int kRank = 1, kWeight = 2;

class ParticleTablePanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const ObjectReport* object = context.SelectedObject();
    if (object == nullptr || object->particles == nullptr)
      return EmptyState(context, "No particles",
                        "Select an object in the list, in an image or in the map.");
    ImGui::PushFont(context.fonts.small);
    constexpr auto kFlags = ImGuiTableFlags_Sortable | ImGuiTableFlags_ScrollY |
                            ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;
    if (ImGui::BeginTable("particle_table", static_cast<int>(std::size(kParticleColumns)), kFlags,
                          ImGui::GetContentRegionAvail())) {
      std::vector<TableHead> heads;
      for (const ParticleColumn& column : kParticleColumns) {
        const bool first = &column == &kParticleColumns[kWeight];
        heads.push_back({column.name, column.help,
                         ImGuiTableColumnFlags_PreferSortDescending |
                             (first ? ImGuiTableColumnFlags_DefaultSort : 0),
                         0, colors::kText});
      }
      DrawTableHeads(context, heads, "particle_table.column");
      Sort(context, *object);
      DrawRows(context, *object, sink);
      ImGui::EndTable();
    }
    ImGui::PopFont();
  }

 private:
  void Sort(const FrameContext& context, const ObjectReport& object) {
    ImGuiTableSortSpecs* specs = ImGui::TableGetSortSpecs();
    const auto& particles = *object.particles;
    const bool same = version_ == context.snapshot_version && object_ == object.id &&
                      analysis_ == context.analysis && order_.size() == particles.size();
    if (same && (specs == nullptr || !specs->SpecsDirty)) return;
    version_ = context.snapshot_version;
    object_ = object.id;
    analysis_ = context.analysis;
    order_.resize(particles.size());
    std::iota(order_.begin(), order_.end(), 0);
    RankParticles(context, particles);
    if (specs == nullptr || specs->SpecsCount == 0) return;
    specs->SpecsDirty = false;
    const ParticleColumn& column = kParticleColumns[specs->Specs[0].ColumnIndex];
    const bool rises = specs->Specs[0].SortDirection == ImGuiSortDirection_Ascending;
    const auto key = [&](int i) { return Value(column, particles, i); };
    std::stable_sort(order_.begin(), order_.end(),
                     [&](int a, int b) { return rises ? key(a) < key(b) : key(a) > key(b); });
  }

  void RankParticles(const FrameContext& context, const std::vector<Particle>& particles) {
    rank_.assign(particles.size(), 0);
    const std::vector<int>* order = context.ParticlesByRank();
    if (order == nullptr || order->size() != particles.size()) return;  // it is on its way
    int rank = 0;
    for (const int index : *order) rank_[static_cast<std::size_t>(index)] = ++rank;
  }

  double Value(const ParticleColumn& column, const std::vector<Particle>& particles,
               int index) const {
    const auto i = static_cast<std::size_t>(index);
    if (column.value != nullptr) return column.value(particles[i]);
    return &column == &kParticleColumns[kRank] ? rank_[i] : index;
  }

  void DrawRows(const FrameContext& context, const ObjectReport& object, CommandSink& sink) const {
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(order_.size()));
    while (clipper.Step()) {
      for (int row = clipper.DisplayStart; row < clipper.DisplayEnd; ++row) {
        const int index = order_[static_cast<std::size_t>(row)];
        const Particle& particle = (*object.particles)[static_cast<std::size_t>(index)];
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        if (ImGui::Selectable(fmt::format("{}##row", index).c_str(),
                              context.selection.particle == index,
                              ImGuiSelectableFlags_SpanAllColumns))
          sink.Post(SelectParticleCommand{context.selection.particle == index ? -1 : index});
        if (ImGui::IsItemHovered()) sink.Post(HoverParticleCommand{index});
        LogItem(context, fmt::format("particle_table.row.{}", row));
        for (std::size_t c = 1; c < std::size(kParticleColumns); ++c) {
          ImGui::TableNextColumn();
          const double value = Value(kParticleColumns[c], *object.particles, index);
          const ModelView* model = context.Model({particle.label});
          if (std::string_view(kParticleColumns[c].name) == "Model") {
            ImGui::TextUnformatted(model != nullptr ? model->name.c_str() : "?");
          } else if (std::string_view(kParticleColumns[c].name) == "Azimuth") {
            const bool round = model != nullptr && model->any_azimuth;
            ImGui::TextUnformatted(round ? "any" : AngleText(particle.azimuth, 1).c_str());
          } else if (c == kRank || std::string_view(kParticleColumns[c].name) == "From") {
            ImGui::Text("%.0f", value);
          } else {
            ImGui::TextUnformatted(NumberText(value, 2).c_str());
          }
        }
      }
    }
  }

  std::uint64_t version_ = 0;
  ObjectId object_;
  std::shared_ptr<const FrameAnalysis> analysis_;  ///< That the ranks are of.
  std::vector<int> order_, rank_;
};

}  // namespace

std::unique_ptr<Panel> MakeParticleTablePanel() { return std::make_unique<ParticleTablePanel>(); }

}  // namespace plumbline
