// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/missed_truths.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/analysis/true_instances.h"
#include "engine/geometry/angles.h"
#include "engine/mapping/map_report.h"

namespace plumbline {
namespace {

constexpr float kWorthTelling_m = 0.6f;  ///< Candidates that never came nearer are left out.

struct CauseName {
  const char* in_files;
  const char* in_words;
};

CauseName NamesOf(MissedCause cause) {
  switch (cause) {
    case MissedCause::kNone:
      return {"none", "Found"};
    case MissedCause::kNotSeen:
      return {"not_seen", "Not seen"};
    case MissedCause::kNeverBoxed:
      return {"never_boxed", "Never boxed"};
    case MissedCause::kBirthRefused:
      return {"birth_refused", "Birth refused"};
    case MissedCause::kBoxTaken:
      return {"box_taken", "Box taken by another"};
    case MissedCause::kNeverNear:
      return {"never_near", "No candidate came near"};
    case MissedCause::kWithdrawn:
      return {"withdrawn", "Withdrawn"};
    case MissedCause::kNotConfirmed:
      return {"not_confirmed", "Not confirmed yet"};
  }
  return {"none", ""};
}

/// What the frames say of one object.
struct ObjectFate {
  std::optional<int> ended;
  std::string end;
  bool confirmed = false;
  std::string other_truth;  ///< Of the last frame in which it was confirmed and paired.
};

std::map<ObjectId, ObjectFate> FatesOf(const RunHistory& history,
                                       std::span<const FrameEvent> events) {
  std::map<ObjectId, ObjectFate> fates;
  for (const FrameEvent& event : events) {
    ObjectFate& fate = fates[event.event.object];
    if (event.event.kind == EventKind::kConfirmed) fate.confirmed = true;
    if (event.event.kind != EventKind::kRetired && event.event.kind != EventKind::kMerged) continue;
    fate.ended = event.frame;
    fate.end = event.event.text;
  }
  for (const auto& frame : history.frames) {
    if (frame == nullptr) continue;
    for (const ObjectSample& object : frame->objects) {
      if (object.state == ObjectState::kConfirmed && object.error)
        fates[object.id].other_truth = object.error->truth;
    }
  }
  return fates;
}

/// "± 3 cm, ± 2°"; of round shapes the first alone.
std::string SpreadInWords(const NearCandidate& candidate) {
  std::string words = fmt::format("\u00b1 {:.0f} cm", 100 * candidate.last_std_m);
  if (candidate.last_std_rad > 0)
    words += fmt::format(", \u00b1 {:.0f}\u00b0", kDegPerRad * candidate.last_std_rad);
  return words;
}

/// Goes over the frames once for one instance.
class TruthTeller {
 public:
  TruthTeller(const SequenceView& view, std::size_t index,
              const std::map<ObjectId, ObjectFate>& fates, double confirm_evidence)
      : index_(index), fates_(fates), confirm_evidence_(confirm_evidence) {
    const SequenceView::Truth& truth = view.truth[index];
    told_.id = truth.id;
    told_.model = truth.model;
    const ModelView* model = ModelByName(view, truth.model);
    if (model != nullptr) told_.category = model->category;
    seen_px_ = static_cast<float>(kSeenShare * view.image_width * view.image_height);
  }

  void Add(const FrameSample& frame) {
    if (index_ >= frame.truths.size()) return;
    const TruthSample& sample = frame.truths[index_];
    ++told_.frames;
    told_.object = sample.object;
    told_.found = sample.object.value > 0 && sample.confirmed;
    if (sample.visible_px >= seen_px_) AddSeen(frame.frame, sample);
    for (const TruthSample::Near& near : sample.near) AddNear(frame, near);
  }

