// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/viewpoint_model.h"

#include <gmock/gmock.h>
#include <cstring>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "engine/base/files.h"
#include "engine/geometry/angles.h"
#include "engine/render/renderer.h"
#include "tests/support/furniture_models.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

CadModel ModelOf(TriangleMesh mesh, int symmetry_order = 1) {
  CadModel model;
  model.name = "shape";
  model.mesh = std::move(mesh);
  model.symmetry.order = symmetry_order;
  return ModelDatabase::FromModels({model})->models().front();
}

/// Of the contour alone.
ViewpointModelOptions FewViews() {
  ViewpointModelOptions options;
  options.inner_weight = 0;
  options.azimuths = 15;
  options.elevations = 3;
  options.distances = {1.3, 3.0};
  return options;
}

std::shared_ptr<const ViewpointModel> Built(const CadModel& model,
                                            const ViewpointModelOptions& options) {
  Result<std::shared_ptr<const ViewpointModel>> built = ViewpointModel::Build(model, options, {});
  EXPECT_TRUE(built.ok());
  return *built;
}

/// A camera that looks at the model's centre, with the focal length that the views are made with.
struct Viewpoint {
  PinholeCamera camera;
  Eigen::Isometry3d cam_from_object;
  Eigen::Vector3f camera_in_object;
  double distance = 0;
};

std::vector<Viewpoint> ViewpointsOf(const CadModel& model, const ViewpointModelOptions& options) {
  float radius = 0;
  for (const Eigen::Vector3f& vertex : model.mesh.vertices)
    radius = std::max(radius, (vertex - model.bounds.center()).norm());
  std::vector<Viewpoint> viewpoints;
  for (const double ratio : options.distances) {
    for (int e = 0; e < options.elevations; ++e) {
      const double elevation =
          kRadPerDeg *
          (options.min_elevation_deg +
           (options.max_elevation_deg - options.min_elevation_deg) * e / (options.elevations - 1));
      for (int a = 0; a < options.azimuths; ++a) {
        const double azimuth = 2 * std::numbers::pi * a / options.azimuths;
        const Eigen::Vector3d from_center(std::cos(elevation) * std::cos(azimuth),
                                          std::cos(elevation) * std::sin(azimuth),
                                          std::sin(elevation));
        Viewpoint viewpoint;
        viewpoint.distance = ratio * radius;
        const Eigen::Vector3d origin = model.center() + viewpoint.distance * from_center;
        Eigen::Matrix3d axes;
        axes.col(2) = -from_center;
        axes.col(0) = axes.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
        axes.col(1) = axes.col(2).cross(axes.col(0));
        Eigen::Isometry3d object_from_cam = Eigen::Isometry3d::Identity();
        object_from_cam.linear() = axes;
        object_from_cam.translation() = origin;
        viewpoint.cam_from_object = object_from_cam.inverse();
        viewpoint.camera_in_object = origin.cast<float>();
        const double sine = std::min(radius / viewpoint.distance, std::sin(65 * kRadPerDeg));
        const double focal = (options.image_px - 12) * std::sqrt(1 - sine * sine) / (2 * sine);
        const double middle = 0.5 * (options.image_px - 1);
        viewpoint.camera = {options.image_px, options.image_px, focal, focal, middle, middle};
        viewpoints.push_back(viewpoint);
      }
    }
  }
  return viewpoints;
}

/// One contour point and its normal in the image.
struct Projected {
  cv::Point2d pixel;
  cv::Point2d normal;
};

std::vector<Projected> Project(const ContourView& view, const Viewpoint& viewpoint) {
  std::vector<Projected> points;
  for (int i = 0; i < view.size; ++i) {
    const Eigen::Vector3d p =
        viewpoint.cam_from_object * Eigen::Vector3d(view.x[i], view.y[i], view.z[i]);
    const Eigen::Vector3d n =
        viewpoint.cam_from_object.linear() * Eigen::Vector3d(view.nx[i], view.ny[i], view.nz[i]);
    EXPECT_NEAR(n.norm(), 1, 1e-4);
    EXPECT_NEAR(n.z(), 0, 1e-4) << "normals are parallel to the image";
    const Eigen::Vector2d pixel = viewpoint.camera.Project(p);
    points.push_back({{pixel.x(), pixel.y()}, {n.x(), n.y()}});
  }
  return points;
}

