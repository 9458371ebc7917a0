// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/reliability.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include <nlohmann/json.hpp>

#include "engine/evaluation/honest_nees.h"
#include "engine/evaluation/precision_recall.h"
#include "engine/evaluation/truth_pairing.h"
#include "engine/snapshot/belief_tails.h"

namespace plumbline {
namespace {

using FrameList = std::span<const std::shared_ptr<const FrameSample>>;

bool NearTruth(const ObjectSample& object) {
  return object.error && object.error->translation_m <= kPairReach_m;
}

/// Adds poses up. The NEES is that of one object.
void Add(const ObjectSample& object, Reliability& sum) {
  const TruthError& error = *object.error;
  ++sum.poses;
  sum.within_50 += error.credible_level <= 0.5f;
  sum.within_95 += error.credible_level <= 0.95f;
  sum.nees +=
      (error.nees * 4 / static_cast<float>(error.degrees_of_freedom) - sum.nees) / sum.poses;
  if (error.several_models && !object.label_probability.empty())
    sum.labels.Add(object.label_probability.front().probability, error.model_correct);
}

void SetNees(int objects, const NeesInterval& honest, Reliability& of) {
  of.objects = objects;
  of.nees_low = honest.low;
  of.nees_high = honest.high;
}

RunReliability Judge(FrameList frames, bool updated_only) {
  Reliability all;
  std::map<int, Reliability> by_object;
  for (const auto& frame : frames) {
    if (frame == nullptr) continue;
    for (const ObjectSample& object : frame->objects) {
      if (object.state != ObjectState::kConfirmed || !NearTruth(object)) continue;
      if (updated_only && !object.updated) continue;
      Add(object, all);
      Add(object, by_object[object.id.value]);
    }
  }
  RunReliability result;
  all.nees = 0;
  if (!by_object.empty()) {
    const auto objects = static_cast<int>(by_object.size());
    SetNees(objects, HonestMeanNees(objects, kBeliefDegreesOfFreedom), all);
    static const NeesInterval of_one = HonestMeanNees(1, kBeliefDegreesOfFreedom);
    for (auto& [id, reliability] : by_object) {
      SetNees(1, of_one, reliability);
      all.nees += reliability.nees / objects;
      result.objects.push_back({ObjectId{id}, reliability});
    }
  }
  result.all = all;
  return result;
}

/// The newest frame that was not skipped, alone; empty without one.
FrameList LastFrame(const RunHistory& history) {
  for (std::size_t i = history.frames.size(); i-- > 0;) {
    if (history.frames[i] != nullptr && !history.frames[i]->skipped)
      return FrameList(history.frames).subspan(i, 1);
  }
  return {};
}

double ProbabilityOfBeing(const ObjectSample& object) {
  return 1 / (1 + std::exp(-static_cast<double>(object.log_evidence)));
}

nlohmann::json LabelsToJson(const LabelCalibration& labels) {
  nlohmann::json bins = nlohmann::json::array();
  for (std::size_t i = 0; i < labels.bins.size(); ++i) {
    const LabelCalibration::Bin& bin = labels.bins[i];
    if (bin.count == 0) continue;
    const auto width = 1 / static_cast<double>(labels.bins.size());
    bins.push_back({{"from", static_cast<double>(i) * width},
                    {"to", static_cast<double>(i + 1) * width},
                    {"count", bin.count},
                    {"claimed", bin.claimed / bin.count},
                    {"right", static_cast<double>(bin.right) / bin.count}});
  }
  const auto expected = labels.ExpectedError();
  return {{"count", labels.count},
          {"right", labels.right},
          {"claimed", labels.count > 0 ? nlohmann::json(labels.claimed / labels.count) : nullptr},
          {"expected_calibration_error", expected ? nlohmann::json(*expected) : nullptr},
          {"bins", std::move(bins)}};
}

nlohmann::json ToJson(const Reliability& of) {
  const auto share = [&](int count) {
    return of.poses > 0 ? nlohmann::json(static_cast<double>(count) / of.poses) : nullptr;
  };
  nlohmann::json nees = nullptr;
  if (of.objects > 0) {
    nees = {{"mean", of.nees},
            {"objects", of.objects},
            {"low_95", of.nees_low},
            {"high_95", of.nees_high}};
  }
  return {{"poses", of.poses},
          {"truth_in_50_percent", share(of.within_50)},
          {"truth_in_95_percent", share(of.within_95)},
          {"nees", std::move(nees)},
          {"labels", LabelsToJson(of.labels)}};
}

nlohmann::json ToJson(const PrecisionRecall& curve) {
  nlohmann::json points = nlohmann::json::array();
  for (const PrecisionRecallPoint& point : curve.points)
    points.push_back(
        {{"threshold", point.threshold}, {"precision", point.precision}, {"recall", point.recall}});
  return {{"truths", curve.truths},
          {"average_precision", curve.average_precision},
          {"points", std::move(points)}};
}

nlohmann::json ObjectToJson(const ObjectSample& object, const RunReliability& along) {
  nlohmann::json json = {{"id", object.id.value},
                         {"confirmed", object.state == ObjectState::kConfirmed},
                         {"probability", ProbabilityOfBeing(object)},
                         {"ground_truth", nullptr}};
  if (!NearTruth(object)) return json;
  const TruthError& error = *object.error;
  json["ground_truth"] = error.truth;
  json["credible_level"] = error.credible_level;
  json["nees"] = error.nees;
  json["degrees_of_freedom"] = error.degrees_of_freedom;
  if (!object.label_probability.empty())
    json["label"] = {{"probability", object.label_probability.front().probability},
                     {"right", error.model_correct},
                     {"several_models", error.several_models}};
  for (const RunReliability::OfObject& of : along.objects) {
    if (of.object == object.id) json["along_the_run"] = ToJson(of.reliability);
  }
  return json;
}

}  // namespace

RunReliability ReliabilityOf(const RunHistory& history) { return Judge(history.frames, true); }

RunReliability ReliabilityAtEnd(const RunHistory& history) {
  return Judge(LastFrame(history), false);
}

PrecisionRecall ConfirmationOf(const RunHistory& history, int truths) {
  std::vector<Candidate> candidates;
  for (const auto& frame : LastFrame(history)) {
    for (const ObjectSample& object : frame->objects) {
      if (object.state == ObjectState::kRetired) continue;
      candidates.push_back(
          {ProbabilityOfBeing(object), NearTruth(object) ? object.error->truth : ""});
    }
  }
  return PrecisionRecallOf(std::move(candidates), truths);
}

nlohmann::json BeliefToJson(const RunHistory& history, int truths) {
  const RunReliability along = ReliabilityOf(history);
  nlohmann::json objects = nlohmann::json::array();
  for (const auto& frame : LastFrame(history)) {
    for (const ObjectSample& object : frame->objects) {
      if (object.state != ObjectState::kRetired) objects.push_back(ObjectToJson(object, along));
    }
  }
  return {{"at_the_end", ToJson(ReliabilityAtEnd(history).all)},
          {"along_the_run", ToJson(along.all)},
          {"confirmation", ToJson(ConfirmationOf(history, truths))},
          {"objects", std::move(objects)}};
}

}  // namespace plumbline
