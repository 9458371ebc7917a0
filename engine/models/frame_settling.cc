// SPDX-License-Identifier: Apache-2.0
#include "engine/models/frame_settling.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "engine/models/shape_measures.h"

namespace plumbline {
namespace {

constexpr double kLargestThing_m = 12, kSmallestThing_m = 0.01;
constexpr double kFarBetter = 5;  ///< Times as likely.
constexpr double kDoubted = 0.6;  ///< At most, of a guess against what the file says.

std::string PercentText(double share) { return std::to_string(std::lround(100 * share)) + " %"; }

template <typename T>
std::string GuessText(const std::string& what, const std::string& value, const Guess<T>& guess,
                      const std::string& option) {
  const std::string surety = guess.confidence >= 0.95         ? "quite sure: "
                             : guess.confidence >= kSureGuess ? "fairly sure: "
                                                              : "unsure, look at it: ";
  return what + " taken as " + value + ", " + guess.reason + " (" + surety +
         PercentText(guess.confidence) + "; state it with " + option + ")";
}

bool CanBe(const Eigen::Vector3d& size_m, const Thing* thing) {
  const double largest = size_m.maxCoeff();
  if (thing != nullptr) return FitsThing(size_m, *thing);
  return largest <= kLargestThing_m && largest >= kSmallestThing_m;
}

class FrameSettler {
 public:
  FrameSettler(const TriangleMesh& mesh, const FileFrame& frame, const ModelBuildOptions& options,
               KnownOfMesh known, ModelBuildReport& report)
      : mesh_(mesh),
        size_(BoundingBox(mesh).sizes().cast<double>()),
        frame_(frame),
        options_(options),
        known_(std::move(known)),
        report_(report) {}

  /// What it is by its name stays only where its size can be that.
  void SettleUnit(bool thing_is_stated) {
    Guess<LengthUnit> guess = GuessUnit(size_, known_);
    const bool doubtful = known_.thing != nullptr && !thing_is_stated;
    if (options_.unit || frame_.metres) {
      const double metres = options_.unit ? MetresPer(*options_.unit) : *frame_.metres;
      if (doubtful && !CanBe(metres * size_, known_.thing) &&
          !CanBe(MetresPer(guess.value) * size_, known_.thing)) {
        known_.thing = nullptr;
        guess = GuessUnit(size_, known_);
      }
      if (options_.unit || !Absurd(metres, guess)) {
        report_.unit = {metres, 1, {}};
        if (doubtful && !CanBe(metres * size_, known_.thing)) known_.thing = nullptr;
        if (!options_.unit) report_.believed.push_back("unit " + UnitText(metres) + SaidBy());
        known_.metres = metres;
        return;
      }
      guess.confidence = std::min(guess.confidence, kDoubted);
      report_.warnings.push_back(Contradiction(metres, guess));
    } else {
      if (doubtful && !CanBe(MetresPer(guess.value) * size_, known_.thing)) {
        known_.thing = nullptr;
        guess = GuessUnit(size_, known_);
      }
      report_.warnings.push_back(GuessText("unit", NameOf(guess.value), guess, "--unit"));
    }
    report_.unit = {MetresPer(guess.value), guess.confidence, {}};
    for (const auto& [unit, share] : guess.shares)
      report_.unit.shares.emplace_back(MetresPer(unit), share);
    known_.metres = report_.unit.value;
  }

  Status SettleUp() {
    if (options_.up && options_.up_sign_stated) {
      report_.up = {*options_.up, 1, {}};
      return {};
    }
    const auto guess =
        GuessUp(mesh_, known_, options_.up ? std::optional(options_.up->axis) : std::nullopt);
    if (!guess.ok()) return guess.error();
    if (options_.up) {
      SettleSign(*guess);
      return {};
    }
    if (frame_.up) return SettleStatedUp(*guess);
    report_.up = {guess->value, guess->confidence, guess->shares};
    report_.warnings.push_back(GuessText("up", guess->value.text(), *guess, "--up"));
    return {};
  }

