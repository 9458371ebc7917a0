// SPDX-License-Identifier: Apache-2.0
#include "app/report/run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "app/report/html_page.h"
#include "app/report/svg_plot.h"
#include "engine/analysis/missed_truths.h"
#include "engine/analysis/object_looks.h"
#include "engine/analysis/object_spread.h"
#include "engine/analysis/reliability.h"
#include "engine/geometry/angle_text.h"
#include "engine/geometry/gravity.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr int kPictureWidth = 640;

std::string Card(const std::string& value, const std::string& name) {
  return fmt::format("<div class='card'><b>{}</b><span>{}</span></div>", Escaped(value),
                     Escaped(name));
}

std::string Dot(const std::string& color) {
  return fmt::format("<span class='dot' style='background:{}'></span>", color);
}

ObjectLook LookOf(const ObjectLooks& looks, ObjectId id) {
  const auto look = looks.find(id);
  return look != looks.end() ? look->second : ObjectLook();
}

std::string Dot(const ObjectLooks& looks, ObjectId id) {
  const ObjectLook look = LookOf(looks, id);
  const std::string color = SvgColor(ColorOf(look));
  return Dot(look.dashed ? "linear-gradient(135deg," + color + " 50%,#1c242c 50%)" : color);
}

std::string ModelName(const RunReview& review, ModelId label) {
  const auto index = static_cast<std::size_t>(label.value);
  return index < review.header.models.size() ? review.header.models[index].name : "?";
}

std::string Cards(const RunReview& review, const std::optional<MapEvaluation>& evaluation) {
  int confirmed = 0, skipped = 0;
  for (const ObjectReport& object : review.last->objects)
    confirmed += object.state == ObjectState::kConfirmed;
  for (const RunTiming& timing : review.timings) skipped += timing.skipped;
  const double seconds = review.timings.empty() ? 0 : review.timings.back().elapsed_s;
  const double frames = static_cast<double>(review.timings.size());
  std::string html =
      "<div class='cards'>" + Card(fmt::format("{}", frames), "frames") +
      Card(fmt::format("{}", skipped), "not used") +
      Card(fmt::format("{}", confirmed), "confirmed objects") +
      Card(seconds > 0 ? fmt::format("{:.1f}", frames / seconds) : "\u2013", "frames/s");
  if (evaluation) {
    const auto cm = [](std::optional<double> m) {
      return m ? fmt::format("{:.1f} cm", 100 * *m) : std::string("\u2013");
    };
    html += Card(fmt::format("{} / {} / {}", evaluation->matched.size(), evaluation->missed.size(),
                             evaluation->spurious.size()),
                 "matched / missed / spurious") +
            Card(cm(evaluation->mean_all.translation_m), "mean translation") +
            Card(evaluation->mean_all.rotation_rad
                     ? fmt::format("{:.1f}\u00b0", kDegPerRad * *evaluation->mean_all.rotation_rad)
                     : "\u2013",
                 "mean rotation") +
            Card(evaluation->surface.samples > 0 ? cm(evaluation->surface.mean_m) : "\u2013",
                 "surface, mean");
  }
  return html + "</div>";
}

std::string Pictures(const std::vector<ReportPicture>& pictures) {
  if (pictures.empty()) return "";
  std::string html = "<h2>What it saw</h2><div class='pictures'>";
  for (const ReportPicture& picture : pictures) {
    cv::Mat small = picture.image;
    if (small.cols > kPictureWidth)
      cv::resize(small, small, {kPictureWidth, small.rows * kPictureWidth / small.cols}, 0, 0,
                 cv::INTER_AREA);
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, 85});
    html += fmt::format(
        "<figure><img alt='frame {0}' src='data:image/jpeg;base64,{1}'><figcaption>Frame {0}: "
        "outlines of the mean states</figcaption></figure>",
        picture.frame, Base64(bytes));
  }
  return html + "</div>";
}

