// SPDX-License-Identifier: Apache-2.0
// Scoring hypotheses: the fast scorer against the rendered reference and against the classic way
// (for each hypothesis one full render, an edge pass and its read-back), 3 models x 10 scenes,
// every other one partly hidden. The classic way has the benefit of our Renderer, which limits edge
// pass and read-back to the object's part of the image. Times are processor time of all threads, so
// that they are comparable on a busy machine; the fast scorer runs on one.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <span>
#include <vector>

#include <tbb/global_control.h>

#include "engine/mapping/rendered_scorer.h"
#include "engine/mapping/viewpoint_scorer.h"
#include "tests/support/furniture_models.h"
#include "tests/support/scoring_scene.h"

namespace plumbline {
namespace {

constexpr int kScenes = 10, kHypotheses = 256, kClassic = 6;
const PinholeCamera kCamera{960, 500, 600, 600, 479.5, 249.5};

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<double> Phi(const std::vector<HypothesisScore>& scores) {
  std::vector<double> phi;
  for (const HypothesisScore& score : scores)
    phi.push_back(static_cast<double>(score.agreement_m / std::max(1.0f, score.visible_m)));
  return phi;
}

/// Minus the mean distance [px] between where the model's points are and where a hypothesis puts
/// them.
std::vector<double> MinusReprojectionErrors(const ScoringScene& scene,
                                            const ModelDatabase& database,
                                            const std::vector<PoseHypothesis>& hypotheses) {
  const auto& vertices = database.model(scene.truth.label).mesh.vertices;
  const Eigen::Isometry3d truth = CamFromObject(scene, database, scene.truth);
  std::vector<double> errors;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    const Eigen::Isometry3d pose = CamFromObject(scene, database, hypothesis);
    double sum = 0;
    for (const Eigen::Vector3f& vertex : vertices) {
      const Eigen::Vector3d point = vertex.cast<double>();
      sum += (kCamera.Project(pose * point) - kCamera.Project(truth * point)).norm();
    }
    errors.push_back(-sum / static_cast<double>(vertices.size()));
  }
  return errors;
}

/// Seconds for one hypothesis the classic way.
double ClassicSeconds(Renderer& renderer, int mesh, const ScoringScene& scene,
                      const ModelDatabase& database,
                      const std::vector<PoseHypothesis>& hypotheses) {
  RenderOptions options;
  options.contour = true;
  options.contour_pass = ContourPass::kShader;
  const double start = ProcessorSeconds();
  std::int64_t hits = 0;
  for (int i = 0; i < kClassic; ++i) {
    const RenderInstance instance{
        mesh, CamFromObject(scene, database, hypotheses[static_cast<std::size_t>(i)]), 1};
    const RenderedMaps maps = renderer.Render(kCamera, std::span(&instance, 1), options);
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        if (maps.contour.at<std::uint8_t>(y, x) != 0) hits += scene.table->Hit(x, y, 0);
      }
    }
  }
  const double seconds = (ProcessorSeconds() - start) / kClassic;
  return hits < 0 ? 0 : seconds;  // the sum is used, so that the loop stays
}

/// Means over the scenes of one kind of scatter.
struct Figures {
  double agreement = 0, worst = 1, fast_truth = 0, reference_truth = 0;
  double squared_gap = 0;  ///< Of the fast scorer's correlation with the truth and the reference's.
};

struct Times {
  double fast = 0, reference = 0, classic = 0;
  int count = 0, classic_count = 0;
};

class Benchmark {
 public:
  void Prepare() {
    database_ = MakeFurnitureDatabase();
    context_ = RenderContext::CreateHeadless().value();
    renderer_ = Renderer::Create(*context_).value();
    reference_ = RenderedScorer::Create(database_, {}).value();
    std::vector<std::shared_ptr<const ViewpointModel>> views(database_->models().size());
    for (const char* name : {"chair", "armchair", "table"}) {
      const ModelId id = *database_->Find(name);
      views[static_cast<std::size_t>(id.value)] =
          ViewpointModel::Build(database_->model(id), {}, {}).value();
      models_.push_back(id);
    }
    fast_ = std::make_unique<ViewpointScorer>(views, database_);
    std::printf("renderer: %s; %d x %d px, %d hypotheses a scene\n",
                context_->Description().c_str(), kCamera.width, kCamera.height, kHypotheses);
  }

