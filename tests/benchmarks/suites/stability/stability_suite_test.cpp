#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "benchmarks/suites/stability/ray_cases.h"
#include "benchmarks/suites/stability/suite.h"
#include "scenes/seeds/seeds_scene.h"

namespace cousin {
namespace {

TEST(StabilitySuite, EveryCaseHoldsItsLimit) {
  const ScoreFile file = stability_suite(true);
  std::map<ScoreStatus, int> count;
  std::map<std::string, int> passed;  // by module
  for (const ScoreRow& row : file.scores) {
    ++count[row.status];
    passed[row.scene] += row.status == ScoreStatus::pass ? 1 : 0;
    EXPECT_NE(row.status, ScoreStatus::fail)
        << row.case_name << ", " << row.metric << " " << row.value << " " << row.unit;
    EXPECT_NE(row.status, ScoreStatus::error) << row.case_name << ": " << row.metric;
  }
  // Those that are always built in.
  std::map<std::string, int> least = {{"geometry", 20},           {"lenses and light", 10},
                                      {"depths and fusion", 25},  {"rays", 50},
                                      {"rays at bad meshes", 50}, {"light at its limits", 20},
                                      {"watertight seeds", 6},    {"splats", 14},
                                      {"training of splats", 35}, {"radiance fields", 28}};
#ifndef COUSIN_NO_CERES
  least.insert({{"structure from motion", 15}, {"bundles", 15}, {"calibration", 12}});
#endif
  for (const auto& [module, cases] : least) EXPECT_GE(passed[module], cases) << module;
}

TEST(StabilitySuite, RaysEscapeFromASeedThatLacksATriangle) {
  Mesh mesh = make_seed("suijing18", SizeSpread::literature, Rng(1)).model.mesh;
  const StabilityRow whole = watertight_case("whole", mesh, 200'000, Rng(2));
  EXPECT_TRUE(whole.pass) << whole.value;
  // One of 23 000 triangles: about nine rays in 200 000 meet it.
  mesh.triangles.erase(mesh.triangles.begin() + 5000);
  const StabilityRow open = watertight_case("open", mesh, 200'000, Rng(2));
  EXPECT_FALSE(open.pass);
  EXPECT_GT(open.value, 0);
}

TEST(StabilitySuite, ARowFailsBeyondItsLimitOnEitherSideAndForNoNumber) {
  EXPECT_TRUE(make_row("", "", "", 2, 2).pass);
  EXPECT_FALSE(make_row("", "", "", 2, 2.1).pass);
  EXPECT_TRUE(make_row("", "", "", 2, 2, false).pass);
  EXPECT_FALSE(make_row("", "", "", 2, 1.9, false).pass);
  EXPECT_FALSE(make_row("", "", "", 2, std::nan("")).pass);
  EXPECT_FALSE(make_row("", "", "", 2, std::nan(""), false).pass);
}

}  // namespace
}  // namespace cousin
