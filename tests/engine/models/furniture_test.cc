// SPDX-License-Identifier: Apache-2.0
// Furniture as its makers published it, with nothing stated: what `models build` makes of each. The
// truth is the table in the README.md beside the files. Prints the report of
// docs/algorithms/models.md.
#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "engine/base/files.h"
#include "engine/geometry/surface_sampling.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_builder.h"
#include "engine/models/textured_mesh.h"
#include "engine/vision/model_lines.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

struct Truth {
  std::string name;
  Eigen::Vector3d size_m;
  std::vector<std::string> fronts;  ///< Any of them is right; empty: it has none.
  std::vector<std::string> categories;
};

std::vector<std::string> Split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, at);) {
    const std::size_t first = part.find_first_not_of(' '), last = part.find_last_not_of(' ');
    parts.push_back(first == std::string::npos ? "" : part.substr(first, last - first + 1));
  }
  return parts;
}

/// Rows | name | triangles | size x, y, z [m] | front | COCO | what |
std::vector<Truth> ReadTruth(const std::filesystem::path& folder) {
  std::vector<Truth> truths;
  std::ifstream file(folder / "README.md");
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> cells = Split(line, '|');
    if (cells.size() < 7 || !std::filesystem::exists(folder / cells[1] / (cells[1] + ".obj")))
      continue;
    if (cells[1].empty()) continue;
    Truth truth;
    truth.name = cells[1];
    std::istringstream size(cells[3]);
    for (int i = 0; i < 3; ++i) size >> truth.size_m[i];
    for (const std::string& word : Split(cells[4], ' ')) {
      if (word.size() == 2 && ParseSignedAxis(word)) truth.fronts.push_back(word);
    }
    std::string names = cells[5];  // "dining table, rather -", "vase (potted plant)"
    for (const char c : {',', '('}) names = Split(names, c)[0];
    truth.categories = {"unknown", names};
    truths.push_back(truth);
  }
  return truths;
}

/// The OBJ with every length times `scale` and, if asked for, turned from z up to y up; its
/// materials stay where they are.
std::filesystem::path Turned(const std::filesystem::path& obj, bool y_up, double scale,
                             const std::filesystem::path& folder) {
  std::string text;
  std::ifstream file(obj);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    double x = 0, y = 0, z = 0;
    words >> kind >> x >> y >> z;
    if (kind == "mtllib") {
      std::filesystem::copy(obj.parent_path() / line.substr(7), folder,
                            std::filesystem::copy_options::overwrite_existing);
      std::error_code ignored;
      std::filesystem::remove(folder / "materials", ignored);
      std::filesystem::create_directory_symlink(obj.parent_path() / "materials",
                                                folder / "materials");
    } else if (kind == "v" || kind == "vn") {
      const double factor = kind == "v" ? scale : 1;
      char numbers[120];
      std::snprintf(numbers, sizeof(numbers), "%s %.9g %.9g %.9g", kind.c_str(), factor * x,
                    factor * (y_up ? z : y), factor * (y_up ? -y : z));
      line = numbers;
    }
    text += line + "\n";
  }
  EXPECT_TRUE(WriteFileAtomically(folder / obj.filename(), text).ok());
  return folder / obj.filename();
}

/// In the axes of the file as published, when the file was turned y up.
std::string AsPublished(const SignedAxis& axis, bool y_up) {
  if (!y_up || axis.axis == 0) return axis.text();
  return axis.axis == 1 ? SignedAxis{2, axis.sign}.text() : SignedAxis{1, -axis.sign}.text();
}

struct Tally {
  int right = 0, asked = 0, wrong = 0, right_though_asked = 0;

  std::string Count(bool is_right, double confidence) {
    const bool sure = confidence >= kSureGuess;
    (sure ? (is_right ? right : wrong) : asked) += 1;
    right_though_asked += !sure && is_right;
    char text[32];
    std::snprintf(text, sizeof(text), "%s %3.0f %%",
                  sure ? (is_right ? "right" : "WRONG") : (is_right ? "asked" : "asked, no"),
                  100 * confidence);
    return confidence == 1 && is_right ? "right" : text;
  }
  std::string Row(int of) const {
    char text[96];
    std::snprintf(text, sizeof(text), "%d right, %d asked (%d of them right), %d wrong, of %d",
                  right, asked, right_though_asked, wrong, of);
    return text;
  }
};

