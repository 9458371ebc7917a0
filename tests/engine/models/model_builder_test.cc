// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_builder.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_check.h"
#include "engine/models/model_source.h"
#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// A plain chair [m], +z up and +x front, its footprint's centre at the origin.
TriangleMesh Chair() {
  TriangleMesh chair = MakeBox({-0.22f, -0.22f, 0.42f}, {0.25f, 0.22f, 0.46f});  // seat
  Append(MakeBox({-0.25f, -0.22f, 0.42f}, {-0.21f, 0.22f, 0.9f}), chair);        // back rest
  for (const float x : {-0.25f, 0.21f}) {
    for (const float y : {-0.22f, 0.18f})
      Append(MakeBox({x, y, 0}, {x + 0.04f, y + 0.04f, 0.42f}), chair);
  }
  return chair;
}

/// The mesh in a file's axes: its +z becomes `up`, its +x `front`, lengths times `scale`, away from
/// the origin.
TriangleMesh InFileAxes(TriangleMesh mesh, const SignedAxis& up, const SignedAxis& front,
                        float scale) {
  Eigen::Matrix3d file_from_object;
  file_from_object << front.vector(), up.vector().cross(front.vector()), up.vector();
  for (Eigen::Vector3f& vertex : mesh.vertices) {
    vertex = scale * ((file_from_object * vertex.cast<double>()).cast<float>() +
                      Eigen::Vector3f(0.3f, -0.7f, 1.1f));
  }
  return mesh;
}

std::filesystem::path WriteObj(const std::filesystem::path& file, const TriangleMesh& mesh) {
  std::string text;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    text += "v " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " +
            std::to_string(v.z()) + "\n";
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
            std::to_string(t[2] + 1) + "\n";
  }
  EXPECT_TRUE(WriteFileAtomically(file, text).ok());
  return file;
}

template <typename T>
void Put(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::filesystem::path WriteBinaryStl(const std::filesystem::path& file, const TriangleMesh& mesh) {
  std::string out(80, ' ');
  Put(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) Put(out, 0.0f);
    for (const int corner : t) {
      for (int i = 0; i < 3; ++i) Put(out, mesh.vertices[static_cast<std::size_t>(corner)][i]);
    }
    Put(out, std::uint16_t{0});
  }
  EXPECT_TRUE(WriteFileAtomically(file, out).ok());
  return file;
}

std::filesystem::path WriteGlb(const std::filesystem::path& file, const TriangleMesh& mesh) {
  std::string data;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    for (int i = 0; i < 3; ++i) Put(data, v[i]);
  }
  const std::size_t vertex_bytes = data.size();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (const int corner : t) Put(data, static_cast<std::uint32_t>(corner));
  }
  const Eigen::AlignedBox3f box = BoundingBox(mesh);
  const nlohmann::json json = {
      {"asset", {{"version", "2.0"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {{{"mesh", 0}, {"translation", {5, 6, 7}}}}},
      {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
      {"buffers", {{{"byteLength", data.size()}}}},
      {"bufferViews",
       {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", vertex_bytes}},
        {{"buffer", 0}, {"byteOffset", vertex_bytes}, {"byteLength", data.size() - vertex_bytes}}}},
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", 5126},
         {"count", mesh.vertices.size()},
         {"type", "VEC3"},
         {"min", {box.min().x(), box.min().y(), box.min().z()}},
         {"max", {box.max().x(), box.max().y(), box.max().z()}}},
        {{"bufferView", 1},
         {"componentType", 5125},
         {"count", 3 * mesh.triangles.size()},
         {"type", "SCALAR"}}}}};
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string out = "glTF";
  Put(out, std::uint32_t{2});
  Put(out, static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + data.size()));
  Put(out, static_cast<std::uint32_t>(text.size()));
  out += "JSON" + text;
  Put(out, static_cast<std::uint32_t>(data.size()));
  out += std::string("BIN\0", 4) + data;
  EXPECT_TRUE(WriteFileAtomically(file, out).ok());
  return file;
}

/// Upright, facing +x, at the origin and in metres.
void ExpectCanonicalChair(const CadModel& model) {
  EXPECT_TRUE(model.bounds.min().isApprox(Eigen::Vector3f(-0.25f, -0.22f, 0), 1e-3f))
      << model.bounds.min().transpose();
  EXPECT_TRUE(model.bounds.max().isApprox(Eigen::Vector3f(0.25f, 0.22f, 0.9f), 1e-3f))
      << model.bounds.max().transpose();
  for (const Eigen::Vector3f& vertex : model.mesh.vertices) {
    if (vertex.z() <= 0.5f) continue;
    EXPECT_LT(vertex.x(), -0.2f) << "the back rest is behind the sitter";
  }
}