/// The map from above: footprints, true ones in green, the path of the camera.
std::string Plan(const RunReview& review, const ObjectLooks& looks) {
  const UprightFrame upright(-review.view.up_in_world);
  const auto flat = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector2d((upright.upright_rotation().transpose() * p).head<2>());
  };
  struct Shape {
    std::vector<Eigen::Vector2d> corners;
    std::string style, name;
    Eigen::Vector2d middle;
  };
  std::vector<Shape> shapes;
  Eigen::AlignedBox2d bounds;
  const auto footprint = [&](const ModelView& model, const Eigen::Isometry3d& pose, double scale,
                             std::string style, std::string name) {
    Shape shape{{}, std::move(style), std::move(name), flat(pose * (scale * model.center))};
    const Eigen::AlignedBox3d box = Scaled(BoundingBox(*model.mesh), scale);
    for (const auto& [x, y] : {std::pair(box.min().x(), box.min().y()),
                               {box.max().x(), box.min().y()},
                               {box.max().x(), box.max().y()},
                               {box.min().x(), box.max().y()}}) {
      shape.corners.push_back(flat(pose * Eigen::Vector3d(x, y, 0)));
      bounds.extend(shape.corners.back());
    }
    shapes.push_back(std::move(shape));
  };
  for (const SequenceView::Truth& truth : review.view.truth) {
    for (const ModelView& model : review.view.models) {
      if (model.name == truth.model && model.mesh != nullptr)
        footprint(model, truth.world_from_object, truth.scale,
                  "fill:none;stroke:#2f9e5b;stroke-width:2.5", "");
    }
  }
  for (const ObjectReport& object : review.last->objects) {
    const auto label = static_cast<std::size_t>(object.label.value);
    if (object.state != ObjectState::kConfirmed || label >= review.view.models.size()) continue;
    const ObjectLook look = LookOf(looks, object.id);
    const std::string color = SvgColor(ColorOf(look));
    footprint(review.view.models[label], object.world_from_object, object.scale,
              fmt::format("fill:{0};fill-opacity:.25;stroke:{0};stroke-width:1.5{1}", color,
                          look.dashed ? ";stroke-dasharray:6 4" : ""),
              fmt::format("#{} {}", object.id.value, review.view.models[label].name));
  }
  std::vector<Eigen::Vector2d> path;
  for (const Eigen::Isometry3d& pose : review.view.world_from_cam) {
    path.push_back(flat(pose.translation()));
    bounds.extend(path.back());
  }
  if (bounds.isEmpty()) return "";
  constexpr double kWidth = 860, kMargin = 30;
  const double scale = std::min(130.0, (kWidth - 2 * kMargin) / std::max(0.5, bounds.sizes().x()));
  const double height = scale * bounds.sizes().y() + 2 * kMargin;
  const double left = 0.5 * (kWidth - scale * bounds.sizes().x());
  const auto at = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(left + scale * (p.x() - bounds.min().x()),
                           height - kMargin - scale * (p.y() - bounds.min().y()));
  };
  const auto points = [&](const std::vector<Eigen::Vector2d>& corners) {
    std::string text;
    for (const Eigen::Vector2d& corner : corners)
      text += fmt::format("{:.1f},{:.1f} ", at(corner).x(), at(corner).y());
    return text;
  };
  std::string svg = fmt::format(
      "<svg viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' height='{1:.0f}' "
      "role='img' aria-label='The map from above'>",
      kWidth, height);
  svg += fmt::format("<polyline points='{}' fill='none' stroke='#e08a2c' stroke-width='1.5'/>",
                     points(path));
  for (const Shape& shape : shapes)
    svg += fmt::format("<polygon points='{}' style='{}'/>", points(shape.corners), shape.style);
  for (const Shape& shape : shapes) {
    if (shape.name.empty()) continue;
    svg += fmt::format(
        "<text x='{:.1f}' y='{:.1f}' text-anchor='middle' style='fill:#1c242c'>{}"
        "</text>",
        at(shape.middle).x(), at(shape.middle).y() + 4, Escaped(shape.name));
  }
  svg += fmt::format(
      "<line x1='14' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}' stroke='#66727e' "
      "stroke-width='2'/><text x='14' y='{:.1f}'>1 m</text></svg>",
      14 + scale, height - 10, height - 10, height - 16);
  return "<h2>The map from above</h2>" + svg +
         "<p class='legend'><span style='color:#e08a2c'>path of the camera</span>" +
         (review.view.truth.empty() ? "" : "<span class='good'>ground truth</span>") + "</p>";
}

