// SPDX-License-Identifier: Apache-2.0
// Gravity-constrained alignment on seeded cases: a model scanned from one side, noisy, among
// clutter, azimuth unknown, up to 30 cm away.
// The baseline is VTK's rigid ICP from the same starts, the best by its mean distance, given the
// same cropped scan.
// Open3D's where libopen3d-dev is installed. Cases for CloudCompare are written to FOLDER.
//   alignment_benchmark [CASES [FOLDER | - (Plumbline alone) [ROOM]]]
// ROOM is a sequence with scene.ply, models and ground_truth.json: its instances that stand on the
// floor are aligned, too, from three starts each, and written to FOLDER/ROOM.

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

#include "engine/base/random.h"
#include "engine/dataset/ground_truth.h"
#include "engine/geometry/gravity.h"
#include "engine/models/mesh_file.h"
#include "engine/registration/floor.h"
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
  Outcome Open3d(int starts, Open3dSteps steps) const {
    return Timed([&] {
      return Compared(
          AlignWithOpen3d(crop_, surface_, test_.start, test_.up_in_scan, starts, steps));
    });
  }

  Outcome Features() const {
    return Timed([&] { return Compared(AlignByFeatures(crop_, surface_)); });
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

using Outcomes = std::map<std::string, std::vector<Outcome>>;

/// A model, prepared.
struct Shape {
  const CadModel* model = nullptr;
  std::shared_ptr<const ModelSurface> surface;
  int order = 1;
};

Shape ShapeOf(const CadModel& model) {
  Shape shape{&model, ModelSurface::Prepare(model.mesh).value(), 1};
  shape.order = shape.surface->SymmetryOrder(0.01);
  return shape;
}

Outcome Ours(const AlignmentCase& test, const ScanTarget& target, const Shape& shape,
             const AlignOptions& options) {
  return Timed([&] {
    const auto aligned = AlignModel(target, *shape.surface, test.start, test.up_in_scan, options);
    if (!aligned) return Outcome{1, 1, 0, 0, 0};
    return Compare(test, *shape.model, shape.order, aligned->candidates[0].scan_from_model);
  });
}

void Others(const AlignmentCase& test, const Shape& shape, const AlignmentCrop& crop,
            Outcomes& outcomes) {
  const Baselines baselines(test, *shape.model, *shape.surface, shape.order, crop);
  for (const int starts : {1, 24}) {
    const std::string from = starts == 1 ? ", the given start" : ", 24 starts";
    outcomes["VTK's rigid ICP" + from].push_back(baselines.Vtk(starts));
#ifdef PLUMBLINE_OPEN3D
    outcomes["Open3D's ICP to planes" + from].push_back(
        baselines.Open3d(starts, Open3dSteps::kRigid));
    outcomes["Open3D's ICP, steps of 4 dof" + from].push_back(
        baselines.Open3d(starts, Open3dSteps::kProjected));
#endif
  }
#ifdef PLUMBLINE_OPEN3D
  outcomes["Open3D's FPFH + RANSAC, then ICP"].push_back(baselines.Features());
#endif
}

void PrintAll(const Outcomes& outcomes) {
  std::printf("%-42s %-10s %11s %12s  %24s  %s\n", "", "under 2 cm, 2 deg", "median", "median",
              "tilt: median, worst", "CPU and wall time");
  for (const auto& [name, list] : outcomes) Print(name.c_str(), list);
}

/// Where `with_others`, the cases are written to `write_to` unless that is empty.
void RunCases(int cases, bool with_others, const std::filesystem::path& write_to) {
  const auto models = MakeFurnitureDatabase();
  std::vector<Shape> shapes;
  for (const CadModel& model : models->models()) shapes.push_back(ShapeOf(model));
  Outcomes outcomes;
  double prepare_ms = 0;
  std::size_t points = 0;
  for (int i = 0; i < cases; ++i) {
    const ModelId id{i % static_cast<int>(shapes.size())};
    const Shape& shape = shapes[static_cast<std::size_t>(id.value)];
    const AlignmentCase test = MakeAlignmentCase(*models, id, static_cast<std::uint64_t>(1000 + i));
    const double start_ms = CpuMilliseconds();
    const auto target = ScanTarget::Prepare(test.scan, test.camera_centers).value();
    prepare_ms += CpuMilliseconds() - start_ms;
    points += test.scan.vertices.size();
    AlignOptions options;
    outcomes["Plumbline, 24 starts"].push_back(Ours(test, *target, shape, options));
    if (with_others) {
      const AlignmentCrop crop =
          CropScan(*target, *shape.surface, test.start, test.up_in_scan, options.search_m);
      if (!write_to.empty())
        WriteCase(write_to, i, test, *shape.model, shape.order, *shape.surface, crop);
      Others(test, shape, crop, outcomes);
    }
    options.starts = 1;
    outcomes["Plumbline, the given start"].push_back(Ours(test, *target, shape, options));
  }
  for (int i = 0; i < cases / 2; ++i) {
    const ModelId id{i % 2};  // The chairs.
    AlignmentCaseOptions under_table;
    under_table.under_table = true;
    AlignOptions on_floor;
    on_floor.standing = Standing::kOnSupport;
    const AlignmentCase test =
        MakeAlignmentCase(*models, id, static_cast<std::uint64_t>(5000 + i), under_table);
    const auto target = ScanTarget::Prepare(test.scan, test.camera_centers).value();
    outcomes["Plumbline, 24 starts, chairs under a table"].push_back(
        Ours(test, *target, shapes[static_cast<std::size_t>(id.value)], on_floor));
  }
  std::printf("%d cases, %zu points each on average, prepared in %.1f ms\n", cases,
              points / static_cast<std::size_t>(cases), prepare_ms / cases);
  PrintAll(outcomes);
}

/// Every method on the instances of a real room that stand on its floor, from three starts each, up
/// to 17 cm off along each axis and turned by anything. Prints all errors.
Status RunRoom(const std::filesystem::path& room, const std::filesystem::path& write_to) {
  const auto truth = ReadGroundTruth(room / "ground_truth.json");
  if (!truth.ok()) return truth.error();
  const auto models = ModelDatabase::Load(room / "models");
  if (!models.ok()) return models.error();
  const auto scan = ReadMesh(room / "scene.ply");
  if (!scan.ok()) return scan.error();
  const auto target = ScanTarget::Prepare(*scan).value();
  // As `plumbline align` does for what stands on the floor.
  const auto floor = FindFloor(*target, {{}, -truth->gravity_in_world});
  if (!floor.ok()) return floor.error();
  Outcomes all;
  int number = 0;
  for (const GroundTruthInstance& instance : truth->instances) {
    const auto id = (*models)->Find(instance.model);
    if (!id || (*models)->model(*id).support != Support::kFloor) continue;
    const Shape shape = ShapeOf((*models)->model(*id));
    Outcomes outcomes;
    for (std::uint32_t start = 0; start < 3; ++start, ++number) {
      AlignmentCase test;
      test.scan_from_model = instance.world_from_object;
      test.up_in_scan = -truth->gravity_in_world;
      Random random({.seed = 1, .frame = static_cast<std::uint32_t>(number)});
      Eigen::Vector3d offset;
      for (double& along : offset) along = random.Uniform(-0.17, 0.17);
      test.start = instance.world_from_object;
      test.start.linear() =
          Eigen::AngleAxisd(random.Uniform(0, 2 * std::numbers::pi), test.up_in_scan) *
          test.start.linear();
      test.start.translation() += offset;
      AlignOptions options;
      outcomes["Plumbline, 24 starts, anywhere"].push_back(Ours(test, *target, shape, options));
      options.standing = Standing::kOnSupport;
      options.floor_in_scan.emplace();
      *options.floor_in_scan << floor->up_in_scan, floor->offset_m;
      outcomes["Plumbline, 24 starts, on the floor"].push_back(Ours(test, *target, shape, options));
      const AlignmentCrop crop =
          CropScan(*target, *shape.surface, test.start, test.up_in_scan, options.search_m);
      if (!write_to.empty())
        WriteCase(write_to, number, test, *shape.model, shape.order, *shape.surface, crop);
      Others(test, shape, crop, outcomes);
    }
    std::printf("\n%s (cases %d to %d)\n", instance.id.c_str(), number - 3, number - 1);
    for (auto& [name, list] : outcomes) {
      std::printf("  %-42s", name.c_str());
      for (const Outcome& o : list)
        std::printf("  %6.1f cm %6.1f deg", 100 * o.translation_m, Degrees(o.azimuth_rad));
      std::printf("\n");
      all[name].insert(all[name].end(), list.begin(), list.end());
    }
  }
  std::printf("\n%s\n", room.c_str());
  PrintAll(all);
  return {};
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  const int cases = argc > 1 ? std::atoi(argv[1]) : 100;
  const std::string folder = argc > 2 ? argv[2] : "";
  const std::filesystem::path write_to = folder == "-" ? "" : folder;
  if (cases > 0) plumbline::RunCases(cases, folder != "-", write_to);
  if (argc <= 3) return 0;
  const std::filesystem::path room = argv[3];
  const plumbline::Status status =
      plumbline::RunRoom(room, write_to.empty() ? write_to : write_to / room.filename());
  if (!status.ok()) std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return status.ok() ? 0 : 1;
}
