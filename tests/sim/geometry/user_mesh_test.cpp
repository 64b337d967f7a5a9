#include "sim/geometry/user_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "sim/geometry/measure.h"
#include "sim/geometry/mesh_io.h"
#include "sim/geometry/mesh_warnings.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class UserMeshFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("cousin_user_mesh_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) const {
    fs::remove(folder_ / name);
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::string error_of(const std::string& name, const std::string& bytes,
                       std::size_t most = kMostUserTriangles) const {
    try {
      read_user_mesh(write(name, bytes), most);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

template <class T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes;
  for (const T value : values) {
    char part[sizeof(T)];
    std::memcpy(part, &value, sizeof value);
    bytes.append(part, sizeof part);
  }
  return bytes;
}

/// Corners of a tetrahedron of edge 1 along the axes (48 bytes), its triangles (24), and colours.
std::string tetrahedron_bytes() {
  return raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         raw<std::uint16_t>({0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}) +
         raw<std::uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 51, 51, 51, 255});
}

/// @param buffer  what follows "buffers"  @param nodes  of the scene
std::string tetrahedron_gltf(const std::string& buffer, const std::string& nodes,
                             const std::string& extra = "") {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" + nodes +
         R"(],"meshes":[{"name":"m","primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},)"
         R"("indices":1,"material":0}]}],"materials":[{"pbrMetallicRoughness":)"
         R"({"baseColorFactor":[0.5,1,1,1]}}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
         R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"},)"
         R"({"bufferView":2,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":24},)"
         R"({"buffer":0,"byteOffset":72,"byteLength":16}],"buffers":[)" +
         buffer + "]" + extra + "}";
}

const std::string kBeside = R"({"uri":"a%20b.bin","byteLength":88})";

TEST_F(UserMeshFiles, GltfNodesArePartsInMetresWithZUp) {
  write("a b.bin", tetrahedron_bytes());
  const UserMesh user = read_user_mesh(
      write("a.gltf",
            tetrahedron_gltf(kBeside, R"({"name":"plant","translation":[0,1,0],"children":[1,2]},)"
                                      R"({"name":"leaf","mesh":0,"rotation":[0,1,0,0]},)"
                                      R"({"name":"leaf","mesh":0,"scale":[-2,2,2]})")));
  EXPECT_TRUE(user.is_in_metres);
  EXPECT_THAT(user.part_names, ElementsAre("leaf", "leaf 2"));
  ASSERT_EQ(user.mesh.triangles.size(), 8U);
  ASSERT_EQ(user.mesh.vertices_m.size(), 8U);
  // File (1, 0, 0), half a turn about y, 1 up along y: ours (-1, 0, 1).
  EXPECT_LT((user.mesh.vertices_m[1] - Eigen::Vector3d(-1, 0, 1)).norm(), 1e-12);
  // File (0, 0, 1) twice as large: z there looks along -y here.
  EXPECT_LT((user.mesh.vertices_m[7] - Eigen::Vector3d(0, -2, 1)).norm(), 1e-12);
  // A mirrored part is still outward: 1/6 and 8/6 of the unit cube, to the rounding of a sum.
  EXPECT_NEAR(mass_properties(user.mesh).volume_m3, 1.5, 1e-12);
  // Linear colours times the material's.
  EXPECT_EQ(user.vertex_albedo[0], (Rgbf{0.5F, 0, 0}));
  EXPECT_NEAR(user.vertex_albedo[3].g, 0.2F, 1e-6F);
}

TEST_F(UserMeshFiles, TheBinaryContainerIsTheSameMesh) {
  write("a b.bin", tetrahedron_bytes());
  const std::string node = R"({"mesh":0})";
  const UserMesh beside = read_user_mesh(write("a.gltf", tetrahedron_gltf(kBeside, node)));
  std::string json = tetrahedron_gltf(R"({"byteLength":88})", node);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string binary = tetrahedron_bytes();
  const auto length = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
  const std::string glb =
      raw<std::uint32_t>({0x46546C67, 2, length(28 + json.size() + binary.size()),
                          length(json.size()), 0x4E4F534A}) +
      json + raw<std::uint32_t>({length(binary.size()), 0x004E4942}) + binary;
  const UserMesh inside = read_user_mesh(write("a.GLB", glb));
  EXPECT_EQ(inside.mesh.vertices_m, beside.mesh.vertices_m);
  EXPECT_EQ(inside.mesh.triangles, beside.mesh.triangles);
  EXPECT_EQ(inside.vertex_albedo, beside.vertex_albedo);
  EXPECT_THAT(inside.part_names, ElementsAre("m"));
  for (std::size_t size = 0; size < glb.size(); size += 3)
    EXPECT_NE(error_of("cut.glb", glb.substr(0, size)), "") << size;
}