/// The silhouette of a convex mesh: the convex hull of its corners' projections.
class ConvexSilhouette {
 public:
  ConvexSilhouette(const TriangleMesh& mesh, const Viewpoint& viewpoint) {
    std::vector<cv::Point2f> corners;
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      const Eigen::Vector2d pixel =
          viewpoint.camera.Project(viewpoint.cam_from_object * vertex.cast<double>());
      corners.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
    }
    cv::convexHull(corners, hull_);
  }
  /// [px], positive inside.
  double Inside(const cv::Point2d& pixel) const {
    return cv::pointPolygonTest(hull_, cv::Point2f(pixel), true);
  }
  double Length() const { return cv::arcLength(hull_, true); }
  /// Outward normal of the side nearest to a pixel; nothing near corners that bend.
  std::optional<cv::Point2d> Normal(const cv::Point2d& pixel) const {
    std::optional<cv::Point2d> normal;
    for (std::size_t i = 0; i < hull_.size(); ++i) {
      const cv::Point2d a = hull_[i], b = hull_[(i + 1) % hull_.size()];
      const double length = cv::norm(b - a);
      if (length < 1e-6) continue;
      const cv::Point2d along = (b - a) / length;
      const double t = (pixel - a).dot(along);
      const cv::Point2d across(along.y, -along.x);
      const double away = std::abs((pixel - a).dot(across));
      if (away > 2 || t < -4 || t > length + 4) continue;
      const double sign = Inside((a + b) / 2 + across) < Inside((a + b) / 2 - across) ? 1 : -1;
      if (normal && normal->dot(sign * across) < std::cos(8 * kRadPerDeg)) return std::nullopt;
      normal = sign * across;
    }
    return normal;
  }

 private:
  std::vector<cv::Point2f> hull_;
};

void ExpectOnSilhouette(const CadModel& model, const ViewpointModelOptions& options,
                        double tolerance_px) {
  const std::shared_ptr<const ViewpointModel> views = Built(model, options);
  int compared = 0, off = 0, judged = 0, turned = 0;
  double sum_rad = 0;
  for (const Viewpoint& viewpoint : ViewpointsOf(model, options)) {
    const ContourView view = views->View(viewpoint.camera_in_object);
    ASSERT_NEAR(view.size, options.points, 2);
    const ConvexSilhouette silhouette(model.mesh, viewpoint);
    for (const Projected& point : Project(view, viewpoint)) {
      ++compared;
      off += std::abs(silhouette.Inside(point.pixel)) > tolerance_px;
      const std::optional<cv::Point2d> normal = silhouette.Normal(point.pixel);
      if (!normal) continue;
      const double error_rad = std::acos(std::min(1.0, normal->dot(point.normal)));
      ++judged;
      sum_rad += error_rad;
      turned += error_rad > 16 * kRadPerDeg;
    }
    const double length_m = silhouette.Length() / viewpoint.camera.fx * viewpoint.distance;
    EXPECT_NEAR(view.length_per_point_m * static_cast<float>(view.size), length_m,
                0.025 * length_m);
  }
  EXPECT_EQ(off, 0) << "of " << compared << " points lie off the silhouette";
  // Half a bin of the search table is 5.6 degrees; it accepts 25.
  EXPECT_LE(sum_rad / judged, 5 * kRadPerDeg);
  // A corner seen at 176 pixels may point along its other side.
  EXPECT_LE(turned, 0.004 * judged) << "of " << judged << " normals point elsewhere";
}

TEST(ViewpointModel, PointsOfABoxLieOnItsSilhouetteAndNormalsPointOutward) {
  ExpectOnSilhouette(ModelOf(MakeBox({-0.3f, -0.2f, 0}, {0.3f, 0.2f, 0.5f})), FewViews(), 0.5);
}