  TruthView Tell() {
    for (const auto& [use, frames] : boxes_) told_.boxes.push_back({use.first, use.second, frames});
    std::stable_sort(told_.boxes.begin(), told_.boxes.end(),
                     [](const BoxUse& a, const BoxUse& b) { return a.frames > b.frames; });
    for (auto& [id, candidate] : candidates_) {
      const auto fate = fates_.find(id);
      if (fate != fates_.end()) {
        candidate.ended = fate->second.ended;
        candidate.end = fate->second.end;
        candidate.confirmed = fate->second.confirmed;
        // It became another instance.
        if (!fate->second.other_truth.empty() && fate->second.other_truth != told_.id) continue;
      }
      if (candidate.nearest_m <= kWorthTelling_m) told_.candidates.push_back(candidate);
    }
    std::stable_sort(
        told_.candidates.begin(), told_.candidates.end(),
        [](const NearCandidate& a, const NearCandidate& b) { return a.nearest_m < b.nearest_m; });
    Judge();
    return std::move(told_);
  }

 private:
  void AddSeen(int frame, const TruthSample& sample) {
    ++told_.frames_seen;
    if (told_.first_seen < 0) told_.first_seen = frame;
    told_.last_seen = frame;
    if (sample.visible_px > told_.best_visible_px) {
      told_.best_visible_px = sample.visible_px;
      told_.best_frame = frame;
    }
    if (!sample.box_fate) return;
    ++told_.frames_boxed;
    ++boxes_[{*sample.box_fate, sample.box_object}];
  }

  void AddNear(const FrameSample& frame, const TruthSample::Near& near) {
    const auto object =
        std::find_if(frame.objects.begin(), frame.objects.end(),
                     [&](const ObjectSample& sample) { return sample.id == near.object; });
    if (object == frame.objects.end()) return;
    const auto [at, is_new] = candidates_.try_emplace(near.object);
    NearCandidate& candidate = at->second;
    if (is_new) {
      candidate.object = near.object;
      candidate.first_frame = frame.frame;
      candidate.first_m = near.distance_m;
      candidate.most_evidence = object->log_evidence;
    }
    if (is_new || near.distance_m < candidate.nearest_m) {
      candidate.nearest_m = near.distance_m;
      candidate.nearest_rad = near.azimuth_rad;
      candidate.nearest_frame = frame.frame;
    }
    candidate.last_m = near.distance_m;
    candidate.last_rad = near.azimuth_rad;
    candidate.last_std_m = object->position_std_m;
    candidate.last_std_rad = object->round ? 0 : object->azimuth_std_rad;
    candidate.last_evidence = object->log_evidence;
    candidate.most_evidence = std::max(candidate.most_evidence, object->log_evidence);
  }

  static bool IsThere(float distance_m, float turned_rad) {
    return distance_m <= kThere_m && turned_rad <= kThere_rad;
  }

  int FramesOf(ProposalFate fate) const {
    int frames = 0;
    for (const BoxUse& use : told_.boxes) frames += use.fate == fate ? use.frames : 0;
    return frames;
  }

  void Say(MissedCause cause, const std::string& text) {
    told_.cause = cause;
    told_.text = std::string(InWordsOf(cause)) + ": " + text;
  }

  void Judge() {
    if (told_.found) {
      told_.text = fmt::format("In the map, as object {}.", told_.object.value);
      return;
    }
    if (told_.frames_seen < kFewestFramesSeen) {
      return Say(MissedCause::kNotSeen, fmt::format("enough of it shows in {} of {} frames.",
                                                    told_.frames_seen, told_.frames));
    }
    for (const NearCandidate& candidate : told_.candidates) {
      if (!candidate.ended && IsThere(candidate.last_m, candidate.last_rad))
        return SayNotConfirmed(candidate);
    }
    for (const NearCandidate& candidate : told_.candidates) {
      if (!candidate.ended && IsThere(candidate.nearest_m, candidate.nearest_rad))
        return SayStrayed(candidate);
    }
    const NearCandidate* withdrawn = nullptr;  // the one that came furthest
    for (const NearCandidate& candidate : told_.candidates) {
      if (!candidate.ended || !IsThere(candidate.nearest_m, candidate.nearest_rad)) continue;
      if (withdrawn == nullptr || candidate.most_evidence > withdrawn->most_evidence)
        withdrawn = &candidate;
    }
    if (withdrawn != nullptr) return SayWithdrawn(*withdrawn);
    if (told_.frames_boxed == 0) {
      return Say(MissedCause::kNeverBoxed,
                 fmt::format("it shows in {} frames ({}-{}), and no {} box lies over it in any.",
                             told_.frames_seen, told_.first_seen, told_.last_seen, told_.category));
    }
    if (!told_.candidates.empty()) return SayNeverNear(told_.candidates.front());
    SayAboutBoxes();
  }

