#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/loop/scene_list.h"
#include "benchmarks/loop/simulate.h"
#include "scenes/apples/apples_scene.h"
#include "scenes/boards/boards_scene.h"
#include "scenes/maize/maize_scene.h"
#include "scenes/seedlings/seedlings_scene.h"
#include "scenes/seeds/seeds_scene.h"
#include "scenes/specimen/specimen_scene.h"
#include "scenes/strawberries/strawberries_scene.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

std::vector<const SceneRow*> scene_rows() {
  std::vector<const SceneRow*> rows = {&seeds_row()};
#define COUSIN_ADD(text, row) rows.push_back(&row());
  COUSIN_PART_SCENES(COUSIN_ADD)
#undef COUSIN_ADD
  return rows;
}

/// Settings of a short run; what a scene has no default for is there.
std::vector<std::string> short_settings(const std::string& scene) {
  std::vector<std::string> sets = {"views=3"};
  if (scene == "specimen") {
    const fs::path mesh = fs::path(testing::TempDir()) / "plant_run_cube.obj";
    std::ofstream(mesh) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    sets.push_back("mesh=" + mesh.string());
  }
  return sets;
}

TEST(RunConfig, EverySpecimenIsOfACategoryOfItsScene) {
  for (const SceneRow* row : scene_rows()) {
    const std::string name(row->text.name);
    const RunConfig config = run_config(*row, short_settings(name));
    if (physics_of(config.scene).runs && !COUSIN_WITH_MUJOCO) continue;
    const std::vector<std::string> categories = specimen_categories(config.scene);
    EXPECT_TRUE(std::is_sorted(categories.begin(), categories.end())) << name;
    const Scene scene = built_scene(config, 1, 0);
    EXPECT_FALSE(specimens_of(scene).empty()) << name;
    for (const Instance* specimen : specimens_of(scene))
      EXPECT_THAT(categories, testing::Contains(specimen->category)) << name;
  }
}

TEST(RunConfig, EveryScenesResolvedConfigurationReadsBackAsItIs) {
  for (const SceneRow* row : scene_rows()) {
    const std::string name(row->text.name);
    const RunConfig config = run_config(*row, short_settings(name));
    const fs::path file = fs::path(testing::TempDir()) / ("plant_run_" + name + ".toml");
    std::ofstream(file) << resolved_toml(config);
    RunConfig back = config;
    ASSERT_NO_THROW(back = run_config(*row, {}, file)) << name;
    EXPECT_EQ(resolved_toml(back), resolved_toml(config)) << name;
    EXPECT_EQ(config_hash(back, 1), config_hash(config, 1)) << name;
    fs::remove(file);
  }
}

/// What is read from the text of a file.
RunConfig from_text(const SceneRow& row, const std::string& text) {
  const fs::path file = fs::path(testing::TempDir()) / "run_config_text.toml";
  std::ofstream(file) << text;
  RunConfig config = run_config(row, {}, file);
  fs::remove(file);
  return config;
}

TEST(RunConfig, RenderByDecidesWhatRenderHoldsInEveryScene) {
  const RunConfig seeds = run_config(seeds_row(), {"render.edge_samples=16"});
  EXPECT_EQ(seeds.cached.edge_samples, 16);
  const RunConfig traced = run_config(seeds_row(), {"render.pixel_samples=24", "render.by=paths"});
  EXPECT_EQ(traced.radiance, RadianceBy::paths);
  EXPECT_EQ(traced.paths.pixel_samples, 24);
  EXPECT_EQ(traced.paths.max_bounces, 5);
  const RunConfig maize = run_config(maize_row(), {"render.pixel_samples=9"});
  EXPECT_EQ(maize.paths.pixel_samples, 9);
  EXPECT_THROW(run_config(seeds_row(), {"render.by=paths", "render.edge_samples=16"}),
               std::invalid_argument);
  try {
    run_config(maize_row(), {"render.by=cached"});
    ADD_FAILURE() << "leaves are cached";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("leaves let light through"), std::string::npos)
        << error.what();
  }
  EXPECT_THROW(from_text(maize_row(), "[render]\nby = \"cached\"\n"), std::runtime_error);
}

TEST(RunConfig, FilesOfEarlierVersionsAreRead) {
  const RunConfig seeds = from_text(seeds_row(),
                                    "[capture]\nradiance = \"paths\"\n[render]\nedge_samples = "
                                    "16\n[paths]\npixel_samples = 12\n");
  EXPECT_EQ(seeds.radiance, RadianceBy::paths);
  EXPECT_EQ(seeds.paths.pixel_samples, 12);
  EXPECT_EQ(seeds.cached.edge_samples, 16);
  const RunConfig maize = from_text(maize_row(), "[render]\npixel_samples = 7\n");
  EXPECT_EQ(maize.paths.pixel_samples, 7);
}

TEST(RunConfig, TheTableOfAPipelineIsReadWhereNobodyReadsTheImagesAndItsMistakesAreSaid) {
  const RunConfig config =
      from_text(seeds_row(), "[scene]\nviews = 7\n[pipeline]\nmethod = \"paper\"\n");
  EXPECT_EQ(config.scene.views(), 7);
  EXPECT_FALSE(config.pipeline.has_value());
  EXPECT_THROW(from_text(seeds_row(), "[pipeline]\nmethod = \"paper\"\nno_such_key = 1\n"),
               std::runtime_error);
}

}  // namespace
}  // namespace cousin