TEST(ModelBuilder, StatedAxesBringEveryFileIntoTheCanonicalFrame) {
  const TemporaryFolder folder;
  for (const char* up_text : {"+x", "-x", "+y", "-y", "+z", "-z"}) {
    for (const char* front_text : {"+x", "-x", "+y", "-y", "+z", "-z"}) {
      ModelBuildOptions options;
      options.up = ParseSignedAxis(up_text);
      options.front = ParseSignedAxis(front_text);
      options.unit = LengthUnit::kCentimetre;
      options.category = "chair";
      const auto file = WriteObj(folder.path() / "a.obj", Chair());
      if (options.up->axis == options.front->axis) {
        const Result<BuiltModel> built = BuildModel(file, options);
        ASSERT_FALSE(built.ok());
        EXPECT_EQ(built.error().code, ErrorCode::kInvalidInput);
        continue;
      }
      WriteObj(file, InFileAxes(Chair(), *options.up, *options.front, 100));
      const Result<BuiltModel> built = BuildModel(file, options);
      ASSERT_TRUE(built.ok()) << built.error().message;
      ExpectCanonicalChair(built->model);
      EXPECT_THAT(built->report.warnings, IsEmpty());
      EXPECT_EQ(built->model.support, Support::kFloor);
    }
  }
}

TEST(ModelBuilder, GuessesUnitUpAndFrontWithAWarningEach) {
  const TemporaryFolder folder;
  struct Case {
    SignedAxis up, front;
    float scale;
  };
  for (const Case& c :
       {Case{{1, 1}, {2, 1}, 100}, Case{{2, 1}, {1, -1}, 1000}, Case{{1, -1}, {0, 1}, 1}}) {
    const auto file =
        WriteObj(folder.path() / "office_chair.obj", InFileAxes(Chair(), c.up, c.front, c.scale));
    const Result<BuiltModel> built = BuildModel(file, {});
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_EQ(built->report.up.value, c.up) << built->report.up.value.text();
    EXPECT_EQ(built->report.front.value, c.front) << built->report.front.value.text();
    ExpectCanonicalChair(built->model);
    EXPECT_EQ(built->model.category, "chair");
    ASSERT_EQ(built->report.warnings.size(), 3u);
    EXPECT_THAT(built->report.warnings[0], HasSubstr("--unit"));
    EXPECT_THAT(built->report.warnings[1], HasSubstr("--up"));
    EXPECT_THAT(built->report.warnings[2], HasSubstr("--front"));
  }
}

TEST(ModelBuilder, TurnsOverAChairThatWouldStandOnItsHeadUnlessTheSignIsStated) {
  const TemporaryFolder folder;
  const auto file = WriteObj(folder.path() / "chair.obj", InFileAxes(Chair(), {1, -1}, {0, 1}, 1));
  ModelBuildOptions options;
  options.up = ParseSignedAxis("y");
  options.up_sign_stated = false;
  options.front = ParseSignedAxis("+x");
  options.unit = LengthUnit::kMetre;
  const Result<BuiltModel> turned = BuildModel(file, options);
  ASSERT_TRUE(turned.ok());
  ExpectCanonicalChair(turned->model);
  ASSERT_EQ(turned->report.warnings.size(), 1u);
  EXPECT_THAT(turned->report.warnings[0], HasSubstr("stand on its head"));
  options.up_sign_stated = true;
  const Result<BuiltModel> insisted = BuildModel(file, options);
  ASSERT_TRUE(insisted.ok());
  EXPECT_EQ(insisted->report.up.value, (SignedAxis{1, 1}));
}

TEST(ModelBuilder, ReadsMillimetreStlAndGlb) {
  const TemporaryFolder folder;
  const auto stl =
      WriteBinaryStl(folder.path() / "chair.stl", InFileAxes(Chair(), {2, 1}, {0, 1}, 1000));
  const Result<BuiltModel> from_stl = BuildModel(stl, {});
  ASSERT_TRUE(from_stl.ok()) << from_stl.error().message;
  EXPECT_EQ(from_stl->report.unit.value, 0.001);
  ExpectCanonicalChair(from_stl->model);
  EXPECT_EQ(from_stl->model.mesh.vertices.size(), WeldedGeometry(Chair()).vertices.size())
      << "corners of STL faces are merged";

  const auto glb = WriteGlb(folder.path() / "chair.glb", InFileAxes(Chair(), {1, 1}, {2, 1}, 1));
  const Result<BuiltModel> from_glb = BuildModel(glb, {});
  ASSERT_TRUE(from_glb.ok()) << from_glb.error().message;
  ExpectCanonicalChair(from_glb->model);
  EXPECT_EQ(from_glb->report.warnings.size(), 1u)
      << "only the front is a guess: the format fixes unit and up";
}

