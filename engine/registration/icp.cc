// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/icp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace plumbline {
namespace {

constexpr std::size_t kCoarsePoints = 500, kFinePoints = 5000;
constexpr float kCoarseVoxel_m = 0.03f, kFineVoxel_m = 0.008f;
constexpr double kSupportThickness_m = 0.015;

/// The height along `up` of the plane that the model stands on; nothing where there is none wider
/// than the model.
std::optional<double> SupportHeight(const OrientedPoints& points, const Eigen::Vector3d& up,
                                    double lowest_m, double highest_m, double least_area_m2) {
  constexpr double kBin_m = 0.01;
  constexpr float kCell_m = 0.03f;
  const auto bins = static_cast<std::size_t>(std::max(1.0, (highest_m - lowest_m) / kBin_m)) + 1;
  std::vector<int> counts(bins, 0);
  const Eigen::Vector3f upf = up.cast<float>();
  for (const int i : VoxelSample(points.points, kCell_m, points.points.size())) {
    const auto k = static_cast<std::size_t>(i);
    if (std::abs(points.normals[k].dot(upf)) < 0.95f) continue;
    const double bin = (points.points[k].dot(upf) - lowest_m) / kBin_m;
    if (bin >= 0 && bin < static_cast<double>(bins)) ++counts[static_cast<std::size_t>(bin)];
  }
  std::size_t best = 0;
  int most = 0;
  for (std::size_t i = 0; i < bins; ++i) {
    const int around = counts[i] + (i > 0 ? counts[i - 1] : 0) + (i + 1 < bins ? counts[i + 1] : 0);
    if (around > most) {
      most = around;
      best = i;
    }
  }
  if (most * kCell_m * kCell_m < least_area_m2) return std::nullopt;
  const double middle_m = lowest_m + (static_cast<double>(best) + 0.5) * kBin_m;
  std::vector<float> heights;
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    const float height = points.points[i].dot(upf);
    if (std::abs(height - middle_m) < 1.5 * kBin_m &&
        std::abs(points.normals[i].dot(upf)) > 0.95f) {
      heights.push_back(height);
    }
  }
  const auto median = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), median, heights.end());
  return *median;
}

double Squared(double x) { return x * x; }

/// Tukey's weight of a squared distance.
double Weight(double squared, double reach_m) {
  const double share = squared / (reach_m * reach_m);
  return share < 1 ? Squared(1 - share) : 0;
}

/// Cosine between two normals; 0 where they show opposite sides.
template <typename Vector>
double Agreement(const Vector& a, const Vector& b, bool any_sign) {
  const double cosine = a.dot(b);
  return any_sign ? std::abs(cosine) : std::max(0.0, cosine);
}

/// Pairs of nearby points: of the scan with the model, so that the missing parts of the scan do not
/// pull, and of the model with the scan, so that the model is not pulled onto what it cannot cover.
void FindCoarsePairs(const AlignmentCrop& crop, const ModelSurface& model,
                     const Eigen::Isometry3d& scan_from_model, double reach_m,
                     std::vector<PointPair>& pairs) {
  pairs.clear();
  const Eigen::Isometry3f from_model = scan_from_model.cast<float>();
  const Eigen::Isometry3f from_scan = scan_from_model.inverse().cast<float>();
  const auto add = [&](const Eigen::Vector3f& in_model, const Eigen::Vector3f& in_scan,
                       const Eigen::Vector3f& normal, double agreement, double squared) {
    const double weight = Weight(squared, reach_m) * agreement * agreement;
    if (weight <= 0) return;
    pairs.push_back(
        {in_model.cast<double>(), in_scan.cast<double>(), normal.cast<double>(), weight});
  };
  const bool faces_out = crop.normals_face_out;
  const float reach2 = static_cast<float>(reach_m * reach_m);
  for (std::size_t i = 0; i < crop.coarse.points.size(); ++i) {
    const auto found = model.sample_tree().Nearest(from_scan * crop.coarse.points[i]);
    if (found.squared_distance >= reach2) continue;
    const auto k = static_cast<std::size_t>(found.index);
    const Eigen::Vector3f normal = from_model.linear() * model.samples().normals[k];
    add(model.samples().points[k], crop.coarse.points[i], normal,
        Agreement(normal, crop.coarse.normals[i], !faces_out || model.two_sided()[k]),
        found.squared_distance);
  }
  if (crop.fine.points.empty()) return;
  const std::size_t step = std::max<std::size_t>(1, model.samples().points.size() / kCoarsePoints);
  for (std::size_t i = 0; i < model.samples().points.size(); i += step) {
    const Eigen::Vector3f& point = model.samples().points[i];
    const auto found = crop.tree.Nearest(from_model * point);
    if (found.squared_distance >= reach2) continue;
    const auto k = static_cast<std::size_t>(found.index);
    const Eigen::Vector3f normal = from_model.linear() * model.samples().normals[i];
    add(point, crop.fine.points[k], crop.fine.normals[k],
        Agreement(normal, crop.fine.normals[k], !faces_out || model.two_sided()[i]),
        found.squared_distance);
  }
}