  Status SettleFront() {
    if (options_.front && options_.front->axis == report_.up.value.axis) {
      return Error{ErrorCode::kInvalidInput,
                   "front " + options_.front->text() + " and up " + report_.up.value.text() +
                       " lie on one axis; state two different ones with --front and --up"};
    }
    if (options_.front) {
      report_.front = {*options_.front, 1, {}};
      return {};
    }
    const auto guess = GuessFront(mesh_, report_.up.value, known_);
    if (!guess.ok()) return guess.error();
    // What looks the same all round has no front to be wrong about, and a table has none either.
    report_.has_front = options_.symmetry != 0 &&
                        (known_.thing == nullptr || known_.thing->front != FrontHabit::kNone);
    if (!report_.has_front) {
      report_.front = {guess->value, 1, {}};
      return {};
    }
    report_.front = {guess->value, guess->confidence, guess->shares};
    report_.warnings.push_back(GuessText("front", guess->value.text(), *guess, "--front"));
    return {};
  }

  const Thing* thing() const { return known_.thing; }

 private:
  std::string SaidBy() const { return ", as " + frame_.by + " says"; }

  bool Absurd(double metres, const Guess<LengthUnit>& guess) const {
    const Eigen::Vector3d size_m = metres * size_;
    if (known_.thing == nullptr) return !CanBe(size_m, nullptr);
    return !CanBe(size_m, known_.thing) && CanBe(MetresPer(guess.value) * size_, known_.thing);
  }

  std::string Contradiction(double metres, const Guess<LengthUnit>& guess) const {
    char text[96];
    std::snprintf(text, sizeof(text), "it would be %.3g m large", metres * size_.maxCoeff());
    return GuessText("unit", NameOf(guess.value), guess, "--unit") + "; with " + UnitText(metres) +
           SaidBy() + ", " + text;
  }

  /// The file is believed unless the thing would fall over, and stands far better another way.
  Status SettleStatedUp(Guess<SignedAxis> guess) {
    const auto shape = MeasureShape(mesh_);
    if (!shape.ok()) return shape.error();
    double share = 1;
    for (const auto& [up, of_up] : guess.shares) {
      if (up == *frame_.up) share = of_up;
    }
    const bool falls = StandOn(*shape, *frame_.up).tipping_rad <= 0;
    if (!falls || guess.confidence < kFarBetter * share) {
      report_.up = {*frame_.up, 1, {}};
      report_.believed.push_back("up " + frame_.up->text() + SaidBy());
      return {};
    }
    guess.confidence = std::min(guess.confidence, kDoubted);
    report_.up = {guess.value, guess.confidence, guess.shares};
    report_.warnings.push_back(GuessText("up", guess.value.text(), guess, "--up") + "; with " +
                               frame_.up->text() + " up" + SaidBy() + ", it would fall over");
    return {};
  }

  void SettleSign(const Guess<SignedAxis>& guess) {
    report_.up = {*options_.up, 1, {}};
    if (guess.value.sign == options_.up->sign || guess.confidence < kSureGuess) return;
    report_.up.value = guess.value;
    report_.warnings.push_back(
        GuessText("up", guess.value.text(), guess, "--up=" + options_.up->text()) + ": with " +
        options_.up->text() + " up it would stand on its head");
  }

  const TriangleMesh& mesh_;
  Eigen::Vector3d size_;  ///< In the file's units.
  const FileFrame& frame_;
  const ModelBuildOptions& options_;
  KnownOfMesh known_;
  ModelBuildReport& report_;
};

}  // namespace

std::string UnitText(double metres) {
  for (const LengthUnit unit :
       {LengthUnit::kMetre, LengthUnit::kCentimetre, LengthUnit::kMillimetre}) {
    if (std::abs(metres / MetresPer(unit) - 1) < 1e-6) return NameOf(unit);
  }
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g m", metres);
  return text;
}

Status SettleFrame(const TriangleMesh& mesh, const FileFrame& frame, const std::string& extension,
                   const ModelBuildOptions& options, const Thing*& named,
                   ModelBuildReport& report) {
  FrameSettler settler(mesh, frame, options, {extension, named, 1}, report);
  settler.SettleUnit(!options.category.empty());
  named = settler.thing();
  if (const Status status = settler.SettleUp(); !status.ok()) return status;
  return settler.SettleFront();
}

}  // namespace plumbline
