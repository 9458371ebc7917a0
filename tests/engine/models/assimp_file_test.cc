// SPDX-License-Identifier: Apache-2.0
#include "engine/models/assimp_file.h"

#include <gmock/gmock.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "engine/models/model_builder.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

std::filesystem::path Write(const std::filesystem::path& file, std::string_view content) {
  std::filesystem::create_directories(file.parent_path());
  EXPECT_TRUE(WriteFileAtomically(file, content).ok());
  return file;
}

std::string PngOf(const cv::Scalar& bgr) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", cv::Mat(4, 4, CV_8UC3, bgr), bytes);
  return {bytes.begin(), bytes.end()};
}

/// One triangle (0 0 0) (1 0 0) (0 1 0); `asset` and `matrix` go in as they are.
std::string Collada(const std::string& asset, const std::string& matrix) {
  return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>)" +
         asset + R"(</asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><matrix>)" +
         matrix +
         R"(</matrix><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

constexpr char kNoMatrix[] = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";

TEST(AssimpFile, ColladaIsPlacedByItsNodesAndStatesUnitAndUp) {
  const TemporaryFolder folder;
  // x -> 2 y, y -> 3 z, and 5 along x.
  const auto file = Write(folder.path() / "a.DAE",
                          Collada(R"(<unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis>)",
                                  "0 0 1 5  2 0 0 0  0 3 0 0  0 0 0 1"));
  const auto read = ReadTexturedMesh(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->mesh.vertices.size(), 3u);
  const Eigen::AlignedBox3f box = BoundingBox(read->mesh);
  EXPECT_TRUE(box.min().isApprox(Eigen::Vector3f(5, 0, 0), 1e-5f)) << box.min();
  EXPECT_TRUE(box.max().isApprox(Eigen::Vector3f(5, 2, 3), 1e-5f)) << box.max();
  EXPECT_NEAR(read->frame.metres.value(), 0.0254, 1e-9);
  EXPECT_EQ(read->frame.up, (SignedAxis{2, 1}));
  const auto mesh = ReadMesh(file);  // in metres
  ASSERT_TRUE(mesh.ok());
  EXPECT_NEAR(BoundingBox(*mesh).max().z(), 3 * 0.0254, 1e-6);
}

TEST(AssimpFile, ColladaWithoutUnitAndUpIsInMetresAndYUpByDefinition) {
  const TemporaryFolder folder;
  const auto read = ReadTexturedMesh(Write(folder.path() / "a.dae", Collada("", kNoMatrix)));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->frame.metres, 1.0);
  EXPECT_EQ(read->frame.up, (SignedAxis{1, 1}));
  EXPECT_TRUE(BoundingBox(read->mesh).max().isApprox(Eigen::Vector3f(1, 1, 0)));
}