std::string ObjectTable(const RunReview& review, const ObjectLooks& looks) {
  const UprightFrame upright(-review.view.up_in_world);
  std::map<int, TruthError> errors;
  for (auto frame = review.history.frames.rbegin(); frame != review.history.frames.rend();
       ++frame) {
    if ((*frame)->skipped) continue;
    for (const ObjectSample& sample : (*frame)->objects) {
      if (sample.error) errors.emplace(sample.id.value, *sample.error);
    }
    break;
  }
  std::string html =
      "<h2>Objects in the last frame</h2><div class='scroll'><table><tr><th>object</th>"
      "<th class='l'>model</th><th class='l'>state</th><th>x, y, z [m]</th><th>azimuth</th>"
      "<th>\u00b1 position</th><th>\u00b1 azimuth</th><th>shape</th><th>confirmed</th>"
      "<th class='l'>true object</th><th>off</th></tr>";
  for (const ObjectReport& o : review.last->objects) {
    const Eigen::Vector3d p = o.world_from_object.translation();
    const auto error = errors.find(o.id.value);
    const bool has_error = error != errors.end();
    const ObjectSpread spread = SpreadOf(o, review.view);
    html += fmt::format(
        "<tr><td>{}#{}</td><td class='l'>{}</td><td class='l'>{}</td><td>{:.2f} {:.2f} {:.2f}</td>"
        "<td>{}</td><td>{:.1f} cm{}</td><td>{}</td><td>{:.0f} %</td><td>{}</td>"
        "<td class='l'>{}</td><td>{}</td></tr>",
        Dot(looks, o.id), o.id.value, Escaped(ModelName(review, o.label)), NameOf(o.state), p.x(),
        p.y(), p.z(),
        spread.azimuth_std_rad ? AngleText(upright.Azimuth(o.world_from_object.linear())) : "round",
        100 * spread.position_std_m,
        spread.modes > 1 ? fmt::format(" ({} modes)", spread.modes) : "",
        spread.azimuth_std_rad ? fmt::format("{:.1f}\u00b0", kDegPerRad * *spread.azimuth_std_rad)
                               : "",
        o.label_probability.empty() ? 0 : 100 * o.label_probability.front().probability,
        o.confirmed_frame ? fmt::format("frame {}", *o.confirmed_frame) : "",
        has_error ? Escaped(error->second.truth) : "",
        has_error ? fmt::format("{:.1f} cm", 100 * error->second.translation_m) +
                        (spread.azimuth_std_rad
                             ? fmt::format(", {:.1f}\u00b0", kDegPerRad * error->second.azimuth_rad)
                             : "")
                  : "");
  }
  return html + "</table></div>";
}