  void Run() {
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    for (const ModelId model : models_) {
      const int mesh = renderer_->AddMesh(database_->model(model).mesh);
      for (int i = 0; i < kScenes; ++i) {
        const ScoringScene scene =
            MakeScoringScene(*database_, model, kCamera, static_cast<std::uint64_t>(i));
        Compare(scene, 0.05, 5, near_);
        Compare(scene, 0.15, 20, far_);
        const auto hypotheses = Scattered(scene, kClassic, 0.05, 5, 3);
        times_.classic +=
            kClassic * ClassicSeconds(*renderer_, mesh, scene, *database_, hypotheses);
        times_.classic_count += kClassic;
      }
    }
  }

  void Print() const {
    const double fast = times_.count / times_.fast, reference = times_.count / times_.reference,
                 classic = times_.classic_count / times_.classic;
    std::printf("%-38s %14s\n", "", "hypotheses/s");
    std::printf("%-38s %14.0f\n%-38s %14.0f\n%-38s %14.0f\n",
                "classic (render, edge pass, read back)", classic, "rendered reference (atlas)",
                reference, "fast scorer, one thread", fast);
    std::printf("fast : classic = %.0f (bar 1000), fast : reference = %.0f\n", fast / classic,
                fast / reference);
    std::printf("%-20s %22s %8s %26s %10s %20s\n", "rank correlation", "fast with reference",
                "worst", "with reprojection: fast", "reference", "gap");
    PrintFigures("5 cm, 5 degrees", near_, 0.95);
    PrintFigures("15 cm, 20 degrees", far_, 0.9);
  }

 private:
  void PrintFigures(const char* name, const Figures& figures, double bar) const {
    const double n = kScenes * static_cast<double>(models_.size());
    const double gap = (figures.fast_truth - figures.reference_truth) / n;
    std::printf("%-20s %12.3f (bar %.2f) %8.3f %26.3f %10.3f %+10.4f +- %.4f\n", name,
                figures.agreement / n, bar, figures.worst, figures.fast_truth / n,
                figures.reference_truth / n, gap,
                std::sqrt((figures.squared_gap / n - gap * gap) / (n - 1)));
  }

  void Compare(const ScoringScene& scene, double position_m, double angle_deg, Figures& figures) {
    const auto hypotheses = Scattered(scene, kHypotheses, position_m, angle_deg, 2);
    std::vector<HypothesisScore> fast(hypotheses.size()), reference(hypotheses.size());
    const UprightFrame upright(Eigen::Vector3d(0, 0, -1));
    constexpr int kRepeats = 40;
    double start = ProcessorSeconds();
    for (int i = 0; i < kRepeats; ++i) fast_->Score(scene.View(), upright, hypotheses, fast);
    times_.fast += (ProcessorSeconds() - start) / kRepeats;
    start = ProcessorSeconds();
    reference_->Score(scene.View(), upright, hypotheses, reference);
    times_.reference += ProcessorSeconds() - start;
    times_.count += kHypotheses;
    const std::vector<double> a = Phi(fast), b = Phi(reference),
                              truth = MinusReprojectionErrors(scene, *database_, hypotheses);
    const double agreement = Spearman(a, b);
    figures.agreement += agreement;
    figures.worst = std::min(figures.worst, agreement);
    const double fast_truth = Spearman(a, truth), reference_truth = Spearman(b, truth);
    figures.fast_truth += fast_truth;
    figures.reference_truth += reference_truth;
    figures.squared_gap += std::pow(fast_truth - reference_truth, 2);
  }

  std::shared_ptr<const ModelDatabase> database_;
  std::unique_ptr<RenderContext> context_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<RenderedScorer> reference_;
  std::unique_ptr<ViewpointScorer> fast_;
  std::vector<ModelId> models_;
  Figures near_, far_;
  Times times_;
};

}  // namespace
}  // namespace plumbline

int main() {
  plumbline::Benchmark benchmark;
  benchmark.Prepare();
  benchmark.Run();
  benchmark.Print();
  return 0;
}