TEST_F(UserMeshFiles, GltfThatLeadsOutsideOrAstrayIsRefusedByName) {
  write("a b.bin", tetrahedron_bytes());
  const std::string node = R"({"mesh":0})";
  const auto error = [&](const std::string& buffer, const std::string& nodes,
                         const std::string& extra = "") {
    return error_of("a.gltf", tetrahedron_gltf(buffer, nodes, extra));
  };
  EXPECT_THAT(error(R"({"uri":"../x.bin"})", node), HasSubstr("leads out"));
  EXPECT_THAT(error(R"({"uri":"/etc/passwd"})", node), HasSubstr("no file inside"));
  EXPECT_THAT(error(R"({"uri":"http://a/b"})", node), HasSubstr("no file inside"));
  EXPECT_THAT(error(R"({"uri":"c.bin"})", node), HasSubstr("no such file"));
  EXPECT_THAT(error(R"({"uri":"data:;base64,!!"})", node), HasSubstr("base 64"));
  EXPECT_THAT(error(R"({"uri":"data:;base64,AAAA"})", node),
              AllOf(HasSubstr("/bufferViews/0"), HasSubstr("its buffer has 3")));
  EXPECT_THAT(error(kBeside, R"({"mesh":7})"), HasSubstr("7 is not below 1"));
  EXPECT_THAT(error(kBeside, R"({"children":[0]})"), HasSubstr("reached twice"));
  EXPECT_THAT(error(kBeside, R"({"name":"empty"})"), HasSubstr("no triangles"));
  EXPECT_THAT(error(kBeside, R"({"mesh":0,"scale":[1,1e400,1]})"), HasSubstr("a.gltf"));
  EXPECT_THAT(error(kBeside, node, R"(,"extensionsRequired":["KHR_draco_mesh_compression"])"),
              HasSubstr("KHR_draco_mesh_compression, which is not read"));
  std::string bad = tetrahedron_bytes();
  bad[49] = 9;  // an index of the first triangle
  write("a b.bin", bad);
  EXPECT_THAT(error(kBeside, node), AllOf(HasSubstr("/indices"), HasSubstr("not below 4")));
  EXPECT_THAT(error_of("b.gltf", R"({"asset":{"version":"1.0"}})"), HasSubstr("2.0 is read"));
  EXPECT_THAT(error_of("b.gltf", "{"), HasSubstr("not JSON"));
}

TEST_F(UserMeshFiles, GltfNodesThatShareAMeshAreBoundedByTheMemoryLimit) {
  write("a b.bin", tetrahedron_bytes());
  std::string children, nodes;
  for (int i = 1; i <= 2000; ++i) {
    children += (i > 1 ? "," : "") + std::to_string(i);
    nodes += R"(,{"mesh":0})";
  }
  set_memory_limit(3 * 4 * 1500 * 36);  // of 1,500 nodes
  EXPECT_THAT(
      error_of("a.gltf", tetrahedron_gltf(kBeside, R"({"children":[)" + children + "]}" + nodes)),
      AllOf(HasSubstr("a.gltf"), HasSubstr("6004 vertices would take")));
  set_memory_limit(0);
}

TEST_F(UserMeshFiles, ObjGroupsArePartsAndColoursAreLinear) {
  const UserMesh user =
      read_user_mesh(write("a.obj",
                           "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0.5 0.5 0.5\no stem\nf 1 2 3\n"
                           "g leaf 1\nf 1 2 3\nf 3 2 1\no stem\nf 1 3 2\n"));
  EXPECT_THAT(user.part_names, ElementsAre("stem", "leaf 1"));
  EXPECT_THAT(user.triangle_part, ElementsAre(0, 1, 1, 0));
  // IEC 61966-2-1: 0.5 is 0.2140 of the light.
  EXPECT_NEAR(user.vertex_albedo[2].r, 0.2140F, 1e-4F);
  EXPECT_THAT(error_of("b.obj", "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
              HasSubstr("colours at 1 of 3 vertices"));
  EXPECT_THAT(error_of("b.obj", "v 0 0 0 255 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
              AllOf(HasSubstr("line 1"), HasSubstr("not in [0, 1]")));
}

TEST_F(UserMeshFiles, PlyColoursAreKept) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const auto colour = [](const std::string& type) {
    return "property " + type + " red\nproperty " + type + " green\nproperty " + type + " blue\n";
  };
  const std::string integers =
      head + colour("uchar") + face + "0 0 0 255 0 0\n1 0 0 1 1 1\n0 1 0 0 0 0\n3 0 1 2\n";
  const UserMesh user = read_user_mesh(write("a.ply", integers));
  EXPECT_EQ(user.vertex_albedo[0], (Rgbf{1, 0, 0}));
  EXPECT_NEAR(user.vertex_albedo[1].r, 1 / 255.0F / 12.92F, 1e-7F);  // an integer 1 is nearly black
  const std::string floats =
      head + colour("float") + face + "0 0 0 1 0 0\n1 0 0 1 1 1\n0 1 0 0 2 0\n3 0 1 2\n";
  EXPECT_THAT(error_of("b.ply", floats), AllOf(HasSubstr("vertex 2"), HasSubstr("[0, 1]")));
}

TEST_F(UserMeshFiles, MoreTrianglesThanTheLimitAreRefused) {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\nf 1 2 3\n";
  EXPECT_EQ(error_of("a.obj", three, 3), "");
  EXPECT_THAT(error_of("a.obj", three, 2), HasSubstr("more than 2 triangles"));
  write("a b.bin", tetrahedron_bytes());
  EXPECT_THAT(error_of("a.gltf", tetrahedron_gltf(kBeside, R"({"mesh":0})"), 3),
              HasSubstr("more than 3 triangles"));
  EXPECT_THAT(error_of("a.fbx", "x"), HasSubstr(".ply, .obj, .stl, .gltf, .glb"));
}

TEST_F(UserMeshFiles, WeldingKeepsTheColoursOfWhatComesFirst) {
  UserMesh user;
  user.mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 1, 0}};
  user.mesh.triangles = {{0, 1, 3}, {2, 1, 3}};
  user.vertex_albedo = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  const UserMesh one = welded(user);
  ASSERT_EQ(one.mesh.vertices_m.size(), 3U);
  EXPECT_THAT(one.vertex_albedo, ElementsAre(Rgbf{1, 0, 0}, Rgbf{0, 1, 0}, Rgbf{1, 1, 1}));
}

/// The end of an L-shaped prism of height 1 whose outline begins at corner `first`: area 4 + 10
/// + 4.
std::string l_prism(bool is_obj, std::size_t first) {
  constexpr int kL[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  std::vector<std::vector<std::size_t>> faces(2);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t k = (first + i) % 6, next = (i + 1) % 6;
    faces[0].push_back(5 - k);
    faces[1].push_back(6 + k);
    faces.push_back({i, next, 6 + next, 6 + i});
  }
  std::string points, rows;
  for (int z = 0; z < 2; ++z) {
    for (const auto& [x, y] : kL)
      points += std::string(is_obj ? "v " : "") + std::to_string(x) + " " + std::to_string(y) +
                " " + std::to_string(z) + "\n";
  }
  for (const auto& face : faces) {
    rows += is_obj ? "f" : std::to_string(face.size());
    for (const std::size_t corner : face) rows += " " + std::to_string(corner + (is_obj ? 1 : 0));
    rows += "\n";
  }
  if (is_obj) return points + rows;
  return "ply\nformat ascii 1.0\nelement vertex 12\nproperty float x\nproperty float y\n"
         "property float z\nelement face 8\nproperty list uchar int vertex_indices\nend_header\n" +
         points + rows;
}

TEST_F(UserMeshFiles, ConcaveFacesHaveTheirAreaWhicheverVertexComesFirst) {
  for (std::size_t first = 0; first < 6; ++first) {
    for (const bool is_obj : {true, false}) {
      const Mesh mesh = read_mesh(write(is_obj ? "l.obj" : "l.ply", l_prism(is_obj, first)));
      EXPECT_TRUE(check_watertight(mesh).ok) << check_watertight(mesh).problem;
      EXPECT_NEAR(mass_properties(mesh).area_m2, 18, 1e-12) << first << is_obj;
      EXPECT_NEAR(mass_properties(mesh).volume_m3, 4, 1e-12) << first << is_obj;
    }
  }
}

TEST_F(UserMeshFiles, AFaceThatCrossesItselfIsRefusedWithItsLine) {
  EXPECT_THAT(error_of("a.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n"),
              AllOf(HasSubstr("a.obj: line 5"), HasSubstr("crosses itself")));
}

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST_F(UserMeshFiles, ObjNamesMayHaveBlanksAndLinesMayBeJoined) {
  const UserMesh user =
      read_user_mesh(write("a.obj", kTriangle + "o Leaf 1 \r\nf 1 2 \\\n3\ng Leaf 2\nf 3 2 1\n"));
  EXPECT_THAT(user.part_names, ElementsAre("Leaf 1", "Leaf 2"));
  EXPECT_EQ(user.mesh.triangles.size(), 2U);
  EXPECT_TRUE(user_mesh_warnings(folder_ / "a.obj").empty());
}

TEST_F(UserMeshFiles, AnObjNameThatIsNotUtf8IsRefusedWithItsLine) {
  EXPECT_THAT(error_of("a.obj", kTriangle + "o Bl\xE4tter\nf 1 2 3\n"),
              AllOf(HasSubstr("a.obj: line 4"), HasSubstr("Bl\\xe4tter"), HasSubstr("UTF-8")));
  EXPECT_EQ(error_of("a.obj", "# Bl\xE4tter\n" + kTriangle + "f 1 2 3\n"), "");
}

TEST_F(UserMeshFiles, WhatWouldBeAnotherObjMeshIsRefusedByName) {
  EXPECT_THAT(error_of("a.obj", kTriangle + "cstype bezier\n"), HasSubstr("\"cstype\""));
  EXPECT_THAT(error_of("a.obj", kTriangle + "call b.obj\n"), HasSubstr("\"call\""));
  EXPECT_THAT(error_of("a.obj", "v 0 0 0 2\n"), HasSubstr("the weight 2"));
  EXPECT_THAT(error_of("a.obj", "v 0 0 0 1 1\n"), HasSubstr("a vertex of 5 numbers"));
}

TEST_F(UserMeshFiles, MaterialsOfAnObjAreSaidNotToBeRead) {
  const std::vector<std::string> warnings =
      user_mesh_warnings(write("a.obj", "mtllib a.mtl\nusemtl green\n" + kTriangle + "f 1 2 3\n"));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], AllOf(HasSubstr("a.obj"), HasSubstr("materials")));
}