std::string EvaluationTable(const MapEvaluation& e, const TruthsView& truths) {
  std::string html =
      "<h2>Against ground truth</h2><div class='scroll'><table><tr><th>object</th>"
      "<th class='l'>model</th><th class='l'>ground truth</th><th>translation</th><th>centre</th>"
      "<th>rotation</th><th>height</th><th>surface, mean</th></tr>";
  for (const MatchedObject& o : e.matched) {
    html += fmt::format(
        "<tr><td>#{}</td><td class='l'>{}{}</td><td class='l'>{}{}</td><td>{:.1f} cm</td>"
        "<td>{:.1f} cm</td><td>{}</td><td>{:+.1f} cm</td><td>{:.2f} cm</td></tr>",
        Escaped(o.estimate.id), Escaped(o.estimate.model),
        o.model_correct ? "" : " <span class='bad'>wrong model</span>", Escaped(o.truth.id),
        o.truth.fine ? "" : " (coarse)", 100 * o.pose.translation_m, 100 * o.centre_m,
        o.continuous_symmetry ? "round"
                              : fmt::format("{:.1f}\u00b0", kDegPerRad * o.pose.rotation_rad),
        100 * o.pose.height_m, 100 * o.surface.mean_m);
  }
  for (const SpuriousObject& o : e.spurious)
    html += fmt::format(
        "<tr><td>#{}</td><td class='l'>{}</td><td class='l bad'>spurious</td>"
        "<td></td><td></td><td></td><td></td><td>{:.2f} cm</td></tr>",
        Escaped(o.estimate.id), Escaped(o.estimate.model), 100 * o.surface.mean_m);
  for (const GroundTruthInstance& o : e.missed) {
    const TruthView* truth = FindTruth(truths, o.id);
    html += fmt::format(
        "<tr><td class='bad'>missed</td><td class='l'>{}</td><td class='l'>{}</td>"
        "<td class='l' colspan='5'>{}</td></tr>",
        Escaped(o.model), Escaped(o.id), truth != nullptr ? Escaped(truth->text) : "");
  }
  return html + "</table></div>";
}

std::string ReliabilityOfRun(const RunReview& review) {
  const Reliability c = ReliabilityOf(review.history).all;
  if (c.poses == 0) return "";
  return fmt::format(
      "<p>Over the run, the truth lay in the 50 % region of the belief in <b>{:.0f} %</b> and in "
      "the 95 % region in <b>{:.0f} %</b> of {} poses of confirmed objects; NEES {:.1f}, where 4 "
      "is "
      "honest.{}</p>",
      100.0 * c.within_50 / c.poses, 100.0 * c.within_95 / c.poses, c.poses, c.nees,
      c.labels.count == 0
          ? ""
          : fmt::format(
                " Where a category has several models, the most likely one was the true one "
                "in <b>{:.0f} %</b>, and believed at {:.0f} % on average.",
                100.0 * c.labels.right / c.labels.count, 100 * c.labels.claimed / c.labels.count));
}

/// One line for each object that was ever confirmed.
std::string ObjectPlot(const RunReview& review, const ObjectLooks& looks, const SvgPlot& plot,
                       double (*value)(const ObjectSample& sample)) {
  std::map<int, SvgSeries> lines;
  for (const ObjectTrack& track : review.tracks) {
    if (!track.confirmed_frame) continue;
    const ObjectLook look = LookOf(looks, track.id);
    SvgSeries& line = lines[track.id.value];
    line.name = fmt::format("#{} {}", track.id.value, ModelName(review, track.label));
    line.color = SvgColor(ColorOf(look));
    line.dashed = look.dashed;
  }
  for (const auto& frame : review.history.frames) {
    for (auto& [id, line] : lines) {
      double y = kNothing;
      for (const ObjectSample& sample : frame->objects) {
        if (sample.id.value == id) y = value(sample);
      }
      line.x.push_back(frame->frame);
      line.y.push_back(y);
    }
  }
  std::vector<SvgSeries> series;
  bool any = false;
  for (auto& [id, line] : lines) {
    any = any || std::any_of(line.y.begin(), line.y.end(), [](double y) { return y == y; });
    series.push_back(std::move(line));
  }
  return any ? SvgLines(plot, series) : "";
}