TEST(ViewpointModel, PointsOfACylinderLieOnItsSilhouetteAndNormalsPointOutward) {
  ExpectOnSilhouette(ModelOf(MakeCylinder(0.2f, 0.5f, 90)), FewViews(), 0.5);
}

TEST(ViewpointModel, PointsOfASphereLieOnItsOutline) {
  const double radius = 0.4;
  const CadModel model = ModelOf(MakeSphere(static_cast<float>(radius), 60));
  const ViewpointModelOptions options = FewViews();
  const auto views = Built(model, options);
  for (const Viewpoint& viewpoint : ViewpointsOf(model, options)) {
    const double sine = radius / viewpoint.distance;
    const double outline_px = viewpoint.camera.fx * sine / std::sqrt(1 - sine * sine);
    const cv::Point2d middle(viewpoint.camera.cx, viewpoint.camera.cy);
    for (const Projected& point : Project(views->View(viewpoint.camera_in_object), viewpoint)) {
      const double from_middle = cv::norm(point.pixel - middle);
      EXPECT_NEAR(from_middle, outline_px, 0.5);
      EXPECT_GT(point.normal.dot((point.pixel - middle) / from_middle), std::cos(16 * kRadPerDeg));
    }
  }
}

TEST(ViewpointModel, ABodyOfRevolutionLooksTheSameFromEveryAzimuth) {
  // As many sides as views, so that the mesh itself looks the same from all of them.
  ViewpointModelOptions options = FewViews();
  const CadModel model = ModelOf(MakeCylinder(0.2f, 0.5f, 6 * options.azimuths), 0);
  ExpectOnSilhouette(model, options, 0.5);
  const auto views = Built(model, options);
  const std::vector<Viewpoint> viewpoints = ViewpointsOf(model, options);
  const std::vector<Projected> first =
      Project(views->View(viewpoints[0].camera_in_object), viewpoints[0]);
  const std::vector<Projected> other =
      Project(views->View(viewpoints[4].camera_in_object), viewpoints[4]);
  ASSERT_EQ(first.size(), other.size());
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_LT(cv::norm(first[i].pixel - other[i].pixel), 0.01);
}

TEST(ViewpointModel, CreasesAreNoContour) {
  // From some of these viewpoints a side shows one pixel wide: a step in depth, but of no contour.
  ViewpointModelOptions options = FewViews();
  options.azimuths = 40;
  options.elevations = 2;
  options.distances = {3.2};
  ExpectOnSilhouette(ModelOf(MakeBox({-0.3f, -0.2f, 0}, {0.3f, 0.2f, 0.5f})), options, 0.5);
}

