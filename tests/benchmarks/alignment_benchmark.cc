// SPDX-License-Identifier: Apache-2.0
// Gravity-constrained alignment on seeded cases: a model scanned from one side, noisy, among
// clutter, azimuth unknown, up to 30 cm away.
// The baseline is VTK's rigid ICP from the same starts, the best by its mean distance, given the
// same cropped scan.
// Open3D's where libopen3d-dev is installed. Cases for CloudCompare are written to FOLDER.
//   alignment_benchmark [CASES [FOLDER | - (Plumbline alone)]]

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <vector>

#include <vtkCellArray.h>
#include <vtkCellLocator.h>
#include <vtkIterativeClosestPointTransform.h>
#include <vtkLandmarkTransform.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"
#include "engine/registration/model_alignment.h"
#include "tests/support/alignment_case.h"
#include "tests/support/furniture_models.h"
#ifdef PLUMBLINE_OPEN3D
#include "tests/benchmarks/open3d_icp.h"
#endif

namespace plumbline {
namespace {

/// Of all threads: other work on the machine does not count.
double CpuMilliseconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

double WallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double Degrees(double radians) { return radians * 180 / std::numbers::pi; }

struct Outcome {
  double translation_m = 0, azimuth_rad = 0, tilt_rad = 0, cpu_s = 0, wall_s = 0;
};

/// Runs `align`, which gives an Outcome, and notes how long it took.
template <typename Align>
Outcome Timed(const Align& align) {
  const double cpu_ms = CpuMilliseconds(), wall_s = WallSeconds();
  Outcome outcome = align();
  outcome.wall_s = WallSeconds() - wall_s;
  outcome.cpu_s = (CpuMilliseconds() - cpu_ms) / 1e3;
  return outcome;
}

/// The error, least over the model's symmetry.
Outcome Compare(const AlignmentCase& test, const CadModel& model, int symmetry_order,
                const Eigen::Isometry3d& found) {
  const UprightFrame upright(-test.up_in_scan);
  Outcome outcome;
  outcome.translation_m = (found * model.center() - test.scan_from_model * model.center()).norm();
  outcome.tilt_rad = upright.Tilt(found.linear());
  const double turn =
      upright.Azimuth(found.linear()) - upright.Azimuth(test.scan_from_model.linear());
  if (symmetry_order == 0) return outcome;
  outcome.azimuth_rad = 10;
  for (int i = 0; i < symmetry_order; ++i) {
    const double error = WrapAngle(turn + 2 * std::numbers::pi * i / symmetry_order);
    if (std::abs(error) < std::abs(outcome.azimuth_rad)) outcome.azimuth_rad = error;
  }
  return outcome;
}

vtkSmartPointer<vtkPolyData> ToVtk(const std::vector<Eigen::Vector3f>& points) {
  vtkNew<vtkPoints> copy;
  vtkNew<vtkCellArray> vertices;
  for (const Eigen::Vector3f& point : points) {
    const vtkIdType id = copy->InsertNextPoint(point.data());
    vertices->InsertNextCell(1, &id);
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(copy);
  data->SetVerts(vertices);
  return data;
}

/// VTK's ICP, six degrees of freedom, model to scan.
Eigen::Isometry3d Baseline(const AlignmentCase& test, const ModelSurface& surface,
                           vtkPolyData* scan, vtkCellLocator* locator, int starts) {
  Eigen::Isometry3d best = test.start;
  double least = 1e30;
  for (int i = 0; i < starts; ++i) {
    Eigen::Isometry3d start = test.start;
    start.linear() =
        Eigen::AngleAxisd(2 * std::numbers::pi * i / starts, test.up_in_scan) * start.linear();
    std::vector<Eigen::Vector3f> points;
    for (std::size_t k = 0; k < surface.samples().points.size(); k += 20) {
      points.push_back(start.cast<float>() * surface.samples().points[k]);
    }
    vtkNew<vtkIterativeClosestPointTransform> icp;
    icp->SetSource(ToVtk(points));
    icp->SetTarget(scan);
    icp->SetLocator(locator);
    icp->GetLandmarkTransform()->SetModeToRigidBody();
    icp->SetMaximumNumberOfLandmarks(300);
    icp->SetMaximumNumberOfIterations(50);
    icp->CheckMeanDistanceOn();
    icp->SetMaximumMeanDistance(1e-5);
    icp->Update();
    Eigen::Isometry3d moved;
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) moved.matrix()(r, c) = icp->GetMatrix()->GetElement(r, c);
    }
    double sum = 0;
    for (const Eigen::Vector3f& point : points) {
      double closest[3], squared = 0;
      vtkIdType cell;
      int part;
      const Eigen::Vector3d p = moved * point.cast<double>();
      locator->FindClosestPoint(p.data(), closest, cell, part, squared);
      sum += std::min(squared, 0.0025);
    }
    if (sum < least) {
      least = sum;
      best = moved * start;
    }
  }
  return best;
}

void Print(const char* name, std::vector<Outcome> outcomes) {
  const auto median = [&](auto member) {
    std::vector<double> values;
    for (const Outcome& o : outcomes) values.push_back(std::abs(o.*member));
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  double tilt = 0, cpu_s = 0, wall_s = 0;
  std::size_t good = 0;
  for (const Outcome& o : outcomes) {
    good += o.translation_m < 0.02 && std::abs(o.azimuth_rad) < 2 * std::numbers::pi / 180;
    tilt = std::max(tilt, o.tilt_rad);
    cpu_s += o.cpu_s;
    wall_s += o.wall_s;
  }
  const auto count = static_cast<double>(outcomes.size());
  std::printf("%-42s %4zu of %zu  %7.2f mm %8.3f deg  %8.1e %8.1e rad  %7.1f %7.1f ms\n", name,
              good, outcomes.size(), 1e3 * median(&Outcome::translation_m),
              Degrees(median(&Outcome::azimuth_rad)), median(&Outcome::tilt_rad), tilt,
              1e3 * cpu_s / count, 1e3 * wall_s / count);
}

/// The other programs' results, from the same crop: what lies around without the support plane.
class Baselines {
 public:
  Baselines(const AlignmentCase& test, const CadModel& model, const ModelSurface& surface,
            int symmetry_order, const AlignmentCrop& crop)
      : test_(test), model_(model), surface_(surface), order_(symmetry_order), crop_(crop) {}

  Outcome Vtk(int starts) const {
    const auto scan = ToVtk(crop_.fine.points);
    vtkNew<vtkCellLocator> locator;
    locator->SetDataSet(scan);
    locator->BuildLocator();
    return Timed([&] { return Compared(Baseline(test_, surface_, scan, locator, starts)); });
  }

#ifdef PLUMBLINE_OPEN3D
  Outcome Open3d(int starts) const {
    return Timed([&] {
      return Compared(AlignWithOpen3d(crop_, surface_, test_.start, test_.up_in_scan, starts));
    });
  }
#endif

 private:
  Outcome Compared(const Eigen::Isometry3d& found) const {
    return Compare(test_, model_, order_, found);
  }

  const AlignmentCase& test_;
  const CadModel& model_;
  const ModelSurface& surface_;
  int order_;
  const AlignmentCrop& crop_;
};

/// For CloudCompare (cloudcompare_alignment.py): model at its start and crop as points, z up, and
/// the motion that would be right.
void WriteCase(const std::filesystem::path& folder, int number, const AlignmentCase& test,
               const CadModel& model, int order, const ModelSurface& surface,
               const AlignmentCrop& crop) {
  std::filesystem::create_directories(folder);
  const std::string name = "case" + std::to_string(number);
  Eigen::Isometry3d level = Eigen::Isometry3d::Identity();
  level.linear() = UprightFrame(-test.up_in_scan).upright_rotation().transpose();
  TriangleMesh scan, start;
  scan.vertices = crop.fine.points;
  start.vertices = surface.samples().points;
  scan = Transformed(std::move(scan), level);
  start = Transformed(std::move(start), level * test.start);
  static_cast<void>(WritePly(folder / (name + "_scan.ply"), scan).ok());
  static_cast<void>(WritePly(folder / (name + "_model.ply"), start).ok());
  const Eigen::Isometry3d motion = level * test.scan_from_model * (level * test.start).inverse();
  std::ofstream truth(folder / (name + ".txt"));
  truth.precision(17);
  truth << motion.matrix() << "\n"
        << (level * test.start * model.center()).transpose() << "\n"
        << order << "\n";
}

int Run(int cases, bool baselines_too, const std::filesystem::path& write_to) {
  const auto models = MakeFurnitureDatabase();
  std::vector<std::shared_ptr<const ModelSurface>> surfaces;
  std::vector<int> orders;
  for (const CadModel& model : models->models()) {
    surfaces.push_back(ModelSurface::Prepare(model.mesh).value());
    orders.push_back(surfaces.back()->SymmetryOrder(0.01));
  }
  std::map<std::string, std::vector<Outcome>> outcomes;
  double prepare_ms = 0;
  std::size_t points = 0;
  for (int i = 0; i < cases; ++i) {
    const ModelId id{i % static_cast<int>(models->models().size())};
    const auto k = static_cast<std::size_t>(id.value);
    const AlignmentCase test = MakeAlignmentCase(*models, id, static_cast<std::uint64_t>(1000 + i));
    const double start_ms = CpuMilliseconds();
    const auto target = ScanTarget::Prepare(test.scan, test.camera_centers).value();
    prepare_ms += CpuMilliseconds() - start_ms;
    points += test.scan.vertices.size();
    for (const int starts : {1, 24}) {
      const std::string from = starts == 1 ? ", the given start" : ", 24 starts";
      AlignOptions options;
      options.starts = starts;
      outcomes["Plumbline" + from].push_back(Timed([&] {
        const auto aligned =
            AlignModel(*target, *surfaces[k], test.start, test.up_in_scan, options);
        if (!aligned) return Outcome{1, 1, 0, 0, 0};
        return Compare(test, models->model(id), orders[k], aligned->candidates[0].scan_from_model);
      }));
      if (!baselines_too) continue;
      const AlignmentCrop crop =
          CropScan(*target, *surfaces[k], test.start, test.up_in_scan, options.search_m);
      if (!write_to.empty()) {
        WriteCase(write_to, i, test, models->model(id), orders[k], *surfaces[k], crop);
      }
      const Baselines baselines(test, models->model(id), *surfaces[k], orders[k], crop);
      outcomes["VTK's rigid ICP" + from].push_back(baselines.Vtk(starts));
#ifdef PLUMBLINE_OPEN3D
      outcomes["Open3D's ICP to planes" + from].push_back(baselines.Open3d(starts));
#endif
    }
  }
  for (int i = 0; i < cases / 2; ++i) {
    const ModelId id{i % 2};  // The chairs.
    const auto k = static_cast<std::size_t>(id.value);
    AlignmentCaseOptions under_table;
    under_table.under_table = true;
    AlignOptions on_floor;
    on_floor.standing = Standing::kOnSupport;
    const AlignmentCase test =
        MakeAlignmentCase(*models, id, static_cast<std::uint64_t>(5000 + i), under_table);
    const auto target = ScanTarget::Prepare(test.scan, test.camera_centers).value();
    outcomes["Plumbline, 24 starts, chairs under a table"].push_back(Timed([&] {
      const auto aligned = AlignModel(*target, *surfaces[k], test.start, test.up_in_scan, on_floor);
      if (!aligned) return Outcome{1, 1, 0, 0, 0};
      return Compare(test, models->model(id), orders[k], aligned->candidates[0].scan_from_model);
    }));
  }
  std::printf("%d cases, %zu points each on average, prepared in %.1f ms\n", cases,
              points / static_cast<std::size_t>(cases), prepare_ms / cases);
  std::printf("%-42s %-10s %11s %12s  %24s  %s\n", "", "under 2 cm, 2 deg", "median", "median",
              "tilt: median, worst", "CPU and wall time");
  for (const auto& [name, list] : outcomes) Print(name.c_str(), list);
  return 0;
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  const int cases = argc > 1 ? std::atoi(argv[1]) : 100;
  const std::string folder = argc > 2 ? argv[2] : "";
  return plumbline::Run(cases, folder != "-", folder == "-" ? "" : folder);
}