TEST(AssimpFile, ReadsOffAndSaysNothingOfItsUnit) {
  const TemporaryFolder folder;
  const auto read = ReadTexturedMesh(
      Write(folder.path() / "a.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->mesh.triangles.size(), 2u);
  EXPECT_FALSE(read->frame.metres);
  EXPECT_FALSE(read->frame.up);
}

TEST(AssimpFile, RefusesATornColladaAndAWordDocument) {
  const TemporaryFolder folder;
  const std::string whole = Collada("", kNoMatrix);
  const auto torn = ReadMesh(Write(folder.path() / "a.dae", whole.substr(0, whole.size() / 2)));
  ASSERT_FALSE(torn.ok());
  EXPECT_EQ(torn.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(torn.error().message, HasSubstr("a.dae"));
  const auto other = ReadMesh(folder.path() / "a.docx");
  ASSERT_FALSE(other.ok());
  EXPECT_THAT(other.error().message, HasSubstr("dae"));
  EXPECT_THAT(other.error().message, HasSubstr("off"));
}

TEST(AssimpFile, ATextureOfNoMaterialIsDamageAndNotTheEnd) {
  const TemporaryFolder folder;
  for (const char* named : {"a.mtl", "other.mtl"}) {  // a.mtl is looked for in any case
    for (const char* texture : {"map_Kd", "bump", "norm", "disp", "refl"}) {
      Write(folder.path() / named, std::string("# exported\n") + texture + " b.png\nnewmtl b\n");
      const auto read =
          ReadMesh(Write(folder.path() / "a.obj", std::string("mtllib ") + named +
                                                      "\r\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
      ASSERT_FALSE(read.ok()) << texture;
      EXPECT_EQ(read.error().code, ErrorCode::kCorrupt);
      EXPECT_THAT(read.error().message, HasSubstr("before any material"));
    }
    Write(folder.path() / named, "Kd 1 0 0\nnewmtl b\nmap_Kd b.png\n");
    EXPECT_TRUE(ReadMesh(folder.path() / "a.obj").ok());
  }
}

constexpr char kTwoSquares[] =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "usemtl left\nf 1/1 2/2 3/3 4/4\nusemtl right\nf 2/1 5/2 6/3 3/4\n";

std::array<std::uint8_t, 3> ColorAtX(const TriangleMesh& mesh, float x) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (mesh.vertices[i].x() == x) return mesh.colors.at(i);
  }
  return {};
}

TEST(AssimpFile, SeveralTexturesOfAnObjAllShow) {
  const TemporaryFolder folder;
  Write(folder.path() / "textures/red.png", PngOf({0, 0, 250}));
  Write(folder.path() / "Blue.PNG", PngOf({240, 0, 0}));
  Write(
      folder.path() / "a.mtl",
      "newmtl left\nKd 1 1 1\nmap_Kd red.png\nnewmtl right\nKd 1 1 1\nmap_Kd C:\\mine\\blue.png\n");
  const auto file = Write(folder.path() / "a.obj", kTwoSquares);
  const auto read = ReadTexturedMesh(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_THAT(read->warnings, IsEmpty());
  EXPECT_FALSE(read->texture.empty());
  EXPECT_EQ(read->mesh.texture_file, "") << "it is in no file";
  const auto mesh = ReadMesh(file);
  ASSERT_TRUE(mesh.ok());
  EXPECT_EQ(ColorAtX(*mesh, 0), (std::array<std::uint8_t, 3>{250, 0, 0}));
  EXPECT_EQ(ColorAtX(*mesh, 2), (std::array<std::uint8_t, 3>{0, 0, 240}));

  // The same in a database, and again from there.
  ModelBuildOptions options;
  options.category = "couch";
  const auto built = BuildModel(file, options);
  ASSERT_TRUE(built.ok()) << built.error().message;
  ASSERT_TRUE(StoreModel(*built, folder.path() / "db").ok());
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "db/a_texture.png"));
  const auto database = ModelDatabase::Load(folder.path() / "db");
  ASSERT_TRUE(database.ok()) << database.error().message;
  const TriangleMesh& stored = (*database)->models()[0].mesh;
  EXPECT_EQ(stored.texture_file, "a_texture.png");
  EXPECT_EQ(stored.texture_coordinates.size(), stored.vertices.size());
  EXPECT_THAT(stored.colors, testing::Contains(std::array<std::uint8_t, 3>{250, 0, 0}));
  EXPECT_THAT(stored.colors, testing::Contains(std::array<std::uint8_t, 3>{0, 0, 240}));
}

TEST(AssimpFile, SaysWhichTextureIsMissing) {
  const TemporaryFolder folder;
  Write(folder.path() / "red.png", PngOf({0, 0, 250}));
  Write(folder.path() / "a.mtl",
        "newmtl left\nKd 1 1 1\nmap_Kd red.png\nnewmtl right\nKd 0 1 0\nmap_Kd gone.png\n");
  const auto read = ReadTexturedMesh(Write(folder.path() / "a.obj", kTwoSquares));
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->warnings.size(), 1u);
  EXPECT_THAT(read->warnings[0], HasSubstr("gone.png"));
  const auto mesh = ReadMesh(folder.path() / "a.obj");
  EXPECT_EQ(ColorAtX(*mesh, 0), (std::array<std::uint8_t, 3>{250, 0, 0}));
  EXPECT_EQ(ColorAtX(*mesh, 2), (std::array<std::uint8_t, 3>{0, 255, 0})) << "its plain colour";
}

/// A GLB of one triangle whose texture lies inside.
std::string GlbWithTexture(const std::string& png, const nlohmann::json& factor) {
  const float numbers[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
  std::string data(reinterpret_cast<const char*>(numbers), sizeof(numbers));
  data += png;
  data.resize((data.size() + 3) / 4 * 4, '\0');
  const auto view = [](std::size_t offset, std::size_t length) {
    return nlohmann::json{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", length}};
  };
  const nlohmann::json json = {
      {"asset", {{"version", "2.0"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {{{"mesh", 0}}}},
      {"meshes",
       {{{"primitives",
          {{{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}}, {"material", 0}}}}}}},
      {"materials",
       {{{"name", "m"},
         {"pbrMetallicRoughness",
          {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", factor}}}}}},
      {"textures", {{{"source", 0}}}},
      {"images", {{{"bufferView", 2}, {"mimeType", "image/png"}}}},
      {"buffers", {{{"byteLength", data.size()}}}},
      {"bufferViews", {view(0, 36), view(36, 24), view(60, png.size())}},
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", 5126},
         {"count", 3},
         {"type", "VEC3"},
         {"min", {0, 0, 0}},
         {"max", {1, 1, 0}}},
        {{"bufferView", 1}, {"componentType", 5126}, {"count", 3}, {"type", "VEC2"}}}}};
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string out = "glTF";
  const auto put = [&out](std::uint32_t value) {
    out.append(reinterpret_cast<const char*>(&value), 4);
  };
  put(2);
  put(static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + data.size()));
  put(static_cast<std::uint32_t>(text.size()));
  out += "JSON" + text;
  put(static_cast<std::uint32_t>(data.size()));
  return out + std::string("BIN\0", 4) + data;
}

TEST(AssimpFile, ATextureInsideOfAGlbShows) {
  const TemporaryFolder folder;
  const auto file =
      Write(folder.path() / "a.glb", GlbWithTexture(PngOf({30, 120, 250}), {1, 1, 1, 1}));
  const auto mesh = ReadMesh(file);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->colors.at(0), (std::array<std::uint8_t, 3>{250, 120, 30}));
  EXPECT_THAT(mesh->texture_coordinates, IsEmpty()) << "of a texture that is nowhere to be found";
  const auto built = BuildModel(file, {});
  ASSERT_TRUE(built.ok()) << built.error().message;
  ASSERT_TRUE(StoreModel(*built, folder.path() / "db").ok());
  EXPECT_EQ(cv::imread((folder.path() / "db/a_texture.png").string()).at<cv::Vec3b>(0, 0),
            cv::Vec3b(30, 120, 250));
}

TEST(AssimpFile, GltfTintsItsTextureByALinearFactor) {
  const TemporaryFolder folder;
  const auto mesh = ReadMesh(
      Write(folder.path() / "a.glb", GlbWithTexture(PngOf({255, 255, 255}), {0.5, 0.0, 1, 1})));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  // 0.5 of the light is 188 of 255 in sRGB.
  EXPECT_EQ(mesh->colors.at(0), (std::array<std::uint8_t, 3>{188, 0, 255}));
}

TEST(AssimpFile, APictureThatIsNoneIsLeftOutWithAWarning) {
  const TemporaryFolder folder;
  const auto read = ReadTexturedMesh(
      Write(folder.path() / "a.glb", GlbWithTexture("no picture at all", {1, 1, 1, 1})));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_TRUE(read->texture.empty());
  ASSERT_EQ(read->warnings.size(), 1u);
  EXPECT_THAT(read->warnings[0], HasSubstr("no picture"));
}

TEST(AssimpFile, APlyWithATextureAndNoColoursShowsIt) {
  const TemporaryFolder folder;
  Write(folder.path() / "wood.png", PngOf({30, 120, 250}));
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.texture_coordinates = {{0, 0}, {1, 0}, {0, 1}};
  mesh.texture_file = "wood.png";
  for (const bool white : {false, true}) {  // What was built before textures were painted is white.
    mesh.colors.assign(white ? 3 : 0, {255, 255, 255});
    ASSERT_TRUE(WritePly(folder.path() / "a.ply", mesh).ok());
    const auto read = ReadMesh(folder.path() / "a.ply");
    ASSERT_TRUE(read.ok());
    EXPECT_EQ(read->colors.at(2), (std::array<std::uint8_t, 3>{250, 120, 30}));
  }
  mesh.colors.assign(3, {1, 2, 3});  // Colours that say something stay.
  ASSERT_TRUE(WritePly(folder.path() / "a.ply", mesh).ok());
  EXPECT_EQ(ReadMesh(folder.path() / "a.ply")->colors, mesh.colors);
}

}  // namespace
}  // namespace plumbline