/// Which face of the model a scan point belongs to, and where it lies from there.
struct Nearest {
  ModelSurface::Face face;
  Eigen::Vector3d direction;  ///< Unit; in which its distance changes.
};

/// Inside a face the distance changes along its normal. Beyond an edge it changes along the offset:
/// with the normal, scan that overhangs a table's top would not pull the table back below it. The
/// two faces at an edge are equally near; the one that is meant has the scan's side.
/// @param query, normal  The scan's point and normal in `object`.
Nearest NearestSide(const ModelSurface& model, const Eigen::Vector3d& query,
                    const ClosestPoint& closest, const Eigen::Vector3d& normal) {
  constexpr double kInside = 0.95, kAside_m = 1e-3;
  const ModelSurface::Face face = model.face(closest.triangle);
  const Eigen::Vector3d offset = query - closest.point;
  if (std::abs(offset.dot(face.normal)) >= kInside * closest.distance_m) return {face, face.normal};
  const Eigen::Vector3d direction = offset / closest.distance_m;
  const std::optional<ClosestPoint> aside =
      model.triangles().FindWithin(closest.point + kAside_m * (normal - direction), 2 * kAside_m);
  return {aside ? model.face(aside->triangle) : face, direction};
}

/// Closest points on the triangles for all scan points within `reach_m`, all of weight 1.
void FindFinePairs(const AlignmentCrop& crop, const ModelSurface& model,
                   const Eigen::Isometry3d& scan_from_model, double reach_m,
                   std::vector<PointPair>& pairs) {
  pairs.clear();
  constexpr double kLeastAgreement = 0.5;
  const Eigen::Isometry3d model_from_scan = scan_from_model.inverse();
  const Eigen::AlignedBox3d near(model.bounds().min().array() - reach_m,
                                 model.bounds().max().array() + reach_m);
  for (std::size_t i = 0; i < crop.fine.points.size(); ++i) {
    const Eigen::Vector3d in_scan = crop.fine.points[i].cast<double>();
    const Eigen::Vector3d query = model_from_scan * in_scan;
    if (!near.contains(query)) continue;
    const std::optional<ClosestPoint> closest = model.triangles().FindWithin(query, reach_m);
    if (!closest) continue;
    const Eigen::Vector3d normal = crop.fine.normals[i].cast<double>();
    const Nearest nearest = NearestSide(model, query, *closest, model_from_scan.linear() * normal);
    const double agreement =
        Agreement(Eigen::Vector3d(scan_from_model.linear() * nearest.face.normal), normal,
                  !crop.normals_face_out || nearest.face.two_sided);
    if (agreement < kLeastAgreement) continue;
    pairs.push_back({closest->point, in_scan, scan_from_model.linear() * nearest.direction, 1});
  }
}

double Distance(const PointPair& pair, const Eigen::Isometry3d& scan_from_model) {
  return (scan_from_model * pair.in_model - pair.in_scan).norm();
}

/// 1.48 times the median distance: the standard deviation of what is normally distributed.
double RobustSigma(const std::vector<PointPair>& pairs, const Eigen::Isometry3d& scan_from_model) {
  if (pairs.empty()) return 0;
  std::vector<double> distances;
  distances.reserve(pairs.size());
  for (const PointPair& pair : pairs) distances.push_back(Distance(pair, scan_from_model));
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return 1.4826 * *middle;
}

/// How far pairs may be apart, by the direction in which they are: along which of the model's axes
/// most. A scan is sharp where it is flat and blunt at its rims; one scale for both would be that
/// of the wide faces, and a blunt rim would be fitted exactly on one side and ignored on the other.
class PairScale {
 public:
  double widest_m() const { return *std::max_element(reach_m_.begin(), reach_m_.end()); }

  /// @param sigma_m  Of all pairs: what holds where an axis has few, and the least of any.
  void Update(const std::vector<PointPair>& pairs, const Eigen::Isometry3d& scan_from_model,
              double sigma_m) {
    std::array<std::vector<PointPair>, 3> by_axis;
    for (const PointPair& pair : pairs) by_axis[AxisOf(pair, scan_from_model)].push_back(pair);
    for (std::size_t axis = 0; axis < by_axis.size(); ++axis) {
      const bool known = by_axis[axis].size() >= kFewest;
      const double own_m = known ? RobustSigma(by_axis[axis], scan_from_model) : 0;
      precision_[axis] = own_m > sigma_m ? Squared(sigma_m / own_m) : 1;
      reach_m_[axis] = std::clamp(kTukey * std::max(sigma_m, own_m), kLeastReach_m,
                                  known ? kMostReach_m : kReach_m);
    }
  }

