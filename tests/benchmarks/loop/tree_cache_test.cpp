#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

#include "benchmarks/loop/rest_folder.h"
#include "sim/dataset/atomic_file.h"
#include "tests/scenes/apples/small_orchard.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

class TreeCache : public testing::Test {
 protected:
  void SetUp() override {
    if (!COUSIN_WITH_MUJOCO) GTEST_SKIP() << "WITH_MUJOCO is OFF";
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    config.cache = (fs::path(testing::TempDir()) / ("trees_at_rest_" + test)).string();
    fs::remove_all(config.cache);
  }
  void TearDown() override {
    if (!config.cache.empty()) fs::remove_all(config.cache);
  }
  Scene build(std::uint64_t seed) const {
    const RestFolder kept(config.cache);
    return build_apples_scene(config, Rng(seed),
                              tree_settler(config, {.seed = seed, .rests = &kept}));
  }
  static fs::path file_of(const ApplesSceneConfig& config, std::uint64_t seed, int index) {
    return RestFolder(config.cache).file(tree_key(config, {.seed = seed, .index = index}), ".tree");
  }
  ApplesSceneConfig config = small_orchard();
};

TEST_F(TreeCache, TheSceneIsTheSameFromTheFolderAsFresh) {
  const Scene fresh = build(1);
  const fs::path file = file_of(config, 1, 0);
  ASSERT_TRUE(fs::exists(file));
  const Scene kept = build(1);
  ASSERT_EQ(kept.instances.size(), fresh.instances.size());
  for (std::size_t i = 0; i < fresh.instances.size(); ++i) {
    const Pose &a = fresh.instances[i].world_from_object, &b = kept.instances[i].world_from_object;
    EXPECT_EQ(a.translation_m, b.translation_m);
    EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
  }
  // What decides it names it.
  ApplesSceneConfig other = config;
  other.fuji.mass_kg *= 1.01;
  EXPECT_NE(file_of(other, 1, 0), file);
  EXPECT_NE(file_of(config, 2, 0), file);
  EXPECT_NE(file_of(config, 1, 1), file);
  // What does not, does not.
  other = config;
  other.light = "back";
  other.views = 1;
  other.orchard.ground.grass_m = 0.05;
  EXPECT_EQ(file_of(other, 1, 0), file);
}

TEST_F(TreeCache, ADamagedFileIsAnErrorThatNamesIt) {
  build(2);
  const fs::path file = file_of(config, 2, 0);
  const std::string whole = read_file(file);
  for (const std::string& bytes : {std::string(), whole.substr(0, 500), whole + "x",
                                   std::string(whole).replace(200, 1, "#")}) {
    write_file(file, bytes);
    try {
      build(2);
      ADD_FAILURE() << bytes.size();
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace cousin
