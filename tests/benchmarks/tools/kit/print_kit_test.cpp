#include "benchmarks/tools/kit/print_kit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <set>

#include "sim/dataset/atomic_file.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/mesh_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

double trait_of(const KitObject& object, const std::string& name) {
  for (const TrueTrait& trait : object.traits) {
    if (trait.name == name) return trait.value;
  }
  return -1;
}

TEST(PrintKit, FilesAreClosedAtTrueSizeAndHaveTheTraitsThatTheTableSays) {
  const fs::path folder = fs::path(testing::TempDir()) / "print_kit";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const std::vector<KitObject> kit = print_kit(1);
  ASSERT_EQ(kit.size(), 17U);  // six cultivars, strawberries and apples twice; a sphere
  write_print_kit(folder, kit);
  std::set<std::string> there;
  for (const auto& entry : fs::directory_iterator(folder))
    there.insert(entry.path().filename().string());
  const std::vector<std::string> said = print_kit_files(kit);
  EXPECT_EQ(there, std::set<std::string>(said.begin(), said.end()));
  for (const KitObject& object : kit) {
    const Mesh mesh_mm = read_mesh(folder / (object.name + ".stl"));
    const MeshCheck check = check_watertight(mesh_mm);
    EXPECT_TRUE(check.ok) << object.name << ": " << check.problem;
    EXPECT_NEAR(mass_properties(mesh_mm).volume_m3 * 1e-9 / trait_of(object, "volume"), 1, 1e-4)
        << object.name;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& v : mesh_mm.vertices_m) box.extend(v);
    EXPECT_NEAR(box.min().z(), 0, 1e-5) << object.name;
    EXPECT_LT(box.sizes().maxCoeff(), 120) << object.name;
    EXPECT_GT(box.sizes().maxCoeff(), 4) << object.name;
  }
  for (const char* trait : {"length", "width", "height"})  // of the box about its facets
    EXPECT_NEAR(trait_of(kit.back(), trait), 0.022, 2e-5) << trait;
  EXPECT_THAT(read_file(folder / "traits.csv"), HasSubstr("sphere_22mm,\"sphere\",length,mm,"));
  fs::remove_all(folder);
}

TEST(PrintKit, IsTheSameOfOneSeedAndAnotherOfAnother) {
  const auto volume = [](std::uint64_t seed) {
    return trait_of(print_kit(seed).front(), "volume");
  };
  EXPECT_EQ(volume(3), volume(3));
  EXPECT_NE(volume(3), volume(4));
}

}  // namespace
}  // namespace cousin