TEST(ModelBuilder, AStatedUnitIsBelievedUnlessItCannotBe) {
  const TemporaryFolder folder;
  const auto true_file =
      WriteGlb(folder.path() / "chair.glb", InFileAxes(Chair(), {1, 1}, {2, 1}, 1));
  const Result<BuiltModel> as_stated = BuildModel(true_file, {});
  ASSERT_TRUE(as_stated.ok()) << as_stated.error().message;
  ASSERT_EQ(as_stated->report.believed.size(), 2u);
  EXPECT_THAT(as_stated->report.believed[0], HasSubstr("unit m, as the glTF format says"));
  EXPECT_THAT(as_stated->report.believed[1], HasSubstr("up +y, as the glTF format says"));
  // Its numbers are centimetres: no chair is 90 m high.
  const auto absurd_file =
      WriteGlb(folder.path() / "chair.glb", InFileAxes(Chair(), {1, 1}, {2, 1}, 100));
  const Result<BuiltModel> doubted = BuildModel(absurd_file, {});
  ASSERT_TRUE(doubted.ok()) << doubted.error().message;
  EXPECT_EQ(doubted->report.unit.value, 0.01);
  EXPECT_FALSE(doubted->report.unit.sure());
  EXPECT_THAT(doubted->report.warnings[0], HasSubstr("90 m"));
  ExpectCanonicalChair(doubted->model);
  ModelBuildOptions options;  // What the user states is not doubted.
  options.unit = LengthUnit::kMetre;
  const Result<BuiltModel> insisted = BuildModel(absurd_file, options);
  ASSERT_TRUE(insisted.ok());
  EXPECT_NEAR(insisted->model.bounds.sizes().z(), 90, 0.1);
}

TEST(ModelBuilder, AStatedUpInWhichAThingWouldFallOverIsAskedAbout) {
  const TemporaryFolder folder;
  // Upside down: on the top of its back rest.
  const auto file = WriteGlb(folder.path() / "chair.glb", InFileAxes(Chair(), {1, -1}, {2, 1}, 1));
  const Result<BuiltModel> built = BuildModel(file, {});
  ASSERT_TRUE(built.ok()) << built.error().message;
  EXPECT_EQ(built->report.up.value, (SignedAxis{1, -1})) << built->report.up.value.text();
  EXPECT_FALSE(built->report.up.sure());
  EXPECT_THAT(built->report.warnings[0], HasSubstr("fall over"));
}

TEST(ModelBuilder, ATelevisionStandsOnItsEdgeAndItsScreenIsInFront) {
  const TemporaryFolder folder;
  TriangleMesh tv = MakeBox({-0.02f, -0.6f, 0}, {0.02f, 0.6f, 0.66f});
  Append(MakeBox({-0.06f, -0.3f, 0.2f}, {-0.02f, 0.3f, 0.5f}), tv);  // the mount, behind
  for (const SignedAxis& up : {SignedAxis{1, 1}, SignedAxis{2, 1}}) {
    const auto file = WriteObj(folder.path() / "LG_TV.obj", InFileAxes(tv, up, {0, 1}, 1));
    const Result<BuiltModel> built = BuildModel(file, {});
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_EQ(built->model.category, "tv");
    EXPECT_EQ(built->report.up.value, up) << built->report.up.value.text();
    EXPECT_EQ(built->report.front.value, (SignedAxis{0, 1}))
        << built->report.front.value.text() << built->report.front.confidence;
  }
}

TEST(ModelBuilder, ACabinetFacesAcrossItsWidthToTheSideWithTheDoors) {
  const TemporaryFolder folder;
  TriangleMesh cabinet = MakeBox({-0.22f, -0.7f, 0}, {0.22f, 0.7f, 0.8f});
  for (const float y : {-0.68f, -0.22f, 0.24f}) {
    Append(MakeBox({0.22f, y, 0.05f}, {0.235f, y + 0.44f, 0.75f}), cabinet);
    Append(MakeBox({0.235f, y + 0.02f, 0.4f}, {0.26f, y + 0.04f, 0.5f}), cabinet);
  }
  for (const SignedAxis& front : {SignedAxis{0, 1}, SignedAxis{0, -1}, SignedAxis{1, -1}}) {
    const auto file =
        WriteObj(folder.path() / "TVCabinet.obj", InFileAxes(cabinet, {2, 1}, front, 1));
    const Result<BuiltModel> built = BuildModel(file, {});
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_EQ(built->report.front.value, front) << built->report.front.value.text();
    EXPECT_EQ(built->model.category, "unknown") << "COCO has no cabinets, and it is no television";
  }
}