/// Marks of the views around it [px of a view's lines]: what colours add to the lines.
double MarksOf(const TriangleMesh& mesh) {
  TriangleMesh plain = mesh;
  plain.colors.clear();
  const Eigen::AlignedBox3f box = BoundingBox(mesh);
  const float radius = 0.5f * box.diagonal().norm();
  double marks = 0;
  constexpr int kViews = 12;
  for (int view = 0; view < kViews; ++view) {
    const double azimuth = 2 * std::numbers::pi * view / kViews, elevation = 0.35;
    const Eigen::Vector3f toward =
        Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                        std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
            .cast<float>();
    ViewpointModelOptions options;
    const ViewCamera camera = CameraAt(box.center(), toward, 2 * radius, radius, options.image_px);
    const float step = static_cast<float>(std::min(options.contour_step_m, 0.3 * double{radius}));
    marks += (SampleLines(RayScene(mesh), camera, step, options).length_px -
              SampleLines(RayScene(plain), camera, step, options).length_px) /
             kViews;
  }
  return marks;
}

/// How far the colours of the faces are from the texture that is kept beside them: the mean over
/// the surface [grey levels].
double ColorsOff(const BuiltModel& built) {
  const TriangleMesh& mesh = built.model.mesh;
  const auto samples = SampleSurface(mesh, 4000, 1).value();
  double sum = 0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(samples.triangles[i])];
    const auto at = [&](int c) {
      return mesh.vertices[static_cast<std::size_t>(t[c])].cast<double>();
    };
    const Eigen::Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0));
    Eigen::Vector3f painted(0, 0, 0);
    Eigen::Vector2f uv(0, 0);
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d ahead = at((c + 1) % 3) - samples.points[i],
                            next = at((c + 2) % 3) - samples.points[i];
      const auto weight = static_cast<float>(ahead.cross(next).dot(normal) / normal.squaredNorm());
      const auto& rgb = mesh.colors[static_cast<std::size_t>(t[c])];
      painted += weight * Eigen::Vector3f(rgb[0], rgb[1], rgb[2]);
      uv += weight * mesh.texture_coordinates[static_cast<std::size_t>(t[c])];
    }
    sum += (painted - TexelAt(built.texture_image, uv)).cwiseAbs().mean();
  }
  return sum / static_cast<double>(samples.points.size());
}

class Furniture : public testing::Test {
 protected:
  void SetUp() override {
    const auto shared = SharedData();
    if (!shared || !std::filesystem::exists(*shared / "data/furniture/README.md"))
      GTEST_SKIP() << kNoSharedData;
    folder_ = *shared / "data/furniture";
    truths_ = ReadTruth(folder_);
    ASSERT_EQ(truths_.size(), 23u);
  }

  std::filesystem::path Obj(const Truth& truth) const {
    return folder_ / truth.name / (truth.name + ".obj");
  }