std::string Plots(const RunReview& review, const ObjectLooks& looks) {
  std::string html = "<h2>Over the run</h2>";
  html += ObjectPlot(review, looks, {"Error of position", "frame", "cm", 860, 220, 50},
                     [](const ObjectSample& s) -> double {
                       return s.error ? 100 * s.error->translation_m : kNothing;
                     });
  html += ObjectPlot(review, looks, {"Error of azimuth", "frame", "\u00b0", 860, 220, 45},
                     [](const ObjectSample& s) -> double {
                       return s.error && !s.round ? kDegPerRad * s.error->azimuth_rad : kNothing;
                     });
  html += ObjectPlot(review, looks, {"Spread of position", "frame", "cm", 860, 220, 20},
                     [](const ObjectSample& s) -> double { return 100 * s.position_std_m; });
  html += ObjectPlot(
      review, looks, {"Probability of the most likely shape", "frame", "%", 860, 180, 100},
      [](const ObjectSample& s) -> double {
        return s.label_probability.empty() ? kNothing
                                           : 100 * s.label_probability.front().probability;
      });
  html += "<p class='legend'>";
  for (const ObjectTrack& track : review.tracks) {
    if (track.confirmed_frame)
      html += fmt::format("<span>{}#{} {}</span>", Dot(looks, track.id), track.id.value,
                          Escaped(ModelName(review, track.label)));
  }
  return html + "</p>";
}

std::string Cost(const RunReview& review) {
  std::vector<SvgSeries> stages;
  for (const RunTiming& frame : review.timings) {
    for (const StageTiming& stage : frame.stages) {
      const bool known = std::any_of(stages.begin(), stages.end(),
                                     [&](const SvgSeries& s) { return s.name == stage.stage; });
      if (!known) stages.push_back({stage.stage, SvgColor(static_cast<int>(stages.size()) + 1)});
    }
  }
  std::vector<double> totals;
  for (SvgSeries& stage : stages) {
    for (const RunTiming& frame : review.timings) {
      double ms = 0;
      for (const StageTiming& timing : frame.stages) {
        if (timing.stage == stage.name) ms = timing.milliseconds;
      }
      stage.x.push_back(frame.frame);
      stage.y.push_back(ms);
    }
  }
  for (std::size_t i = 0; i < review.timings.size(); ++i) {
    double sum = 0;
    for (const SvgSeries& stage : stages) sum += stage.y[i];
    totals.push_back(sum);
  }
  if (totals.empty()) return "";
  const auto part = [](std::vector<double> values, double share) {
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
  };
  std::string html = "<h2>What it cost</h2>" +
                     SvgStack({"Time of each stage", "frame", "ms", 860, 240,
                               NiceCeiling(1.2 * part(totals, 0.98))},
                              stages) +
                     "<div class='scroll'><table><tr><th>stage</th><th>mean</th><th>median</th>"
                     "<th>95 % below</th><th>most</th></tr>";
  const auto row = [&](const std::string& name, const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v;
    html += fmt::format(
        "<tr><td>{}</td><td>{:.2f} ms</td><td>{:.2f} ms</td><td>{:.2f} ms</td>"
        "<td>{:.1f} ms</td></tr>",
        name, sum / static_cast<double>(values.size()), part(values, 0.5), part(values, 0.95),
        *std::max_element(values.begin(), values.end()));
  };
  for (std::size_t i = 0; i < stages.size(); ++i)
    row(Dot(stages[i].color) + Escaped(stages[i].name), stages[i].y);
  row("<b>all</b>", totals);
  return html + "</table></div>";
}

