// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "app/report/run_page.h"
#include "app/report/run_report.h"
#include "app/verbs/console_work.h"
#include "app/verbs/verb.h"
#include "engine/analysis/object_looks.h"
#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/recording/run_summary.h"
#include "engine/runtime/run_source.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr int kPictures = 4;

struct ReportArguments {
  RunChoice run;
  std::string ground_truth, out;
  bool interactive = false;
  RunPageOptions page;
};

/// Frames spread over the run; none where images cannot be had.
std::vector<ReportPicture> TakePictures(const RunChoice& choice, const ObjectLooks& looks,
                                        const WorkContext& work) {
  std::vector<ReportPicture> pictures;
  auto source = OpenRunSource(choice, work);
  if (!source.ok()) {
    log::warn("no pictures: {}", source.error().message);
    return pictures;
  }
  const int size = (*source)->size();
  int before = -1;
  for (int i = 0; i < kPictures; ++i) {
    const int position = (size - 1) * (i + 1) / kPictures;
    if (position == std::exchange(before, position)) continue;
    const auto snapshot = (*source)->Past(position, work.stop);
    if (!snapshot.ok()) continue;
    cv::Mat image = OutlinedImage(**snapshot, (*source)->view(), looks);
    if (!image.empty()) pictures.push_back({(*snapshot)->report.frame, std::move(image)});
  }
  return pictures;
}

Result<std::optional<MapEvaluation>> Judge(const RunReview& review, const std::string& truth_file,
                                           const std::filesystem::path& run) {
  std::filesystem::path file = truth_file;
  if (file.empty()) {
    if (review.view.truth.empty()) return std::optional<MapEvaluation>();
    auto sequence = OpenSequence(review.view.path);
    if (!sequence.ok() || !(*sequence)->ground_truth_file()) return std::optional<MapEvaluation>();
    file = *(*sequence)->ground_truth_file();
  }
  const Result<GroundTruth> truth = ReadGroundTruth(file);
  if (!truth) return truth.error();
  const auto estimates = ReadEstimates(run);
  if (!estimates) return estimates.error();
  EvaluationOptions options;
  options.samples = 100'000;
  auto evaluation = EvaluateMap(*estimates, *truth, *review.database, nullptr, options);
  if (!evaluation) return evaluation.error();
  return std::optional(std::move(*evaluation));
}

Status WritePage(const ReportArguments& arguments, const RunReview& review,
                 const std::optional<MapEvaluation>& evaluation, const WorkContext& work) {
  const auto page = MakeRunPage(arguments.run, review, evaluation, arguments.page, work);
  if (!page.ok()) return page.error();
  if (Status status = WriteFileAtomically(arguments.out, page->html); !status.ok()) return status;
  const auto mb = [](std::size_t bytes) { return static_cast<double>(bytes) * 1e-6; };
  std::printf("wrote %s: %d frames, %.1f MB, of which images %.1f MB\n", arguments.out.c_str(),
              page->steps, mb(page->html.size()), mb(page->image_bytes));
  return {};
}

Status Report(const ReportArguments& arguments) {
  ConsoleWork console;
  const WorkContext work = console.context();
  RunChoice choice = arguments.run;
  const auto review = ReviewRun(choice, arguments.ground_truth, work);
  if (!review) return review.error();
  const auto evaluation = Judge(*review, arguments.ground_truth, choice.run);
  if (!evaluation) return evaluation.error();
  if (arguments.interactive) return WritePage(arguments, *review, *evaluation, work);
  const std::vector<ReportPicture> pictures = TakePictures(choice, LooksOf(*review), work);
  if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
  const std::string html =
      RunReportHtml(*review, pictures, *evaluation, choice.run.filename().string());
  if (Status status = WriteFileAtomically(arguments.out, html); !status.ok()) return status;
  std::printf("wrote %s (%zu kB)\n", arguments.out.c_str(), html.size() / 1000);
  return {};
}

}  // namespace

void AddReportVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* verb = app.add_subcommand(
      "report", "Write a web page of a run: pictures, plots, errors, costs; one file, all inside");
  verb->add_option("run", arguments->run.run, "A run file")->required()->type_name("RUN.plb");
  verb->add_option("--out", arguments->out, "The page to write")
      ->required()
      ->type_name("FILE.html");
  verb->add_option("--ground-truth", arguments->ground_truth,
                   "Ground truth (default: that of the sequence, if it has any)")
      ->type_name("FILE");
  verb->add_option("--models", arguments->run.models, "The models of the run, if they have moved")
      ->type_name("DIR");
  verb->add_option("--sequence", arguments->run.sequence,
                   "The sequence of the run, if it has moved")
      ->type_name("DIR");
  CLI::Option* interactive =
      verb->add_flag("--interactive", arguments->interactive,
                     "Instead a page in which one steps through the run: images with outlines and "
                     "boxes, the map in three dimensions, a timeline");
  verb->add_option("--width", arguments->page.width,
                   "Width of the images of an interactive page [px]")
      ->check(CLI::Range(64, 4096))
      ->capture_default_str()
      ->needs(interactive);
  verb->add_option("--quality", arguments->page.quality, "Quality of their JPEG")
      ->check(CLI::Range(1, 100))
      ->capture_default_str()
      ->needs(interactive);
  verb->add_option("--every", arguments->page.every,
                   "Each N-th frame only (default: each frame of a run of up to 600, of a longer "
                   "one as many as make 600)")
      ->check(CLI::PositiveNumber)
      ->type_name("N")
      ->needs(interactive);
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Report(*arguments); }; });
}

}  // namespace plumbline