TEST(ModelBuilder, AThingThatIsTooFlatForItsNameIsNotTakenForIt) {
  const TemporaryFolder folder;
  const auto file = WriteObj(folder.path() / "cooking_bench.obj",
                             MakeBox({-0.27f, -0.5f, 0}, {0.27f, 0.5f, 0.1f}));
  const Result<BuiltModel> built = BuildModel(file, {});
  ASSERT_TRUE(built.ok()) << built.error().message;
  EXPECT_EQ(built->model.category, "unknown") << "no bench is 10 cm high";
  EXPECT_EQ(built->report.up.value, (SignedAxis{2, 1})) << built->report.up.value.text();
}

TEST(ModelBuilder, WhatIsUnsureStaysMarkedUntilItIsStated) {
  const TemporaryFolder folder;
  // A cube away from the origin: nothing tells which way it stands or faces.
  const auto file = WriteObj(folder.path() / "thing.obj",
                             InFileAxes(MakeBox({0, 0, 0}, {1, 1, 1}), {2, 1}, {0, 1}, 1));
  ModelBuildOptions options;
  options.unit = LengthUnit::kMetre;
  const auto unsure = BuildModel(file, options);
  ASSERT_TRUE(unsure.ok()) << unsure.error().message;
  EXPECT_FALSE(unsure->report.up.sure());
  EXPECT_EQ(unsure->report.up.shares.size(), 6u);
  EXPECT_FALSE(unsure->report.front.sure());
  ASSERT_TRUE(StoreModel(*unsure, folder.path() / "db").ok());
  auto checks = CheckModels(folder.path() / "db");
  ASSERT_TRUE(checks.ok());
  EXPECT_THAT((*checks)[0].warnings, testing::Contains(HasSubstr("state it with --up")));
  EXPECT_THAT((*checks)[0].warnings, testing::Contains(HasSubstr("state it with --front")));
  options.up = ParseSignedAxis("+z");
  options.front = ParseSignedAxis("+x");
  const auto stated = BuildModel(file, options);
  ASSERT_TRUE(stated.ok());
  ASSERT_TRUE(StoreModel(*stated, folder.path() / "db").ok());
  const auto frames = ReadObjectFromFile(folder.path() / "db");
  ASSERT_TRUE(frames.ok()) << frames.error().message;
  EXPECT_THAT(frames->at("thing"), IsometryNear(stated->report.object_from_file, 1e-9, 1e-9));
  checks = CheckModels(folder.path() / "db");
  ASSERT_TRUE(checks.ok());
  EXPECT_THAT((*checks)[0].warnings, testing::Not(testing::Contains(HasSubstr("state it"))));
}

TEST(ModelBuilder, StoresModelsAndKeepsWhatOthersWrote) {
  const TemporaryFolder folder;
  const std::filesystem::path database = folder.path() / "models";
  std::filesystem::create_directories(database);
  ASSERT_TRUE(WriteFileAtomically(
                  database / "models.json",
                  R"({"units": "m", "licence": "x", "models": [{"name": "old", "file": "old.ply",
                                      "category": "cup", "colour": "red"}]})")
                  .ok());
  ASSERT_TRUE(WritePly(database / "old.ply", MakeSphere(0.05f, 8)).ok());
  ModelBuildOptions options;
  options.category = "chair";
  options.symmetry = 2;
  const auto file = WriteObj(folder.path() / "my chair.obj", Chair());
  for (int pass = 0; pass < 2; ++pass) {
    const Result<BuiltModel> built = BuildModel(file, options);
    ASSERT_TRUE(built.ok());
    ASSERT_TRUE(StoreModel(*built, database).ok());
  }
  const nlohmann::json json = *ReadJson(database / "models.json");
  EXPECT_EQ(json["licence"], "x");
  ASSERT_EQ(json["models"].size(), 2u) << "the second pass replaces";
  EXPECT_EQ(json["models"][0]["colour"], "red");
  EXPECT_EQ(json["models"][1]["source"]["file"], "my chair.obj");
  EXPECT_EQ(json["models"][1]["source"]["up"], "+z");
  const auto loaded = ModelDatabase::Load(database);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message;
  const CadModel& chair = (*loaded)->model(*(*loaded)->Find("my_chair"));
  EXPECT_EQ(chair.symmetry.order, 2);
  EXPECT_EQ(chair.support, Support::kFloor);
  EXPECT_FALSE(chair.back);
}