  void SayNotConfirmed(const NearCandidate& candidate) {
    Say(MissedCause::kNotConfirmed,
        fmt::format("object {} stands {}.", candidate.object.value, WhereInTheEnd(candidate)));
  }

  /// Of one that was there once.
  void SayStrayed(const NearCandidate& candidate) {
    Say(MissedCause::kNotConfirmed,
        fmt::format("object {} came within {:.0f} cm and {:.0f}\u00b0 in frame {} and ends {}.",
                    candidate.object.value, 100 * candidate.nearest_m,
                    kDegPerRad * candidate.nearest_rad, candidate.nearest_frame,
                    WhereInTheEnd(candidate)));
  }

  std::string WhereInTheEnd(const NearCandidate& candidate) const {
    return fmt::format(
        "{:.0f} cm and {:.0f}\u00b0 from it, believed to {}, with evidence of {:.1f} (confirmed "
        "above {:.1f}{})",
        100 * candidate.last_m, kDegPerRad * candidate.last_rad, SpreadInWords(candidate),
        candidate.last_evidence, confirm_evidence_,
        candidate.last_evidence > confirm_evidence_
            ? ", once its belief is narrow and it has shown enough"
            : "");
  }

  void SayWithdrawn(const NearCandidate& candidate) {
    Say(MissedCause::kWithdrawn,
        fmt::format("object {} came within {:.0f} cm and {:.0f}\u00b0 in frame {} and was gone in "
                    "frame {} ({}); its evidence had come to {:.1f}, {} at {:.1f}.",
                    candidate.object.value, 100 * candidate.nearest_m,
                    kDegPerRad * candidate.nearest_rad, candidate.nearest_frame, *candidate.ended,
                    candidate.end, candidate.most_evidence,
                    candidate.confirmed ? "it was confirmed" : "confirmed", confirm_evidence_));
  }

  void SayNeverNear(const NearCandidate& candidate) {
    std::string end = "it still lives";
    if (candidate.ended)
      end = fmt::format("it was gone in frame {} ({})", *candidate.ended, candidate.end);
    Say(MissedCause::kNeverNear,
        fmt::format("of {} candidate{} the nearest, object {}, appeared {:.0f} cm away in frame "
                    "{} and was never nearer than {:.0f} cm and {:.0f}\u00b0; {}.",
                    told_.candidates.size(), told_.candidates.size() == 1 ? "" : "s",
                    candidate.object.value, 100 * candidate.first_m, candidate.first_frame,
                    100 * candidate.nearest_m, kDegPerRad * candidate.nearest_rad, end));
  }

  void SayAboutBoxes() {
    const int explained = FramesOf(ProposalFate::kExplained);
    const BoxUse& most = told_.boxes.front();
    if (2 * explained >= told_.frames_boxed && most.object.value > 0) {
      return Say(MissedCause::kBoxTaken,
                 fmt::format("a box lies over it in {} of the {} frames in which it shows; in {} "
                             "of them object {} took it{}.",
                             told_.frames_boxed, told_.frames_seen, most.frames, most.object.value,
                             WhoIs(most.object)));
    }
    std::string why;
    for (const BoxUse& use : told_.boxes) {
      if (use.fate == ProposalFate::kExplained) continue;
      why += fmt::format("{}{} {}", why.empty() ? "" : ", ", use.frames, InWords(NameOf(use.fate)));
    }
    Say(MissedCause::kBirthRefused,
        fmt::format("a box lies over it in {} of the {} frames in which it shows, and no candidate "
                    "came of them: {}.",
                    told_.frames_boxed, told_.frames_seen, why));
  }

