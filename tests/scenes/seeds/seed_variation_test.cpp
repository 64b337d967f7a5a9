#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>

#include "scenes/seeds/cultivar.h"
#include "scenes/seeds/seeds_scene.h"
#include "scenes/seeds/variation.h"
#include "sim/config/cousin.h"
#include "sim/geometry/measure.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

double trait(const SeedModel& seed, const std::string& name) {
  for (const TrueTrait& t : seed.traits) {
    if (t.name == name) return t.value;
  }
  ADD_FAILURE() << name;
  return std::nan("");
}

SeedModel seed_of(const SeedVariation& vary, const std::string& cultivar = "zhengdan958") {
  return make_seed(cultivar, SizeSpread::literature, Rng(3), vary);
}

TEST(SeedVariation, NothingIsVariedByDefaultToTheLastBit) {
  for (const std::string& name : cultivar_names()) {
    const SeedModel plain = make_seed(name, SizeSpread::literature, Rng(3));
    const SeedModel varied_by_nothing = seed_of({}, name);
    EXPECT_EQ(plain.model.mesh.vertices_m, varied_by_nothing.model.mesh.vertices_m);
    EXPECT_EQ(plain.mass_kg, varied_by_nothing.mass_kg);
  }
}

TEST(SeedVariation, SizeScalesEveryTraitByItsPower) {
  const SeedModel plain = seed_of({}), large = seed_of({.size = 1.2});
  // Lumps and details are lengths of their own and stay: a few per cent of the volume.
  EXPECT_NEAR(trait(large, "length") / trait(plain, "length"), 1.2, 0.01);
  EXPECT_NEAR(trait(large, "area") / trait(plain, "area"), 1.44, 0.04);
  EXPECT_NEAR(trait(large, "volume") / trait(plain, "volume"), 1.728, 0.06);
}

TEST(SeedVariation, ElongationFillAndThicknessMoveTheirOwnSides) {
  const SeedModel plain = seed_of({});
  const auto ratio = [&](const SeedVariation& vary, const char* name) {
    return trait(seed_of(vary), name) / trait(plain, name);
  };
  EXPECT_NEAR(ratio({.elongation = 1.3}, "length"), std::sqrt(1.3), 0.02);
  EXPECT_NEAR(ratio({.elongation = 1.3}, "width"), 1 / std::sqrt(1.3), 0.02);
  EXPECT_NEAR(ratio({.thickness = 0.8}, "height"), 0.8, 0.02);
  EXPECT_NEAR(ratio({.fill = 0.8}, "volume"), 0.64, 0.04);
  EXPECT_NEAR(seed_of({.density = 1.1}).mass_kg / plain.mass_kg, 1.1, 1e-12);
}

TEST(SeedVariation, HarmonicsAreAnotherFamilyOfTheSameSize) {
  for (const std::string& name : cultivar_names()) {
    const SeedModel plain = seed_of({}, name), other = seed_of({.harmonics = 1}, name);
    EXPECT_TRUE(check_watertight(other.model.mesh).ok) << name;
    EXPECT_GT(trait(other, "volume"), 0.2 * trait(plain, "volume")) << name;
    EXPECT_LT(trait(other, "volume"), 2.5 * trait(plain, "volume")) << name;
    double apart_m = 0;
    for (std::size_t i = 0; i < plain.model.mesh.vertices_m.size(); ++i) {
      apart_m = std::max(apart_m,
                         (plain.model.mesh.vertices_m[i] - other.model.mesh.vertices_m[i]).norm());
    }
    EXPECT_GT(apart_m, 3e-4) << name;
    EXPECT_TRUE(check_watertight(seed_of({.harmonics = 0.5}, name).model.mesh).ok) << name;
  }
}

TEST(SeedVariation, ColoursStayReflectancesAtBothEnds) {
  for (const SeedVariation& vary :
       {SeedVariation{.brightness = 1.5, .warmth = 1.6, .mottle = 3},
        SeedVariation{.brightness = 1 / 1.5, .warmth = 1 / 1.6, .mottle = 1 / 3.0},
        SeedVariation{.green = 1}}) {
    for (const Rgbf& c : seed_of(vary, "tianguinuo932").model.vertex_albedo) {
      EXPECT_GE(std::min({c.r, c.g, c.b}), 0.0F);
      EXPECT_LE(std::max({c.r, c.g, c.b}), 1.0F);
    }
  }
}

TEST(SeedVariation, LargerLampsGiveTheSameIrradiance) {
  std::vector<Light> lights = {Lamp{{1, 0, 1}, {0.2, 0, 0}, {0, 0.1, 0}, {2, 2, 2}}};
  vary_lights(lights, {.light_turn_rad = std::acos(-1.0) / 2, .light_size = 3});
  const Lamp& lamp = std::get<Lamp>(lights[0]);
  EXPECT_LT((lamp.centre_in_world_m - Eigen::Vector3d(0, 1, 1)).norm(), 1e-12);
  const double power =
      lamp.axis_u_m.norm() * lamp.axis_v_m.norm() * static_cast<double>(lamp.radiance.r);
  EXPECT_NEAR(power, 0.2 * 0.1 * 2, 1e-8);  // float
}

TEST(SeedVariation, EveryRangeOfTheTablesHasItsSourceWord) {
  for (const char* scene : {"seeds", "seedlings", "maize"}) {
    std::ifstream in(source_folder() / "scenes" / scene / "cousins.toml");
    int ranges = 0;
    for (std::string line; std::getline(in, line);) {
      if (line.find(" = {") == line.npos) continue;
      ++ranges;
      EXPECT_TRUE(line.find("# free") != line.npos || line.find("# sourced: ") != line.npos)
          << scene << ": " << line;
    }
    EXPECT_GT(ranges, 15) << scene;
  }
}

}  // namespace
}  // namespace cousin
