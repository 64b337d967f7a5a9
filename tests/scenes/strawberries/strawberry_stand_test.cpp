#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "benchmarks/loop/rest_folder.h"
#include "benchmarks/suites/scenes/leaf_crossing.h"
#include "sim/dataset/atomic_file.h"
#include "tests/scenes/strawberries/small_stretch.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

class StrawberryStand : public testing::Test {
 protected:
  void SetUp() override {
    config.cache = fs::path(testing::TempDir()) / "stands" /
                   testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(config.cache);
  }
  void TearDown() override { fs::remove_all(config.cache); }
  StandRest at_rest(std::uint64_t seed, int plant) const {
    const RestFolder kept(config.cache);
    return stand_at_rest(config, seed, plant, config.cache.empty() ? nullptr : &kept);
  }
  static fs::path file_of(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant) {
    return RestFolder(config.cache).file(stand_key(config, seed, plant), ".stand");
  }
  StrawberriesSceneConfig config = small_stretch(2);
};

TEST_F(StrawberryStand, HangsWithoutOverlapsAndItsPlantsKeepOff) {
  config.cache.clear();
  const StandRest rest = at_rest(1, 0);
  EXPECT_EQ(rest.sag.status, PlantStatus::ok);
  EXPECT_LE(rest.sag.max_penetration_m, 5e-4);
  const Scene scene = build_strawberries_scene(config, rest, stretch_rng(1, 0), Rng(1));
  EXPECT_LT(plants_in_fruits_m(scene), 5e-4);
  for (const Instance& instance : scene.instances) {
    if (instance.is_specimen) EXPECT_LT(instance.world_from_object.translation_m.z(), -0.03);
  }
}

TEST_F(StrawberryStand, LeavesHardlyCrossAndSepalsLieOnTheFruitsBesideTheirs) {
  config = small_stretch(7);
  const StandRest rest = at_rest(3, 0);
  const Scene scene = build_strawberries_scene(config, rest, stretch_rng(3, 0), Rng(1));
  std::vector<const Instance*> plants;
  for (const Instance& instance : scene.instances) {
    if (instance.name.starts_with("plant ")) plants.push_back(&instance);
  }
  const SurfaceCrossing crossing = leaf_crossing(scene, plants);
  EXPECT_GT(crossing.area_m2, 0.1);
  EXPECT_LT(crossing.share(), 0.01);
  EXPECT_LT(sepals_in_fruits_m(scene), 5e-4);
}

TEST_F(StrawberryStand, IsTheSameFromTheFolderAsFreshAndOnAnyThreads) {
  const StandRest fresh = at_rest(2, 1);
  const fs::path file = file_of(config, 2, 1);
  ASSERT_TRUE(fs::exists(file));
  EXPECT_EQ(to_text(at_rest(2, 1)), to_text(fresh));
  fs::remove(file);
  EXPECT_EQ(to_text(at_rest(2, 1)), to_text(fresh));
  // What decides it names it.
  StrawberriesSceneConfig other = config;
  other.stand.heavier = 1.01;
  EXPECT_NE(file_of(other, 2, 1), file);
  EXPECT_NE(file_of(config, 3, 1), file);
  EXPECT_NE(file_of(config, 2, 2), file);
  // What does not, does not.
  other = config;
  other.light = "noon";
  other.plant.leaf.leaflet_m = 0.05;
  EXPECT_EQ(file_of(other, 2, 1), file);
}

TEST_F(StrawberryStand, EveryNumberOfTrussesAndVarietiesIsAKeyAndNamesTheFile) {
  const fs::path file = file_of(config, 2, 1);
  for (const char* assignment :
       {"truss.peduncle_length_m=0.11", "truss.bed_slope_rad=0.1",
        "varieties.akihime.mass_kg=0.021", "varieties.benihoppe.hollow=0.03"}) {
    StrawberriesSceneConfig other = config;
    set_field(fields(other), assignment);
    EXPECT_NO_THROW(validate(other)) << assignment;
    EXPECT_NE(file_of(other, 2, 1), file) << assignment;
  }
  StrawberriesSceneConfig heavy = config;
  heavy.stand.variety = "akihime";
  const double before_kg =
      grow_trusses(draw_stand(heavy.stand, heavy.bed, Rng(1)), Rng(1))[0].fruits[0].mass_kg;
  set_field(fields(heavy), "varieties.akihime.mass_kg=0.04");
  const double after_kg =
      grow_trusses(draw_stand(heavy.stand, heavy.bed, Rng(1)), Rng(1))[0].fruits[0].mass_kg;
  EXPECT_NEAR(after_kg / before_kg, 2, 1e-9);  // from 0.02: masses scale with their mean
}

TEST_F(StrawberryStand, ADamagedFileIsAnErrorThatNamesIt) {
  at_rest(4, 0);
  const fs::path file = file_of(config, 4, 0);
  const std::string whole = read_file(file);
  for (const std::string& bytes : {std::string(), std::string("sha256"), whole.substr(0, 500),
                                   whole + "x", std::string(whole).replace(200, 1, "#")}) {
    write_file(file, bytes);
    try {
      at_rest(4, 0);
      ADD_FAILURE() << bytes.size();
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos) << error.what();
    }
  }
}

TEST_F(StrawberryStand, FruitsTooHeavyForTheirStalksAreRefusedWithTheStatus) {
  config.stand.heavier = 90;
  try {
    at_rest(5, 0);
    FAIL() << "it hangs";
  } catch (const std::runtime_error& error) {
    // A stalk breaks, or the engine gives up on what lies on the film.
    const std::string message = error.what();
    EXPECT_NE(message.find("too heavy for their stalks at heavier = 90"), std::string::npos)
        << message;
    EXPECT_NE(message.find("status"), std::string::npos) << message;
  }
  EXPECT_FALSE(fs::exists(file_of(config, 5, 0)));
}

}  // namespace
}  // namespace cousin