  std::string WhoIs(ObjectId object) const {
    const auto fate = fates_.find(object);
    if (fate == fates_.end()) return "";
    if (!fate->second.other_truth.empty()) return ", which is " + fate->second.other_truth;
    return fate->second.confirmed ? ", which is no true object" : ", which was never confirmed";
  }

  static const char* InWordsOf(MissedCause cause) { return NamesOf(cause).in_words; }

  std::size_t index_;
  const std::map<ObjectId, ObjectFate>& fates_;
  double confirm_evidence_;
  float seen_px_ = 0;
  TruthView told_;
  std::map<std::pair<ProposalFate, ObjectId>, int> boxes_;
  std::map<ObjectId, NearCandidate> candidates_;
};

nlohmann::json ToJson(const NearCandidate& candidate) {
  return {{"object", candidate.object.value},
          {"first_frame", candidate.first_frame},
          {"first_m", candidate.first_m},
          {"nearest_frame", candidate.nearest_frame},
          {"nearest_m", candidate.nearest_m},
          {"nearest_deg", kDegPerRad * candidate.nearest_rad},
          {"most_evidence", candidate.most_evidence},
          {"last_evidence", candidate.last_evidence},
          {"last_std_m", candidate.last_std_m},
          {"last_std_deg", kDegPerRad * candidate.last_std_rad},
          {"confirmed", candidate.confirmed},
          {"ended", candidate.ended ? nlohmann::json(*candidate.ended) : nullptr},
          {"end", candidate.end}};
}

}  // namespace

TruthsView TruthsOf(const RunHistory& history, std::span<const FrameEvent> events,
                    const SequenceView& view, double confirm_evidence) {
  TruthsView truths;
  if (view.truth.empty()) return truths;
  const std::map<ObjectId, ObjectFate> fates = FatesOf(history, events);
  std::vector<TruthTeller> tellers;
  for (std::size_t i = 0; i < view.truth.size(); ++i)
    tellers.emplace_back(view, i, fates, confirm_evidence);
  for (const auto& frame : history.frames) {
    if (frame == nullptr || frame->skipped) continue;
    for (TruthTeller& teller : tellers) teller.Add(*frame);
  }
  for (TruthTeller& teller : tellers) {
    truths.truths.push_back(teller.Tell());
    ++(truths.truths.back().found ? truths.found : truths.missed);
  }
  return truths;
}

TruthsView TruthsOf(const RunReview& review) {
  std::vector<FrameEvent> events;
  for (const RunEvent& event : review.events) events.push_back({event.frame, event.event});
  return TruthsOf(review.history, events, review.view,
                  review.header.recipe.options.confirm_evidence);
}

const char* NameOf(MissedCause cause) { return NamesOf(cause).in_files; }

nlohmann::json WhyMissedToJson(const TruthView& truth) {
  nlohmann::json boxes = nlohmann::json::array(), candidates = nlohmann::json::array();
  for (const BoxUse& use : truth.boxes) {
    boxes.push_back({{"fate", NameOf(use.fate)},
                     {"object", use.object.value > 0 ? nlohmann::json(use.object.value) : nullptr},
                     {"frames", use.frames}});
  }
  for (const NearCandidate& candidate : truth.candidates) candidates.push_back(ToJson(candidate));
  return {{"cause", NameOf(truth.cause)},   {"text", truth.text},
          {"frames", truth.frames},         {"frames_seen", truth.frames_seen},
          {"first_seen", truth.first_seen}, {"last_seen", truth.last_seen},
          {"best_frame", truth.best_frame}, {"frames_boxed", truth.frames_boxed},
          {"boxes", std::move(boxes)},      {"candidates", std::move(candidates)}};
}

const TruthView* FindTruth(const TruthsView& truths, std::string_view id) {
  for (const TruthView& truth : truths.truths) {
    if (truth.id == id) return &truth;
  }
  return nullptr;
}

}  // namespace plumbline