std::string one_triangle_stl(std::uint32_t count, const std::string& header = "x") {
  std::string bytes = header + std::string(80 - header.size(), '\0') + raw<std::uint32_t>({count});
  return bytes + raw<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}) + raw<std::uint16_t>({0});
}

TEST_F(UserMeshFiles, BytesBehindABinaryStlAreAWarning) {
  for (const char* header : {"x", "solid"}) {
    const UserMesh user = read_user_mesh(write("a.stl", one_triangle_stl(1, header) + "\r\n"));
    EXPECT_EQ(user.mesh.triangles.size(), 1U);
    const std::vector<std::string> warnings = user_mesh_warnings(folder_ / "a.stl");
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_THAT(warnings[0], AllOf(HasSubstr("a.stl"), HasSubstr("2 bytes")));
  }
  EXPECT_TRUE(user_mesh_warnings(write("a.stl", one_triangle_stl(1))).empty());
}

TEST_F(UserMeshFiles, ABinaryStlWithAWrongCountIsRefusedWithBoth) {
  EXPECT_THAT(error_of("a.stl", one_triangle_stl(0)),
              HasSubstr("0 triangles, but 50 bytes follow"));
  EXPECT_THAT(error_of("a.stl", one_triangle_stl(2)),
              AllOf(HasSubstr("2 triangles has 184 bytes"), HasSubstr("has 134")));
}