  void Weigh(const Eigen::Isometry3d& scan_from_model, std::vector<PointPair>& pairs) const {
    for (PointPair& pair : pairs) {
      pair.weight =
          Weight(Squared(Distance(pair, scan_from_model)), reach_m_[AxisOf(pair, scan_from_model)]);
    }
  }

 private:
  static constexpr std::size_t kFewest = 10;
  static constexpr double kTukey = 4.685, kReach_m = 0.03, kLeastReach_m = 1e-3;
  static constexpr double kMostReach_m = 0.06;

  static std::size_t AxisOf(const PointPair& pair, const Eigen::Isometry3d& scan_from_model) {
    Eigen::Index axis = 0;
    (scan_from_model.linear().transpose() * pair.normal_in_scan).cwiseAbs().maxCoeff(&axis);
    return static_cast<std::size_t>(axis);
  }

  std::array<double, 3> reach_m_ = {kReach_m, kReach_m, kReach_m};
  std::array<double, 3> precision_ = {1, 1, 1};  ///< Against the pairs as a whole.
};

}  // namespace

AlignmentCrop CropScan(const ScanTarget& scan, const ModelSurface& model,
                       const Eigen::Isometry3d& scan_from_model, const Eigen::Vector3d& up_in_scan,
                       double search_m) {
  const Eigen::Vector3d origin = scan_from_model.translation();
  double radius_m = 0, lowest_m = 1e30, highest_m = -1e30;
  for (const Eigen::Vector3f& point : model.samples().points) {
    const Eigen::Vector3d offset = scan_from_model.linear() * point.cast<double>();
    const double height = offset.dot(up_in_scan);
    radius_m = std::max(radius_m, (offset - height * up_in_scan).norm());
    lowest_m = std::min(lowest_m, height);
    highest_m = std::max(highest_m, height);
  }
  const double middle_m = 0.5 * (lowest_m + highest_m);
  const double half_m = 0.5 * (highest_m - lowest_m) + search_m;
  radius_m += search_m;
  const Eigen::Vector3d center = origin + middle_m * up_in_scan;
  std::vector<int> inside;
  for (const int i :
       scan.tree().Within(center.cast<float>(), static_cast<float>(std::hypot(radius_m, half_m)))) {
    const Eigen::Vector3d offset =
        scan.points().points[static_cast<std::size_t>(i)].cast<double>() - center;
    const double height = offset.dot(up_in_scan);
    if (std::abs(height) <= half_m && (offset - height * up_in_scan).norm() <= radius_m) {
      inside.push_back(i);
    }
  }
  OrientedPoints all = Select(scan.points(), inside);
  const double base_m = origin.dot(up_in_scan) + lowest_m;
  const double footprint_m2 = model.bounds().sizes().x() * model.bounds().sizes().y();
  const std::optional<double> support = SupportHeight(
      all, up_in_scan, base_m - search_m, base_m + std::min(search_m, 0.3 * (highest_m - lowest_m)),
      std::max(0.7 * footprint_m2, 0.02));
  if (support) {
    std::vector<int> above;
    const Eigen::Vector3f up = up_in_scan.cast<float>();
    for (std::size_t i = 0; i < all.points.size(); ++i) {
      if (all.points[i].dot(up) > *support + kSupportThickness_m) {
        above.push_back(static_cast<int>(i));
      }
    }
    all = Select(all, above);
  }
  AlignmentCrop crop;
  crop.support_m = support;
  crop.foot_m = lowest_m;
  crop.normals_face_out = scan.normals_face_out();
  crop.fine = Select(all, VoxelSample(all.points, kFineVoxel_m, kFinePoints));
  crop.coarse = Select(crop.fine, VoxelSample(crop.fine.points, kCoarseVoxel_m, kCoarsePoints));
  crop.tree = PointTree(crop.fine.points);
  return crop;
}

int AlignCoarsely(const AlignmentCrop& crop, const ModelSurface& model, double reach_m,
                  ConstrainedPose& pose, double least_reach_m) {
  constexpr double kPlanesBelow_m = 0.08, kShrink = 0.75;
  constexpr int kIterationsPerReach = 3;
  std::vector<PointPair> pairs;
  int iterations = 0;
  for (double reach = reach_m; reach >= least_reach_m; reach *= kShrink) {
    for (int i = 0; i < kIterationsPerReach; ++i, ++iterations) {
      FindCoarsePairs(crop, model, pose.scan_from_model(), reach, pairs);
      if (reach < kPlanesBelow_m) {
        if (pose.StepPlanes(pairs) < 1e-4) break;
      } else if (!pose.FitPoints(pairs).ok()) {
        return iterations;
      }
    }
  }
  return iterations;
}

