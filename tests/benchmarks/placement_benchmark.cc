// SPDX-License-Identifier: Apache-2.0
// How long the annotator waits: from the click to the candidates with their pictures, through the
// process that the window uses, for every instance of a ground truth whose scan shows it.
//   placement_benchmark SCAN MODELS GROUND_TRUTH.json [METRES BESIDE]

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <thread>
#include <vector>

#include "engine/dataset/ground_truth.h"
#include "engine/geometry/gravity.h"
#include "engine/runtime/annotation_process.h"

namespace plumbline {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

template <typename Done>
std::shared_ptr<const AnnotationSnapshot> WaitFor(const AnnotationProcess& process, Done done) {
  for (;;) {
    auto snapshot = process.Snapshot();
    if (snapshot->state == AnnotationSnapshot::State::kFailed) {
      std::fprintf(stderr, "%s\n", snapshot->failure.c_str());
      std::exit(1);
    }
    if (done(*snapshot)) return snapshot;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

/// Of the first candidate, and the rank of the first within 5 cm and 5 degrees (0: none).
struct Outcome {
  double horizontal_m = 0, height_m = 0, turn_deg = 0;
  int right = 0;
};

Outcome Judge(const PlacementView& placement, const Eigen::Isometry3d& truth,
              const Eigen::Vector3d& up) {
  const UprightFrame frame(-up);
  Outcome outcome;
  int rank = 0;
  for (const PlacementCandidate& candidate : placement.candidates) {
    const Eigen::Vector3d off = candidate.scan_from_object.translation() - truth.translation();
    const double turn = WrapAngle(candidate.azimuth_rad - frame.Azimuth(truth.linear()));
    if (++rank == 1) {
      outcome.height_m = off.dot(up);
      outcome.horizontal_m = (off - outcome.height_m * up).norm();
      outcome.turn_deg = turn * 180 / std::numbers::pi;
    }
    const bool right = off.norm() < 0.05 && std::abs(turn) < 5 * std::numbers::pi / 180;
    if (right && outcome.right == 0) outcome.right = rank;
  }
  return outcome;
}

int Run(const AnnotationChoice& choice, const std::filesystem::path& truth_file, double beside_m) {
  const auto truth = ReadGroundTruth(truth_file);
  if (!truth) {
    std::fprintf(stderr, "%s\n", truth.error().message.c_str());
    return 1;
  }
  const auto start = Clock::now();
  AnnotationProcess process(choice, {});
  const auto ready = WaitFor(process, [](const AnnotationSnapshot& s) {
    return s.ready_to_align && !s.models->empty() && s.busy.empty();
  });
  std::printf("%zu points, ready after %.2f s\n", ready->scan_points, SecondsSince(start));
  std::printf("%-24s %8s %8s %10s %8s %6s %6s\n", "instance", "seconds", "across", "up", "turn",
              "right", "of");
  std::vector<double> times;
  const Eigen::Vector3d up = -truth->gravity_in_world;
  for (const GroundTruthInstance& instance : truth->instances) {
    const Eigen::Vector3d aside = UprightFrame(-up).upright_rotation().col(0) * beside_m;
    const auto clicked = Clock::now();
    process.Post(PlaceModelCommand{instance.model, instance.world_from_object.translation() + aside,
                                   0.4, true});
    const auto placed = WaitFor(
        process, [](const AnnotationSnapshot& s) { return s.placement && !s.placement->running; });
    times.push_back(SecondsSince(clicked));
    const Outcome outcome = Judge(*placed->placement, instance.world_from_object, up);
    std::printf("%-24s %8.2f %6.1f cm %7.1f cm %6.1f %6d %6zu", instance.id.c_str(), times.back(),
                100 * outcome.horizontal_m, 100 * outcome.height_m, outcome.turn_deg, outcome.right,
                placed->placement->candidates.size());
    // What the images say of them, later.
    const auto compared =
        WaitFor(process, [](const AnnotationSnapshot& s) { return s.placement && s.busy.empty(); });
    if (compared->placement->images > 0) {
      const Outcome later = Judge(*compared->placement, instance.world_from_object, up);
      std::printf("   %5.1f s: %5.1f cm %6.1f %3d  agreement %.2f%s", SecondsSince(clicked),
                  100 * later.horizontal_m, later.turn_deg, later.right,
                  compared->placement->candidates[0].agreement.value_or(0),
                  compared->placement->by_images ? " (by images)" : "");
    }
    std::printf("\n");
    // Taken, and on to the next: its images are still being looked for.
    process.Post(AcceptProposalCommand{});
    WaitFor(process, [](const AnnotationSnapshot& s) { return !s.placement; });
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  std::sort(times.begin(), times.end());
  std::printf("median %.2f s, longest %.2f s\n", times[times.size() / 2], times.back());
  return 0;
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "placement_benchmark SCAN MODELS GROUND_TRUTH.json [METRES BESIDE]\n");
    return 2;
  }
  plumbline::AnnotationChoice choice;
  choice.path = argv[1];
  choice.models = argv[2];
  return plumbline::Run(choice, argv[3], argc > 4 ? std::atof(argv[4]) : 0.1);
}
