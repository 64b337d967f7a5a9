#include "sim/geometry/mesh_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "sim/geometry/measure.h"
#include "tests/sim/geometry/solids.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class MeshIo : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("cousin_mesh_io_") + info->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) const {
    fs::remove(folder_ / name);  // ext4 flushes a file that is cut and written again
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::string bytes_of(const fs::path& file) const {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::string error_of(const std::string& name, const std::string& bytes) const {
    try {
      read_mesh(write(name, bytes));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

template <class T>
std::string raw(T value, std::endian order = std::endian::little) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return order == std::endian::native ? bytes : std::string(bytes.rbegin(), bytes.rend());
}

void expect_same(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.vertices_m, b.vertices_m);
  EXPECT_EQ(a.triangles, b.triangles);
}

std::string binary_stl(const Mesh& mesh, const std::string& header = "binary") {
  std::string bytes = header;
  bytes.resize(80, ' ');
  bytes += raw(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) bytes += raw(0.0F);
    for (const std::uint32_t v : t) {
      for (const double c : mesh.vertices_m[v]) bytes += raw(static_cast<float>(c));
    }
    bytes += raw(std::uint16_t{0});
  }
  return bytes;
}

TEST_F(MeshIo, PlyRoundTripsToTheBit) {
  const Mesh mesh = ellipsoid_mesh({0.1, 1.0 / 3, 2e-9}, 2);
  write_ply(folder_ / "sub" / "a.ply", mesh);
  expect_same(read_mesh(folder_ / "sub" / "a.ply"), mesh);
}

TEST_F(MeshIo, PlyOfEveryEncodingSkipsWhatIsUnknown) {
  const std::string body_header =
      "comment made by hand\nelement camera 1\nproperty list uchar short angles\nproperty double "
      "focus\n"
      "element vertex 4\nproperty float x\nproperty float y\nproperty uchar red\nproperty float z\n"
      "element face 2\nproperty list uchar float texcoord\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  const Mesh expected{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}},
                      {{0, 1, 2}, {0, 2, 3}, {0, 1, 3}}};
  const std::string ascii =
      "ply\nformat ascii 1.0\n" + body_header +
      "2 7 -8 0.5\n0 0 255 0\n1 0 0 0\n1 1 7 0.5\n0 1 9 0\n1 0.5 4 0 1 2 3\n0 3 0 1 3\n";
  expect_same(read_mesh(write("a.ply", ascii)), expected);
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    std::string bytes = std::string("ply\nformat binary_") +
                        (order == std::endian::little ? "little" : "big") + "_endian 1.0\n" +
                        body_header;
    bytes += raw(std::uint8_t{2}) + raw(std::int16_t{7}, order) + raw(std::int16_t{-8}, order) +
             raw(0.5, order);
    for (const auto& v : expected.vertices_m) {
      bytes += raw(static_cast<float>(v.x()), order) + raw(static_cast<float>(v.y()), order) +
               raw(std::uint8_t{9}) + raw(static_cast<float>(v.z()), order);
    }
    bytes += raw(std::uint8_t{1}) + raw(0.5F, order) + raw(std::uint8_t{4});
    for (const std::int32_t i : {0, 1, 2, 3}) bytes += raw(i, order);
    bytes += raw(std::uint8_t{0}) + raw(std::uint8_t{3});
    for (const std::int32_t i : {0, 1, 3}) bytes += raw(i, order);
    expect_same(read_mesh(write("b.ply", bytes)), expected);
  }
}

TEST_F(MeshIo, ObjTakesSlashesNegativeIndicesAndPolygons) {
  const Mesh mesh = read_mesh(
      write("a.obj",
            "# comment\nmtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1.0\nvt 0 0\nvn 0 0 1\n"
            "f 1/1/1 2/1/1 3//1 4\nf -4 -3/1 -1\r\n"));
  EXPECT_EQ(mesh.vertices_m.size(), 4U);
  EXPECT_EQ(mesh.triangles,
            (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}}));
}

TEST_F(MeshIo, StlIsWeldedAndTheSizeTellsBinary) {
  const Mesh box = box_mesh({4, 2, 1});
  for (const std::string& header : {std::string("binary"), std::string("solid but binary")}) {
    const Mesh mesh = read_mesh(write("a.STL", binary_stl(box, header)));
    EXPECT_EQ(mesh.vertices_m.size(), 8U);
    EXPECT_TRUE(check_watertight(mesh).ok);
  }
  std::string ascii = "solid box\n";
  for (const auto& t : box.triangles) {
    ascii += "facet normal 0 0 0\nouter loop\n";
    for (const std::uint32_t v : t) {
      ascii += "vertex";
      for (const double c : box.vertices_m[v]) ascii += " " + std::to_string(c);
      ascii += "\n";
    }
    ascii += "endloop\nendfacet\n";
  }
  const Mesh mesh = read_mesh(write("b.stl", ascii + "endsolid box\n"));
  EXPECT_EQ(mesh.vertices_m.size(), 8U);
  EXPECT_NEAR(mass_properties(mesh).volume_m3, 8, 1e-12);
}