std::string Appendix(const RunReview& review) {
  std::string events;
  for (const RunEvent& event : review.events)
    events += fmt::format(
        "<tr><td>{}</td><td class='l'>{}</td><td class='l'>{}</td></tr>", event.frame,
        event.event.object.value > 0
            ? fmt::format("#{} {}", event.event.object.value, InWords(NameOf(event.event.kind)))
            : InWords(NameOf(event.event.kind)),
        Escaped(event.event.text));
  const RunHeader& h = review.header;
  const RunRecipe& recipe = h.recipe;
  const auto row = [](const char* name, const std::string& value) {
    return fmt::format("<tr><td>{}</td><td class='l'>{}</td></tr>", name, Escaped(value));
  };
  return "<h2>How it was made</h2><div class='scroll'><table>" +
         row("sequence", recipe.sequence.string()) + row("models", recipe.models.string()) +
         row("edges", ToText(recipe.edges.value_or(EdgeChoice()))) +
         row("detector", ToText(recipe.detector.value_or(DetectorChoice()))) +
         row("poses", ToText(recipe.poses)) + row("seed", fmt::format("{}", recipe.seed)) +
         row("pace", recipe.live_speed
                         ? fmt::format("live, speed {:g}: frames that came while the mapper was "
                                       "busy were passed over",
                                       *recipe.live_speed)
                         : "every frame") +
         row("program", h.program_version) + row("started", h.started) + "</table></div>" +
         fmt::format("<details><summary>Options</summary><pre>{}</pre></details>",
                     Escaped(OptionsToJson(recipe.options).dump(1))) +
         fmt::format(
             "<details><summary>{} events</summary><table><tr><th>frame</th>"
             "<th class='l'>what</th><th class='l'>why</th></tr>{}</table></details>",
             review.events.size(), events);
}

}  // namespace

cv::Mat OutlinedImage(const MapSnapshot& snapshot, const SequenceView& view,
                      const ObjectLooks& looks) {
  cv::Mat picture = snapshot.image.clone();
  if (picture.empty()) return picture;
  const auto shown = [&](ObjectId id) -> const ObjectReport* {
    for (const ObjectReport& object : snapshot.report.objects) {
      if (object.id == id) return &object;
    }
    return nullptr;
  };
  for (const OutlineView& outline : snapshot.outlines) {
    const ObjectReport* object = shown(outline.object);
    if (object == nullptr) continue;
    const bool confirmed = object->state == ObjectState::kConfirmed;
    const LookColor rgb = ColorOf(LookOf(looks, outline.object));
    const cv::Scalar color(rgb.blue, rgb.green, rgb.red);
    for (const auto& contour : outline.contours) {
      std::vector<cv::Point> points;
      for (const Eigen::Vector2f& p : contour) points.emplace_back(cvRound(p.x()), cvRound(p.y()));
      if (confirmed) cv::polylines(picture, points, true, {255, 255, 255}, 5, cv::LINE_AA);
      cv::polylines(picture, points, true, color, confirmed ? 3 : 1, cv::LINE_AA);
    }
    const auto label = static_cast<std::size_t>(object->label.value);
    if (!confirmed || object->visible_box.empty() || label >= view.models.size()) continue;
    const std::string name = fmt::format("#{} {}", object->id.value, view.models[label].name);
    const cv::Size size = cv::getTextSize(name, cv::FONT_HERSHEY_SIMPLEX, 0.6, 2, nullptr);
    const cv::Point at(cvRound(object->visible_box.center_x()) - size.width / 2,
                       cvRound(object->visible_box.center_y()));
    cv::rectangle(picture, at + cv::Point(-5, 6), at + cv::Point(size.width + 5, -size.height - 6),
                  {30, 26, 22}, cv::FILLED);
    cv::putText(picture, name, at, cv::FONT_HERSHEY_SIMPLEX, 0.6, {255, 255, 255}, 1, cv::LINE_AA);
  }
  return picture;
}

std::string RunReportHtml(const RunReview& review, const std::vector<ReportPicture>& pictures,
                          const std::optional<MapEvaluation>& evaluation, const std::string& name) {
  const ObjectLooks looks = LooksOf(review);
  std::string body = Cards(review, evaluation) + Pictures(pictures) + Plan(review, looks) +
                     ObjectTable(review, looks);
  if (evaluation) body += EvaluationTable(*evaluation, TruthsOf(review));
  body += ReliabilityOfRun(review) + Plots(review, looks) + Cost(review) + Appendix(review);
  return HtmlPage(
      name, "A run of Plumbline " + review.header.program_version + " over " + review.view.name,
      body);
}

}  // namespace plumbline
