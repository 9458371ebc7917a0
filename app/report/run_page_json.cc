// SPDX-License-Identifier: Apache-2.0
#include "app/report/run_page_json.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <opencv2/imgproc.hpp>

#include "app/report/html_page.h"
#include "app/report/svg_plot.h"
#include "engine/analysis/object_looks.h"
#include "engine/base/check.h"
#include "engine/base/files.h"

namespace plumbline {
namespace {

constexpr double kOutlineTolerance_px = 0.6;  ///< Of the page: less than one sees.
constexpr double kLeastOutlineArea_px2 = 6;
constexpr float kHalves = 2;  ///< Outlines are stored in halves of a pixel.

/// Short in JSON: so many digits behind the point, and never -0.
nlohmann::json Number(double value, int digits) {
  const double power = std::pow(10.0, digits);
  const double rounded = std::round(value * power) / power;
  if (!std::isfinite(rounded)) return nullptr;
  if (rounded == std::trunc(rounded) && std::abs(rounded) < 1e9)
    return static_cast<std::int64_t>(rounded);
  return rounded;
}

nlohmann::json Point(const Eigen::Vector3d& p) {
  return {Number(p.x(), 4), Number(p.y(), 4), Number(p.z(), 4)};
}

/// [x, y, z, w]
nlohmann::json Rotation(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return {Number(q.x(), 5), Number(q.y(), 5), Number(q.z(), 5), Number(q.w(), 5)};
}

nlohmann::json ErrorRow(const std::optional<TruthError>& error) {
  if (!error) return nullptr;
  return {error->truth, Number(error->translation_m, 4), Number(error->azimuth_rad, 4),
          error->model_correct ? 1 : 0};
}

nlohmann::json ModeRows(const ObjectReport& object) {
  nlohmann::json rows = nlohmann::json::array();
  if (object.modes.size() < 2) return rows;
  for (const PoseMode& mode : object.modes)
    rows.push_back({Number(mode.weight, 3), mode.label.value,
                    Point(mode.world_from_object.translation()), Rotation(mode.world_from_object),
                    Number(mode.position_std_m, 4), Number(mode.azimuth_std_rad, 4)});
  return rows;
}

nlohmann::json ObjectRow(const ObjectReport& object, const FrameSample& sample) {
  const auto known =
      std::find_if(sample.objects.begin(), sample.objects.end(),
                   [&](const ObjectSample& candidate) { return candidate.id == object.id; });
  PLB_CHECK(known != sample.objects.end()) << "object " << object.id.value << " has no sample";
  nlohmann::json labels = nlohmann::json::array();
  for (const LabelProbability& label : known->label_probability)
    labels.push_back({label.label.value, Number(label.probability, 3)});
  return {object.id.value,
          static_cast<int>(object.state),
          object.updated ? 1 : 0,
          object.label.value,
          std::move(labels),
          Point(object.world_from_object.translation()),
          Rotation(object.world_from_object),
          Number(object.scale, 4),
          Number(known->position_std_m, 4),
          Number(known->azimuth_std_rad, 4),
          Number(1 / (1 + std::exp(-object.log_evidence)), 4),
          Number(object.log_evidence, 2),
          Number(object.visible_fraction, 3),
          Number(object.phi_cnn, 3),
          Number(object.phi_edge, 3),
          ErrorRow(known->error),
          ModeRows(object)};
}

/// [id, contour, ..] of each outline; a contour is [x, y, dx, dy, ..].
nlohmann::json OutlineRows(std::span<const OutlineView> outlines, double page_from_image) {
  const auto scale = static_cast<float>(page_from_image);
  nlohmann::json rows = nlohmann::json::array();
  for (const OutlineView& outline : outlines) {
    nlohmann::json row = nlohmann::json::array({outline.object.value});
    for (const std::vector<Eigen::Vector2f>& contour : outline.contours) {
      std::vector<cv::Point2f> points, kept;
      for (const Eigen::Vector2f& p : contour)
        points.emplace_back(scale * (p.x() + 0.5f), scale * (p.y() + 0.5f));
      cv::approxPolyDP(points, kept, kOutlineTolerance_px, true);
      if (kept.size() < 3 || cv::contourArea(kept) < kLeastOutlineArea_px2) continue;
      nlohmann::json numbers = nlohmann::json::array();
      cv::Point before(0, 0);
      for (const cv::Point2f& p : kept) {
        const cv::Point now(cvRound(kHalves * p.x), cvRound(kHalves * p.y));
        numbers.push_back(now.x - before.x);
        numbers.push_back(now.y - before.y);
        before = now;
      }
      row.push_back(std::move(numbers));
    }
    if (row.size() > 1) rows.push_back(std::move(row));
  }
  return rows;
}

nlohmann::json BoxRows(const FrameReport& report, double page_from_image) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ProposalReport& proposal : report.proposals) {
    const auto at = [&](double pixel) { return Number(page_from_image * (pixel + 0.5), 0); };
    rows.push_back({at(proposal.box.x0), at(proposal.box.y0), at(proposal.box.x1),
                    at(proposal.box.y1), proposal.category, Number(proposal.score, 2),
                    static_cast<int>(proposal.fate), proposal.object.value});
  }
  return rows;
}

template <typename T>
std::string Bytes64(const std::vector<T>& values) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return Base64(bytes);
}

}  // namespace