TEST_F(MeshIo, CloudsAndClustersRoundTrip) {
  Clusters clusters;
  Rng rng(1);
  for (int i = 0; i < 50; ++i) {
    CloudPoint p;
    p.position_m = Eigen::Vector3f::Random();
    p.normal = Eigen::Vector3f::UnitY();
    p.color = {static_cast<std::uint8_t>(i), 7, 255};
    p.sigma_m = 1e-4F;
    clusters.cloud.push_back(p);
    clusters.instance.push_back(i % 4 - 1);
  }
  clusters.count = 3;
  write_ply(folder_ / "clusters.ply", clusters);
  const Clusters back = read_cloud_ply(folder_ / "clusters.ply");
  EXPECT_EQ(back.instance, clusters.instance);
  EXPECT_EQ(back.count, 3);
  write_ply(folder_ / "cloud.ply", clusters.cloud);
  const Clusters plain = read_cloud_ply(folder_ / "cloud.ply");
  EXPECT_EQ(plain.count, 0);
  for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
    EXPECT_EQ(plain.instance[i], -1);
    EXPECT_EQ(plain.cloud[i].position_m, clusters.cloud[i].position_m);
    EXPECT_EQ(plain.cloud[i].normal, clusters.cloud[i].normal);
    EXPECT_EQ(plain.cloud[i].color, clusters.cloud[i].color);
    EXPECT_EQ(plain.cloud[i].sigma_m, clusters.cloud[i].sigma_m);
  }
  clusters.instance.pop_back();
  EXPECT_THROW(write_ply(folder_ / "c.ply", clusters), std::invalid_argument);
}

TEST_F(MeshIo, ErrorsNameTheFileAndThePlace) {
  EXPECT_THROW(read_mesh(folder_ / "none.ply"), std::runtime_error);
  EXPECT_THROW(read_mesh(folder_), std::runtime_error);
  EXPECT_THAT(error_of("a.fbx", "x"), AllOf(HasSubstr("a.fbx"), HasSubstr(".ply, .obj, .stl")));
  EXPECT_THAT(error_of("a.ply", ""), HasSubstr("a.ply"));
  EXPECT_THAT(
      error_of("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty floaty x\nend_header\n"),
      AllOf(HasSubstr("line 4"), HasSubstr("floaty")));
  EXPECT_THAT(error_of("a.obj", "v 0 0 0\nv 1 0\n"), HasSubstr("a.obj: line 2"));
  EXPECT_THAT(error_of("a.obj", "v 0 0 0\nf 1 1 2\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("\"2\" is no vertex")));
  EXPECT_THAT(error_of("a.obj", "v 0 0 nan\n"), HasSubstr("finite"));
  EXPECT_THAT(error_of("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n"), HasSubstr("fewer than 3"));
  EXPECT_THAT(error_of("a.stl", "solid x\nvertex 0 0 0\n"), HasSubstr("a.stl"));
  EXPECT_THAT(error_of("a.stl", "not an stl"), HasSubstr("a.stl"));
}

TEST_F(MeshIo, HugeCountsAreRefusedBeforeMemoryIsTaken) {
  const std::string vertex = "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  EXPECT_THAT(error_of("a.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 60000000" +
                                    vertex + "abc"),
              HasSubstr("too short for 60000000 vertex"));
  EXPECT_THAT(
      error_of("a.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999999999999" + vertex),
      HasSubstr("not in 0..2^26"));
  EXPECT_THAT(error_of("a.ply", "ply\nformat ascii 1.0\nelement vertex -1" + vertex),
              HasSubstr("not in 0..2^26"));
  const std::string face = "ply\nformat binary_little_endian 1.0\nelement vertex 0" +
                           vertex.substr(0, vertex.find("end_header")) +
                           "element face 1\nproperty list uint int vertex_indices\nend_header\n";
  EXPECT_THAT(error_of("a.ply", face + raw(std::uint32_t{0xFFFFFFFF})),
              HasSubstr("too short for a list"));
  std::string stl = binary_stl(box_mesh({1, 1, 1}));
  std::memset(stl.data() + 80, 0xFF, 4);
  EXPECT_NE(error_of("a.stl", stl), "");
}

TEST_F(MeshIo, EveryTruncationIsAnErrorOrASmallerMesh) {
  const Mesh mesh = tetrahedron_mesh();
  write_ply(folder_ / "whole.ply", mesh);
  const std::string ply = bytes_of(folder_ / "whole.ply"), stl = binary_stl(mesh);
  for (std::size_t size = 0; size < ply.size(); ++size)
    EXPECT_NE(error_of("cut.ply", ply.substr(0, size)), "") << size;
  for (std::size_t size = 0; size < stl.size(); ++size)
    EXPECT_NE(error_of("cut.stl", stl.substr(0, size)), "") << size;
}

TEST_F(MeshIo, FlippedBitsAreReadOrRefusedNeverMore) {
  write_ply(folder_ / "a.ply", tetrahedron_mesh());
  const std::pair<std::string, std::string> seeds[] = {
      {"x.ply", bytes_of(folder_ / "a.ply")},
      {"x.stl", binary_stl(tetrahedron_mesh())},
      {"x.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1/1 2/2 3/3\nf -1 -2 -3\n"}};
  Rng rng(4);
  for (const auto& [name, good] : seeds) {
    for (int trial = 0; trial < 200; ++trial) {
      std::string bad = good;
      for (int flips = 0; flips < 3; ++flips) {
        bad[uniform_index(rng, bad.size())] ^= static_cast<char>(1U << uniform_index(rng, 8));
      }
      error_of(name, bad);
    }
  }
}

TEST_F(MeshIo, AFileThatCannotBeWrittenIsNamedAndLeavesNothing) {
  write_ply(folder_ / "a.ply", tetrahedron_mesh());
  try {
    write_ply(folder_ / "a.ply" / "b.ply", tetrahedron_mesh());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("b.ply"));
  }
  fs::create_directories(folder_ / "taken.ply");
  EXPECT_THROW(write_ply(folder_ / "taken.ply", tetrahedron_mesh()), std::runtime_error);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

}  // namespace
}  // namespace cousin