  /// Builds all with nothing stated, prints a table and returns the tallies of up, front, unit,
  /// category.
  std::map<std::string, Tally> Report(
      const std::string& title, bool y_up,
      const std::function<std::filesystem::path(const Truth&)>& file_of, double metres) const {
    std::map<std::string, Tally> tallies;
    std::printf("\n%s\n%-18s  %-16s  %-16s  %-16s  %s\n", title.c_str(), "", "up", "front", "unit",
                "category");
    for (const Truth& truth : truths_) {
      const auto built = BuildModel(file_of(truth), {});
      EXPECT_TRUE(built.ok()) << built.error().message;
      if (!built.ok()) continue;
      const ModelBuildReport& report = built->report;
      const bool upright = AsPublished(report.up.value, y_up) == "+z";
      const std::string up = tallies["up"].Count(upright, report.up.confidence);
      std::string front = "(none)";
      const std::string said = AsPublished(report.front.value, y_up);
      const bool faces =
          std::find(truth.fronts.begin(), truth.fronts.end(), said) != truth.fronts.end();
      if (!truth.fronts.empty() && report.has_front) {
        front = tallies["front"].Count(faces, report.front.confidence);
      } else if (!truth.fronts.empty()) {
        front = tallies["front"].Count(false, 1);  // It was said to have none.
      } else if (report.has_front && report.front.sure()) {
        front = tallies["front of what has none"].Count(false, report.front.confidence);
      }
      const bool unit_is = std::abs(report.unit.value / metres - 1) < 1e-3;
      const std::string unit = tallies["unit"].Count(unit_is, report.unit.confidence);
      const std::string& category = built->model.category;
      const bool is = std::find(truth.categories.begin(), truth.categories.end(), category) !=
                      truth.categories.end();
      tallies["category"].Count(is, 1);
      std::printf("%-18s  %-16s  %-16s  %-16s  %s%s\n", truth.name.c_str(), up.c_str(),
                  front.c_str(), unit.c_str(), category == "unknown" ? "none" : category.c_str(),
                  is ? "" : "  WRONG");
    }
    for (const auto& [what, tally] : tallies) {
      const int count = tally.right + tally.asked + tally.wrong;
      std::printf("%s: %s\n", what.c_str(), tally.Row(count).c_str());
      EXPECT_EQ(tally.wrong, 0) << title << ", " << what << ": said with over 80 %";
    }
    return tallies;
  }

  std::filesystem::path folder_;
  std::vector<Truth> truths_;
};

TEST_F(Furniture, AsPublishedInColladaIsUprightAndInScaleAsItsFilesState) {
  auto tallies = Report(
      "COLLADA as published", false,
      [&](const Truth& truth) {
        return folder_ / truth.name / "meshes" / ("aws_" + truth.name + "_visual.DAE");
      },
      0.01);
  EXPECT_EQ(tallies["up"].right, 23);
  EXPECT_EQ(tallies["unit"].right, 23);
  EXPECT_GE(tallies["front"].right + tallies["front"].right_though_asked, 13);
}

TEST_F(Furniture, ConvertedToObjIsUprightOrAskedAboutInEveryTurnAndUnit) {
  for (const bool y_up : {false, true}) {
    for (const double scale : {1.0, 100.0, 1000.0}) {
      const TemporaryFolder folder;
      char title[64];
      std::snprintf(title, sizeof(title), "OBJ, %s up, unit %g m", y_up ? "y" : "z", 1 / scale);
      auto tallies = Report(
          title, y_up,
          [&](const Truth& truth) { return Turned(Obj(truth), y_up, scale, folder.path()); },
          1 / scale);
      EXPECT_EQ(tallies["up"].right + tallies["up"].asked, 23);
      EXPECT_EQ(tallies["category"].right, 23);
      EXPECT_GE(tallies["front"].right + tallies["front"].right_though_asked, 13);
    }
  }
}

TEST_F(Furniture, WhoseNamesSayNothingIsUprightOrAskedAboutToo) {
  for (const bool y_up : {false, true}) {
    const TemporaryFolder folder;
    auto tallies = Report(
        std::string("OBJ called model.obj, ") + (y_up ? "y" : "z") + " up, unit 1 m", y_up,
        [&](const Truth& truth) {
          const auto file = Turned(Obj(truth), y_up, 1, folder.path());
          std::filesystem::rename(file, folder.path() / "model.obj");
          return folder.path() / "model.obj";
        },
        1);
    EXPECT_EQ(tallies["up"].right + tallies["up"].asked, 23);
  }
}