nlohmann::json RunPageFields() {
  return {
      {"box", {"x0", "y0", "x1", "y1", "category", "score", "fate", "object"}},
      {"object",
       {"id", "state", "updated", "label", "labels", "position", "rotation", "scale", "positionStd",
        "azimuthStd", "there", "evidence", "visible", "detector", "edges", "error", "modes"}},
      {"mode", {"weight", "label", "position", "rotation", "positionStd", "azimuthStd"}},
      {"error", {"truth", "distance", "azimuth", "right"}}};
}

nlohmann::json RunPageFrame(const FrameReport& report, const FrameSample& sample,
                            std::span<const OutlineView> outlines,
                            std::span<const OutlineView> true_outlines, double page_from_image) {
  nlohmann::json frame = {{"frame", report.frame},
                          {"boxes", BoxRows(report, page_from_image)},
                          {"outlines", OutlineRows(outlines, page_from_image)}};
  if (!report.skipped.empty()) frame["skipped"] = report.skipped;
  if (report.world_from_cam) {
    frame["camera"] = Point(report.world_from_cam->translation());
    for (const nlohmann::json& number : Rotation(*report.world_from_cam))
      frame["camera"].push_back(number);
  }
  nlohmann::json objects = nlohmann::json::array();
  for (const ObjectReport& object : report.objects) objects.push_back(ObjectRow(object, sample));
  frame["objects"] = std::move(objects);
  if (!true_outlines.empty()) frame["truth"] = OutlineRows(true_outlines, page_from_image);
  return frame;
}

nlohmann::json RunPageMesh(const TriangleMesh& mesh) {
  PLB_CHECK(mesh.vertices.size() <= 65535) << mesh.vertices.size() << " vertices";
  const Eigen::AlignedBox3f box = BoundingBox(mesh);
  const auto corner = [](const Eigen::Vector3f& p) { return Point(p.cast<double>()); };
  const Eigen::Vector3f size = box.sizes().cwiseMax(1e-6f);
  std::vector<std::uint16_t> vertices, triangles;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const Eigen::Array3f share = (vertex - box.min()).array() / size.array();
    for (int k = 0; k < 3; ++k)
      vertices.push_back(static_cast<std::uint16_t>(std::lround(65535 * share[k])));
  }
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) triangles.push_back(static_cast<std::uint16_t>(triangle[k]));
  }
  nlohmann::json json = {{"vertices", Bytes64(vertices)},
                         {"min", corner(box.min())},
                         {"max", corner(box.min() + size)}};
  if (!triangles.empty()) json["triangles"] = Bytes64(triangles);
  if (mesh.colors.size() == mesh.vertices.size()) json["colors"] = Bytes64(mesh.colors);
  return json;
}

nlohmann::json RunPageObjects(const RunReview& review) {
  const ObjectLooks looks = LooksOf(review);
  nlohmann::json objects = nlohmann::json::array();
  for (const ObjectTrack& track : review.tracks) {
    const auto look = looks.find(track.id);
    const auto label = static_cast<std::size_t>(track.label.value);
    objects.push_back(
        {{"id", track.id.value},
         {"model", label < review.view.models.size() ? review.view.models[label].name : "?"},
         {"category", track.category},
         {"color", SvgColor(ColorOf(look != looks.end() ? look->second : ObjectLook()))},
         {"first", track.first_frame},
         {"last", track.last_frame},
         {"confirmed", track.confirmed_frame ? nlohmann::json(*track.confirmed_frame) : nullptr}});
  }
  return objects;
}

nlohmann::json RunPageEvents(const RunReview& review) {
  nlohmann::json events = nlohmann::json::array();
  for (const RunEvent& event : review.events)
    events.push_back({{"frame", event.frame},
                      {"kind", InWords(NameOf(event.event.kind))},
                      {"object", event.event.object.value},
                      {"text", event.event.text}});
  return events;
}

nlohmann::json RunPageTruth(const RunReview& review) {
  nlohmann::json list = nlohmann::json::array();
  for (const SequenceView::Truth& truth : review.view.truth) {
    const std::vector<ModelView>& models = review.view.models;
    const auto model = std::find_if(models.begin(), models.end(), [&](const ModelView& candidate) {
      return candidate.name == truth.model;
    });
    list.push_back({{"id", truth.id},
                    {"label", model == models.end() ? nlohmann::json(nullptr)
                                                    : nlohmann::json(model - models.begin())},
                    {"position", Point(truth.world_from_object.translation())},
                    {"rotation", Rotation(truth.world_from_object)},
                    {"scale", Number(truth.scale, 4)}});
  }
  return list;
}

std::string InScript(const nlohmann::json& json) {
  const std::string text = JsonText(json);
  std::string safe;
  safe.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    // The separators of lines U+2028 and U+2029 are E2 80 A8 and E2 80 A9.
    const bool separator = text.compare(i, 2, "\xE2\x80") == 0 && i + 2 < text.size() &&
                           (text[i + 2] == '\xA8' || text[i + 2] == '\xA9');
    if (text[i] == '<') {
      safe += "\\u003c";
    } else if (text[i] == '>') {
      safe += "\\u003e";
    } else if (separator) {
      safe += text[i + 2] == '\xA8' ? "\\u2028" : "\\u2029";
      i += 2;
    } else {
      safe += text[i];
    }
  }
  return safe;
}

}  // namespace plumbline
