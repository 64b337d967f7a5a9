#include "benchmarks/loop/plant_run.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace cousin {
namespace {

namespace fs = std::filesystem;

TEST(PlantRun, EveryScenesResolvedConfigurationReadsBackAsItIs) {
  const std::vector<std::pair<const char*, PlantSceneConfig>> scenes = {
      {"seedlings", SeedlingsSceneConfig()}, {"maize", MaizeSceneConfig()},
      {"apples", ApplesSceneConfig()},       {"boards", BoardsSceneConfig()},
      {"specimen", SpecimenSceneConfig()},   {"strawberries", StrawberriesSceneConfig()}};
  for (const auto& [name, scene] : scenes) {
    std::vector<std::string> sets = {"views=3"};
    if (std::holds_alternative<SpecimenSceneConfig>(scene)) {
      const fs::path mesh = fs::path(testing::TempDir()) / "plant_run_cube.obj";
      std::ofstream(mesh) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
      sets.push_back("mesh=" + mesh.string());
    }
    const PlantRunConfig config = plant_run_config(scene, sets);
    const fs::path file =
        fs::path(testing::TempDir()) / ("plant_run_" + std::string(name) + ".toml");
    std::ofstream(file) << resolved_toml(config);
    PlantRunConfig back;
    ASSERT_NO_THROW(back = plant_run_config(scene, {}, file)) << name;
    EXPECT_EQ(resolved_toml(back), resolved_toml(config)) << name;
    EXPECT_EQ(config_hash(back, 1), config_hash(config, 1)) << name;
    fs::remove(file);
  }
}

}  // namespace
}  // namespace cousin