TEST_F(Furniture, KeepsItsSizeAndShowsItsTexturesAsColoursAndMarks) {
  int textured = 0, alike = 0, marked = 0, with_marks = 0;
  std::printf("\n%-18s  %6s  %6s  %11s  %10s  %s\n", "", "faces", "added", "colours off",
              "marks [px]", "with 200 000 faces");
  for (const Truth& truth : truths_) {
    const auto built = BuildModel(Obj(truth), {});
    ASSERT_TRUE(built.ok()) << built.error().message;
    Eigen::Vector3d size = built->model.bounds.sizes().cast<double>(), wanted = truth.size_m;
    std::sort(size.begin(), size.end());
    std::sort(wanted.begin(), wanted.end());
    if (built->report.unit.value == 1) {  // The table gives millimetres.
      EXPECT_LT((size - wanted).cwiseAbs().maxCoeff(), 0.0012 + 0.002 * wanted.maxCoeff())
          << truth.name;
    }
    if (built->texture_image.empty()) continue;
    ++textured;
    const double off = ColorsOff(*built), marks = MarksOf(built->model.mesh);
    TriangleMesh finest = built->model.mesh;
    finest.colors.clear();
    PaintByTexture(built->texture_image, 200'000, finest);
    const double finest_marks = MarksOf(finest);
    const bool has_marks = finest_marks > 1;  // One pixel in a view is the edge of something else.
    alike += off < 12;
    with_marks += has_marks;
    marked += has_marks && marks > 0.5 * finest_marks;
    std::printf("%-18s  %6d  %6d  %11.1f  %10.1f  %.1f\n", truth.name.c_str(),
                static_cast<int>(built->model.mesh.triangles.size()),
                built->report.faces_for_texture, off, marks, finest_marks);
  }
  std::printf(
      "textures: %d, shown by colours (under 12 grey levels off): %d; with steps of luminance that "
      "make marks: %d, of which half or more are there: %d\n",
      textured, alike, with_marks, marked);
  EXPECT_EQ(textured, 23);
  EXPECT_EQ(alike, 23);
  EXPECT_EQ(marked, with_marks);
}

/// The models of the kitchen, the office and the Aeron chair, as OBJ without colours in either
/// turn: other shapes than those that the table above is about, most of them scanned.
TEST_F(Furniture, OtherModelsAreUprightOrAskedAboutToo) {
  struct Other {
    const char* file;
    bool faces_x;  ///< Else it has no front.
  };
  Tally ups, fronts;
  std::printf("\n%-18s  %-16s  %-16s  %s\n", "", "up, z up", "up, y up", "front");
  for (const Other& other :
       {Other{"kitchen/models/chair.ply", true}, Other{"kitchen/models/container.ply", false},
        Other{"kitchen/models/controller.ply", false},
        Other{"kitchen/models/mug_pattern.ply", false},
        Other{"kitchen/models/mug_white.ply", false}, Other{"kitchen/models/table.ply", false},
        Other{"office/models/chair.ply", true}, Other{"office/models/long_table.ply", false},
        Other{"office/models/round_table.ply", false}, Other{"office/models/sofa.ply", true},
        Other{"aeron/hermanmiller_aeron.obj", true}}) {
    const std::filesystem::path file = folder_.parent_path() / other.file;
    TriangleMesh mesh = ReadMesh(file).value();
    if (file.extension() == ".obj") {  // It is y down.
      for (Eigen::Vector3f& v : mesh.vertices) v = {v.x(), v.z(), -v.y()};
    }
    std::printf("%-18s", file.stem().c_str());
    for (const bool y_up : {false, true}) {
      TexturedMesh turned;
      turned.mesh.triangles = mesh.triangles;
      for (const Eigen::Vector3f& v : mesh.vertices)
        turned.mesh.vertices.emplace_back(y_up ? Eigen::Vector3f(v.x(), v.z(), -v.y()) : v);
      const auto built = BuildModelFrom(turned, file.stem().string(), "a.obj", {});
      ASSERT_TRUE(built.ok()) << built.error().message;
      const ModelBuildReport& report = built->report;
      const bool upright = AsPublished(report.up.value, y_up) == "+z";
      std::printf("  %-16s", ups.Count(upright, report.up.confidence).c_str());
      const bool right = other.faces_x && AsPublished(report.front.value, y_up) == "+x";
      std::string front = "(none)";
      if (other.faces_x || (report.has_front && report.front.sure()))
        front = fronts.Count(right, report.front.confidence);
      if (y_up) std::printf("  %s\n", front.c_str());
    }
  }
  std::printf("up: %s\nfront: %s\n", ups.Row(22).c_str(), fronts.Row(8).c_str());
  EXPECT_EQ(ups.wrong, 0);
  EXPECT_EQ(fronts.wrong, 0);
}

}  // namespace
}  // namespace plumbline