/// The foot on the support, as a pair that weighs as much as the pairs of the scan do if it is good
/// to 1 cm and `effect` of them are one measurement.
PointPair FootOnSupport(const AlignmentCrop& crop, const ConstrainedPose& pose, double sigma_m,
                        double effect) {
  constexpr double kSigma_m = 0.01;
  const Eigen::Vector3d& up = pose.up_in_scan();
  const Eigen::Isometry3d& scan_from_model = pose.scan_from_model();
  const Eigen::Vector3d foot = scan_from_model.translation() + crop.foot_m * up;
  return {scan_from_model.inverse() * foot, foot - crop.Gap(scan_from_model, up) * up, up,
          effect * Squared(sigma_m / kSigma_m)};
}

FineAlignment AlignFinely(const AlignmentCrop& crop, const ModelSurface& model,
                          IcpResidual residual, int max_iterations, ConstrainedPose& pose) {
  constexpr double kConverged = 1e-8;
  constexpr double kUsualEffect = 10;
  constexpr int kSettling = 10;  // The scale settles first; then it stays, so that this can end.
  const bool stands = crop.support_m && std::abs(crop.Gap(pose.scan_from_model(),
                                                          pose.up_in_scan())) < kStandsWithin_m;
  constexpr double kPatch_m = 0.15;  // What a fused scan errs together over.
  FineAlignment result;
  std::vector<PointPair> pairs;
  PairScale scale;
  while (result.iterations < max_iterations && !result.converged) {
    ++result.iterations;
    FindFinePairs(crop, model, pose.scan_from_model(), scale.widest_m(), pairs);
    result.sigma_m = RobustSigma(pairs, pose.scan_from_model());
    if (result.iterations <= kSettling) scale.Update(pairs, pose.scan_from_model(), result.sigma_m);
    scale.Weigh(pose.scan_from_model(), pairs);
    const Eigen::Isometry3d before = pose.scan_from_model();
    if (residual == IcpResidual::kPointToPlane) {
      if (stands) pairs.push_back(FootOnSupport(crop, pose, result.sigma_m, kUsualEffect));
      pose.StepPlanes(pairs);
    } else if (!pose.FitPoints(pairs).ok()) {
      break;
    }
    const double moved = (pose.scan_from_model().translation() - before.translation()).norm() +
                         (pose.scan_from_model().linear() - before.linear()).norm();
    result.converged = moved < kConverged;
  }
  if (stands && residual == IcpResidual::kPointToPlane && !pairs.empty()) pairs.pop_back();
  const double effect = pose.DesignEffect(pairs, kPatch_m);
  if (stands) pairs.push_back(FootOnSupport(crop, pose, result.sigma_m, effect));
  result.covariance =
      pose.WidenedByParts(pairs, pose.PlaneCovariance(pairs, std::sqrt(effect) * result.sigma_m));
  return result;
}

AlignmentFit Measure(const AlignmentCrop& crop, const ModelSurface& model,
                     const Eigen::Isometry3d& scan_from_model, double within_m) {
  constexpr std::size_t kStep = 4;
  AlignmentFit fit;
  if (crop.fine.points.empty()) return fit;
  const Eigen::Isometry3f from_model = scan_from_model.cast<float>();
  const double within2 = within_m * within_m;
  std::size_t looked_at = 0, covered = 0;
  double model_score = 0;
  for (std::size_t i = 0; i < model.samples().points.size(); i += kStep, ++looked_at) {
    const auto found = crop.tree.Nearest(from_model * model.samples().points[i]);
    if (found.squared_distance >= within2) continue;
    const double agreement =
        Agreement(Eigen::Vector3f(from_model.linear() * model.samples().normals[i]),
                  crop.fine.normals[static_cast<std::size_t>(found.index)],
                  !crop.normals_face_out || model.two_sided()[i]);
    ++covered;
    model_score += agreement * (1 - found.squared_distance / within2);
  }
  fit.fitness = static_cast<double>(covered) / static_cast<double>(looked_at);
  std::vector<PointPair> pairs;
  FindFinePairs(crop, model, scan_from_model, within_m, pairs);
  double squares = 0;
  for (const PointPair& pair : pairs) squares += Squared(Distance(pair, scan_from_model));
  const auto count = static_cast<double>(pairs.size());
  fit.rmse_m = count > 0 ? std::sqrt(squares / count) : 0;
  const double scan_score =
      (count - squares / within2) / static_cast<double>(crop.fine.points.size());
  fit.score = model_score / static_cast<double>(looked_at) + scan_score;
  return fit;
}

}  // namespace plumbline