TEST(ModelBuilder, KeepsThatAModelHasABack) {
  const TemporaryFolder folder;
  ModelBuildOptions options;
  options.category = "chair";
  options.back = true;
  const auto file = WriteObj(folder.path() / "chair.obj", Chair());
  for (int pass = 0; pass < 2; ++pass) {  // the second, with other triangles, does not say it
    const Result<BuiltModel> built = BuildModel(file, options);
    ASSERT_TRUE(built.ok());
    ASSERT_TRUE(StoreModel(*built, folder.path()).ok());
    const auto loaded = ModelDatabase::Load(folder.path());
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    EXPECT_TRUE((*loaded)->model(*(*loaded)->Find("chair")).back);
    options.back = false;
    options.faces = 100;
  }
}

TEST(ModelBuilder, RefusesMeshesWithoutSurface) {
  const TemporaryFolder folder;
  TriangleMesh line;
  line.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  ASSERT_TRUE(WritePly(folder.path() / "line.ply", line).ok());
  const Result<BuiltModel> built = BuildModel(folder.path() / "line.ply", {});
  ASSERT_FALSE(built.ok());
  EXPECT_EQ(built.error().code, ErrorCode::kDegenerate);
  EXPECT_THAT(built.error().message, HasSubstr("line.ply"));
}

TEST(ModelBuilder, BringsTheAeronChairUprightFacingX) {
  const auto shared = SharedData();
  if (!shared) GTEST_SKIP() << kNoSharedData;
  ModelBuildOptions stated;  // "y up": the file's y axis, which in fact points down
  stated.unit = LengthUnit::kMetre;
  stated.up = ParseSignedAxis("y");
  stated.up_sign_stated = false;
  stated.front = ParseSignedAxis("+x");
  for (const ModelBuildOptions& options : {ModelBuildOptions{}, stated}) {
    const Result<BuiltModel> built =
        BuildModel(*shared / "data/aeron/hermanmiller_aeron.obj", options);
    ASSERT_TRUE(built.ok()) << built.error().message;
    const TriangleMesh& mesh = built->model.mesh;
    EXPECT_EQ(mesh.colors.size(), mesh.vertices.size());
    EXPECT_NEAR(built->model.bounds.sizes().z(), 1.04, 0.01);
    Eigen::AlignedBox3f base, top;
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      if (vertex.z() < 0.1f) base.extend(vertex);
      if (vertex.z() > 0.9f) top.extend(vertex);
    }
    EXPECT_GT(base.sizes().x(), 0.6f) << "the five-star base is below";
    EXPECT_LT(top.max().x(), -0.1f) << "the back rest is behind";
  }
}

TEST(ModelCheck, ReportsEdgesScaleAndFootprintAndFindsWhatIsUnusable) {
  const TemporaryFolder folder;
  ASSERT_TRUE(
      WritePly(folder.path() / "good.ply", MakeBox({-0.2f, -0.2f, 0}, {0.2f, 0.2f, 0.5f})).ok());
  ASSERT_TRUE(
      WritePly(folder.path() / "open.ply", MakeParallelogram({0, 0, 1}, {1, 0, 0}, {0, 1, 0}))
          .ok());
  ASSERT_TRUE(WritePly(folder.path() / "huge.ply", MakeBox({-200, -200, 0}, {200, 200, 500})).ok());
  ASSERT_TRUE(WriteFileAtomically(folder.path() / "models.json", R"({"models": [
      {"name": "good", "file": "good.ply", "category": "chair"}, {"name": "open", "file": "open.ply", "category": "chair"},
      {"name": "huge", "file": "huge.ply", "category": "chair"}, {"name": "gone", "file": "gone.ply", "category": "chair"},
      {"name": 7}]})")
                  .ok());
  const auto checks = CheckModels(folder.path());
  ASSERT_TRUE(checks.ok()) << checks.error().message;
  ASSERT_EQ(checks->size(), 5u);
  EXPECT_EQ((*checks)[0].edges.open, 0);
  EXPECT_EQ((*checks)[0].faces, 12);
  EXPECT_THAT((*checks)[0].warnings, IsEmpty());
  EXPECT_THAT((*checks)[0].problems, IsEmpty());
  EXPECT_EQ((*checks)[1].edges.open, 4);
  EXPECT_EQ((*checks)[1].warnings.size(), 2u) << "origin off the footprint, above the plane";
  for (const std::size_t i : {2u, 3u, 4u}) EXPECT_EQ((*checks)[i].problems.size(), 1u) << i;
}

}  // namespace
}  // namespace plumbline