TEST_F(UserMeshFiles, TextStlTakesAnyNameAndAnyCase) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
      "0\nendloop\nendfacet\n";
  const std::string text = "solid vertex loop model\n" + facet + "endsolid vertex loop model\n";
  EXPECT_EQ(read_user_mesh(write("a.stl", text + text)).mesh.triangles.size(), 2U);
  std::string upper = text;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  EXPECT_EQ(read_user_mesh(write("a.stl", upper)).mesh.triangles.size(), 1U);
  EXPECT_THAT(error_of("a.stl",
                       "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n"
                       "vertex 0 1 0\nendloop\nendfacet\nendsolid\n"),
              AllOf(HasSubstr("line 8"), HasSubstr("4 corners")));
}

std::string ply_of(
    const std::string& properties, const std::string& rows,
    const std::string& faces = "element face 1\nproperty list uchar int vertex_indices\n") {
  return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
         "float z\n" +
         properties + faces + "end_header\n" + rows;
}

TEST_F(UserMeshFiles, WhatIsLeftBehindAPlyIsAWarning) {
  const std::vector<std::string> warnings =
      user_mesh_warnings(write("a.ply", ply_of("", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 2 1 0\n")));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], AllOf(HasSubstr("a.ply"), HasSubstr("8 bytes")));
}

TEST_F(UserMeshFiles, PlyFacesWithoutCornersAndStripsAreRefused) {
  EXPECT_THAT(error_of("a.ply", ply_of("", "0 0 0\n1 0 0\n0 1 0\n1 0.5\n",
                                       "element face 1\nproperty list uchar float texcoord\n")),
              HasSubstr("vertex_indices"));
  EXPECT_THAT(
      error_of("a.ply", ply_of("", "0 0 0\n1 0 0\n0 1 0\n4 0 1 2 -1\n",
                               "element tristrips 1\nproperty list int int vertex_indices\n")),
      HasSubstr("tristrips"));
}

TEST_F(UserMeshFiles, GltfShapesThatAreNotReadAreRefusedByName) {
  write("a b.bin", tetrahedron_bytes());
  const auto error = [&](const std::string& node, const std::string& extra = "") {
    return error_of("a.gltf", tetrahedron_gltf(kBeside, node, extra));
  };
  EXPECT_EQ(error(R"({"mesh":0})"), "");
  EXPECT_THAT(error(R"({"mesh":0,"skin":0})"), HasSubstr("/nodes/0/skin"));
  EXPECT_THAT(error(R"({"mesh":0,"weights":[0.5]})"), HasSubstr("/nodes/0/weights"));
  EXPECT_EQ(error(R"({"mesh":0,"weights":[0]})"), "");
  EXPECT_THAT(error(R"({"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{}}})"),
              HasSubstr("EXT_mesh_gpu_instancing"));
}

TEST_F(UserMeshFiles, GltfLooksThatAreNotReadAreWarnings) {
  write("a b.bin", tetrahedron_bytes());
  // The material gives no metallicFactor: 1, says glTF.
  std::string text = tetrahedron_gltf(kBeside, R"({"mesh":0})");
  std::vector<std::string> warnings = user_mesh_warnings(write("a.gltf", text));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], AllOf(HasSubstr("a.gltf: /materials/0"), HasSubstr("metallicFactor")));
  const std::string factor = "\"baseColorFactor\"";
  text.insert(text.find(factor), R"("metallicFactor":0,"baseColorTexture":{"index":0},)");
  warnings = user_mesh_warnings(write("a.gltf", text));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], HasSubstr("textures are not read"));
}

TEST(Units, AreMetresPerUnit) {
  EXPECT_EQ(metres_per_unit("mm"), 1e-3);
  EXPECT_EQ(metres_per_unit("in"), 0.0254);
  try {
    metres_per_unit("furlong");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("furlong"), HasSubstr("m, dm, cm, mm")));
  }
}

}  // namespace
}  // namespace cousin