/// The rendered contour is the same set of lines: silhouette and depth steps.
TEST(ViewpointModel, FollowsTheRenderersContourOfShapesWithInnerSteps) {
  const CadModel model = ModelOf(MakeChair(true));
  ViewpointModelOptions options = FewViews();
  options.points = 512;
  const auto views = Built(model, options);
  int points = 0, far_points = 0, pixels = 0, far_pixels = 0;
  for (const Viewpoint& viewpoint : ViewpointsOf(model, options)) {
    const TriangleMesh* mesh = &model.mesh;
    RenderOptions render;
    render.contour = true;
    render.contour_step_m = options.contour_step_m;
    const RenderInstance instance{0, viewpoint.cam_from_object, 1};
    const RenderedMaps maps = RayCast(viewpoint.camera, {&mesh, 1}, {&instance, 1}, render);
    cv::Mat to_contour, to_points;
    cv::distanceTransform(maps.contour == 0, to_contour, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::Mat no_point(maps.contour.size(), CV_8U, cv::Scalar(255));
    for (const Projected& point : Project(views->View(viewpoint.camera_in_object), viewpoint)) {
      const cv::Point at(cvRound(point.pixel.x), cvRound(point.pixel.y));
      no_point.at<std::uint8_t>(at) = 0;
      ++points;
      far_points += to_contour.at<float>(at) > 2;
    }
    cv::distanceTransform(no_point, to_points, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    pixels += cv::countNonZero(maps.contour);
    far_pixels += cv::countNonZero((maps.contour != 0) & (to_points > 8));
  }
  EXPECT_LE(far_points, 0.01 * points);
  EXPECT_LE(far_pixels, 0.02 * pixels);
}

/// A box of two halves of different colour, x < 0 and x > 0.
TriangleMesh TwoColouredBox() {
  TriangleMesh left = MakeBox({-0.3f, -0.2f, 0}, {0, 0.2f, 0.5f});
  TriangleMesh right = MakeBox({0, -0.2f, 0}, {0.3f, 0.2f, 0.5f});
  left.colors.assign(left.vertices.size(), {230, 230, 230});
  right.colors.assign(right.vertices.size(), {90, 60, 40});
  Append(right, left);
  return left;
}

TEST(ViewpointModel, InnerLinesAreCreasesAndStepsOfColour) {
  const CadModel model = ModelOf(TwoColouredBox());
  ViewpointModelOptions options = FewViews();
  options.inner_weight = 0.5;
  const auto views = Built(model, options);
  ViewpointModelOptions outline = FewViews();
  const auto outlines = Built(model, outline);
  int creases = 0, marks = 0, turned = 0;
  double sum_rad = 0;
  for (const Viewpoint& viewpoint : ViewpointsOf(model, options)) {
    const ContourView view = views->View(viewpoint.camera_in_object);
    const ContourView alone = outlines->View(viewpoint.camera_in_object);
    ASSERT_LE(view.outline_size, view.size);
    EXPECT_EQ(alone.outline_size, alone.size);
    // A point stands for the same length of contour as of weighted inner lines.
    EXPECT_NEAR(view.length_per_point_m * static_cast<float>(view.outline_size),
                alone.length_per_point_m * static_cast<float>(alone.size),
                1.5f * view.length_per_point_m);
    const float pixel_m = static_cast<float>(viewpoint.distance / viewpoint.camera.fx);
    for (int i = view.outline_size; i < view.size; ++i) {
      const float to_mark = std::abs(view.x[i]);
      const float sides[] = {0.3f - std::abs(view.x[i]), 0.2f - std::abs(view.y[i]),
                             std::min(view.z[i], 0.5f - view.z[i])};
      // On an edge of the box two of its sides meet.
      int near_sides = 0;
      for (const float side : sides) near_sides += std::abs(side) < 1.5f * pixel_m ? 1 : 0;
      const bool crease = near_sides >= 2, mark = to_mark < 1.5f * pixel_m;
      EXPECT_TRUE(crease || mark) << view.x[i] << ' ' << view.y[i] << ' ' << view.z[i];
      creases += crease ? 1 : 0;
      marks += mark && !crease ? 1 : 0;
      if (!mark || crease) continue;
      // The mark runs along y on the top and along z on the sides; the normal lies across.
      const Eigen::Vector3d point(view.x[i], view.y[i], view.z[i]);
      const bool on_top = view.z[i] > 0.5f - 1.5f * pixel_m;
      const Eigen::Vector3d along = on_top ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
      const Eigen::Vector2d line =
          viewpoint.camera.Project(viewpoint.cam_from_object * (point + 0.01 * along)) -
          viewpoint.camera.Project(viewpoint.cam_from_object * point);
      const Eigen::Vector3d normal =
          viewpoint.cam_from_object.linear() * Eigen::Vector3d(view.nx[i], view.ny[i], view.nz[i]);
      const double off_rad = std::asin(std::abs(line.normalized().dot(normal.head<2>())));
      sum_rad += off_rad;
      turned += off_rad > 16 * kRadPerDeg ? 1 : 0;
    }
  }
  EXPECT_GT(creases, 2000);
  EXPECT_GT(marks, 500);
  EXPECT_LT(sum_rad / marks, 5 * kRadPerDeg);
  EXPECT_LE(turned, 0.06 * marks) << "of " << marks << ": where the mark ends, the window is cut";
}

TEST(ViewpointModel, AMarkBesideTheContourIsItsRim) {
  // A screen in a frame 2 cm wide, a millimetre proud of it, seen from the front.
  TriangleMesh framed = MakeBox({-0.02f, -0.3f, 0}, {0.02f, 0.3f, 0.4f});
  framed.colors.assign(framed.vertices.size(), {30, 30, 30});
  TriangleMesh plain = framed;
  TriangleMesh screen = MakeBox({0, -0.28f, 0.02f}, {0.021f, 0.28f, 0.38f});
  screen.colors.assign(screen.vertices.size(), {120, 140, 160});
  Append(screen, framed);
  const ViewpointModelOptions options = FewViews();
  const Eigen::Vector3f front(2, 0, 0.2f), back(-2, 0, 0.2f);
  const auto model = Built(ModelOf(framed), options);
  const ContourView view = model->View(front);
  int rimmed = 0;
  for (int i = 0; i < view.outline_size; ++i) {
    // Nearer to a corner than the window over which a normal is taken, it runs askew.
    const bool corner = std::abs(view.y[i]) > 0.26f && std::abs(view.z[i] - 0.2f) > 0.16f;
    if (corner) continue;
    EXPECT_NEAR(view.rim[i], 0.02f, 0.006f) << view.y[i] << ' ' << view.z[i];
    ++rimmed;
  }
  EXPECT_GT(rimmed, 150);
  for (const ContourView& without :
       {model->View(back), Built(ModelOf(plain), options)->View(front)}) {
    for (int i = 0; i < without.outline_size; ++i) EXPECT_EQ(without.rim[i], 0);
  }
  for (int i = 0; i < view.size; ++i) {
    const bool outline = i < view.outline_size;
    EXPECT_NEAR(view.luminance[i], outline ? 30 / 255.0 : kUnknownLuminance, 0.01) << i;
  }
  framed.colors.clear();
  const auto bare = Built(ModelOf(framed), options);
  for (int i = 0; i < bare->View(front).size; ++i)
    EXPECT_EQ(bare->View(front).luminance[i], kUnknownLuminance);
  // A mark further inside is a line of its own.
  ViewpointModelOptions narrow = options;
  narrow.rim_m = 0.01;
  const auto narrow_model = Built(ModelOf(framed), narrow);
  const ContourView apart = narrow_model->View(front);
  for (int i = 0; i < apart.outline_size; ++i) EXPECT_EQ(apart.rim[i], 0);
}

TEST(ViewpointModel, TakesTheNearestView) {
  const CadModel model = ModelOf(MakeBox({-0.3f, -0.2f, 0}, {0.3f, 0.2f, 0.5f}));
  const ViewpointModelOptions options = FewViews();
  const auto views = Built(model, options);
  for (const Viewpoint& viewpoint : ViewpointsOf(model, options)) {
    const ContourView exact = views->View(viewpoint.camera_in_object);
    const Eigen::Vector3f center = model.bounds.center();
    const Eigen::Vector3f from_center = viewpoint.camera_in_object - center;
    const Eigen::Vector3f near =
        center +
        1.05f * (Eigen::AngleAxisf(static_cast<float>(8 * kRadPerDeg), Eigen::Vector3f::UnitZ()) *
                 from_center);
    EXPECT_EQ(views->View(near).x, exact.x);
  }
  // Beyond the range of views the outermost ones serve; inside the object too.
  for (const Eigen::Vector3f& odd : {Eigen::Vector3f(0, 0, 50), Eigen::Vector3f(0, 0, -50),
                                     Eigen::Vector3f(100, 0, 0), model.bounds.center().eval()}) {
    EXPECT_GT(views->View(odd).size, 0);
  }
}

class ViewpointCache : public testing::Test {
 protected:
  std::shared_ptr<const ViewpointModel> Load(const CadModel& model) {
    Result<std::shared_ptr<const ViewpointModel>> loaded =
        ViewpointModel::LoadOrBuild(model, options_, folder_.path(), {});
    EXPECT_TRUE(loaded.ok());
    return *loaded;
  }
  std::vector<std::filesystem::path> Files() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      files.push_back(entry.path());
    return files;
  }
  void ExpectSame(const ViewpointModel& a, const ViewpointModel& b, const CadModel& model) {
    EXPECT_EQ(a.bounding_radius(), b.bounding_radius());
    for (const Viewpoint& viewpoint : ViewpointsOf(model, options_)) {
      const ContourView va = a.View(viewpoint.camera_in_object);
      const ContourView vb = b.View(viewpoint.camera_in_object);
      ASSERT_EQ(va.size, vb.size);
      EXPECT_EQ(va.length_per_point_m, vb.length_per_point_m);
      EXPECT_TRUE(std::equal(va.x, va.x + 8 * va.size, vb.x));
    }
  }
  TemporaryFolder folder_;
  ViewpointModelOptions options_ = [] {
    ViewpointModelOptions options;
    options.azimuths = 6;
    options.elevations = 2;
    options.distances = {2.0};
    return options;
  }();
  CadModel model_ = ModelOf(MakeBox({-0.3f, -0.2f, 0}, {0.3f, 0.2f, 0.5f}));
};

TEST_F(ViewpointCache, GivesBackWhatWasBuilt) {
  const auto built = Load(model_);
  ASSERT_EQ(Files().size(), 1u);
  const auto written = std::filesystem::last_write_time(Files().front());
  ExpectSame(*built, *Load(model_), model_);
  EXPECT_EQ(std::filesystem::last_write_time(Files().front()), written) << "read, not rebuilt";
}

TEST_F(ViewpointCache, RebuildsADamagedFile) {
  const auto built = Load(model_);
  const std::filesystem::path file = Files().front();
  const std::string good = *ReadFile(file);
  std::string flipped = good;
  flipped[good.size() / 2] ^= 4;
  for (const std::string& bad : {flipped, good.substr(0, good.size() / 2), good.substr(0, 16),
                                 std::string("x"), std::string(), good + "more"}) {
    ASSERT_TRUE(WriteFileAtomically(file, bad).ok());
    ExpectSame(*built, *Load(model_), model_);
    EXPECT_TRUE(*ReadFile(file) == good) << "the cache is whole again";
  }
}

TEST_F(ViewpointCache, TakesNoViewThatReachesBeyondThePoints) {
  const std::string good = Load(model_)->Encode();
  ASSERT_NE(ViewpointModel::Decode(good, options_), nullptr);
  std::string beyond = good;
  constexpr std::size_t kSecondView = 8 + 4 * sizeof(float) + 8 + sizeof(std::int32_t);
  const std::int32_t far = 1 << 30;
  std::memcpy(&beyond[kSecondView], &far, sizeof(far));
  EXPECT_EQ(ViewpointModel::Decode(beyond, options_), nullptr);
  ViewpointModelOptions more = options_;
  more.azimuths = 7;
  EXPECT_EQ(ViewpointModel::Decode(good, more), nullptr) << "that many views it has not";
}

TEST_F(ViewpointCache, TellsShapesAndOptionsApart) {
  Load(model_);
  Load(ModelOf(MakeBox({-0.3f, -0.2f, 0}, {0.3f, 0.2f, 0.51f})));
  EXPECT_EQ(Files().size(), 2u);
  options_.points = 100;
  Load(model_);
  EXPECT_EQ(Files().size(), 3u);
}

TEST_F(ViewpointCache, AFolderThatCannotBeWrittenCostsOnlyTime) {
  const std::filesystem::path file = folder_.path() / "file";
  std::ofstream(file) << "not a folder";
  const auto loaded = ViewpointModel::LoadOrBuild(model_, options_, file, {});
  ASSERT_TRUE(loaded.ok());
  EXPECT_GT((*loaded)->View({3, 0, 0}).size, 0);
}

TEST_F(ViewpointCache, BuildingCanBeCancelled) {
  std::stop_source stop;
  stop.request_stop();
  WorkContext work;
  work.stop = stop.get_token();
  const auto loaded = ViewpointModel::LoadOrBuild(model_, options_, folder_.path(), work);
  ASSERT_FALSE(loaded.ok());
  EXPECT_EQ(loaded.error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(Files().empty());
}

}  // namespace
}  // namespace plumbline
