#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/suites/seeds/cousins_suite.h"

namespace cousin {
namespace {

using ::testing::HasSubstr;

TEST(SeedsCousins, ATwinHasTheReferencesConfigurationAndAnAxisMovesItsOwnPart) {
  const RunConfig reference = seeds_run_config({});
  EXPECT_EQ(resolved_toml(cousin_of(reference, 1, 0).config), resolved_toml(reference));
  const RunCousin dark = cousin_of(seeds_run_config({"cousin.light=0.5"}), 1, 0);
  EXPECT_NE(seeds_scene(dark.config).vary.light_contrast, 1);
  EXPECT_EQ(seeds_scene(dark.config).vary.size, 1);
  EXPECT_EQ(dark.changes.size(), 3U);
  const RunCousin noisy = cousin_of(seeds_run_config({"cousin.sensor=1"}), 1, 0);
  const auto& phone = std::get<PhoneConfig>(noisy.config.rig);
  EXPECT_DOUBLE_EQ(phone.blur_sigma_px, 1.3);
  EXPECT_NE(phone.read_noise_e, std::get<PhoneConfig>(reference.rig).read_noise_e);
}

TEST(SeedsCousins, EachSceneIsAnotherCousinAndTheSameOneTwice) {
  const RunConfig config = seeds_run_config({"cousin.growth=1"});
  const auto size = [&](std::uint64_t seed, int scene) {
    return seeds_scene(cousin_of(config, seed, scene).config).vary.size;
  };
  EXPECT_EQ(size(1, 0), size(1, 0));
  EXPECT_NE(size(1, 0), size(1, 1));
  EXPECT_NE(size(1, 0), size(2, 0));
}

TEST(SeedsCousins, OnlyWhatDecidesTheImagesNamesTheirStore) {
  EXPECT_EQ(simulator_toml(seeds_run_config({})).find("[cousin]"), std::string::npos);
  EXPECT_THAT(simulator_toml(seeds_run_config({"cousin.shape=0.3"})), HasSubstr("shape = 0.3"));
}

std::string refusal(const std::vector<std::string>& sets) {
  try {
    seeds_run_config(sets);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SeedsCousins, RefuseWhatCannotBeMovedSayingWhy) {
  EXPECT_EQ(refusal({"cousin.shape=1", "cousin.growth=1", "cousin.texture=1", "cousin.light=1",
                     "cousin.sensor=1"}),
            "accepted");
  EXPECT_THAT(refusal({"cousin.shape=1.1"}), HasSubstr("cousin.shape"));
  EXPECT_THAT(refusal({"cousin.shape=nan"}), HasSubstr("cousin.shape"));
  EXPECT_THAT(refusal({"cousin.colour=1"}), HasSubstr("cousin.colour"));
  EXPECT_THAT(refusal({"cousin.shape=0.1", "sphere=true"}), HasSubstr("not grown"));
  EXPECT_THAT(refusal({"cousin.texture=0.1", "gloss=false"}), HasSubstr("gloss is false"));
  EXPECT_THAT(refusal({"cousin.growth=0.1", "seeds=0"}), HasSubstr("no seeds"));
  // What the user moved to its limit cannot go farther.
  EXPECT_THAT(refusal({"cousin.growth=1", "vary.size=2.4"}),
              testing::AllOf(HasSubstr("cousin.growth = 1"), HasSubstr("vary.size")));
}

ShardResult result_of(const std::string& point, const std::string& run, double error_m) {
  ScoreFile file;
  for (int i = 0; i < 6; ++i) {
    SpecimenRow row;
    row.dataset = point;
    row.run = run;
    row.instance = i;
    row.cultivar = "zhengdan958";
    row.method = "ours";
    row.trait = "length";
    row.unit = "m";
    row.truth = 0.010 + 1e-4 * i;
    row.measured = row.truth + error_m;
    if (i == 5) row.status = ScoreStatus::not_solved;
    file.specimens.push_back(row);
  }
  ShardResult result;
  result.name = point;
  result.text = to_json(file);
  return result;
}

TEST(CousinsSuite, PoolsEachPointAndPlotsItFromTheTwin) {
  const CousinsSuiteConfig config{.quick = true, .sets = {}};
  const std::vector<ShardResult> results = {
      result_of("twin", "0", 1e-5), result_of("twin", "1", 1e-5), result_of("shape 0.5", "0", 2e-5),
      result_of("shape 0.5", "1", 2e-5), result_of("shape 1", "0", 4e-5)};
  const ScoreFile pooled = pool_cousins_suite(results, config);
  const auto value = [&](const std::string& point, const std::string& metric) {
    for (const ScoreRow& row : pooled.scores) {
      if (row.case_name == point && row.metric == metric) return row.value;
    }
    return ScoreRow::kNone;
  };
  EXPECT_NEAR(value("twin", "length.rmse"), 1e-5, 1e-12);
  EXPECT_NEAR(value("shape 0.5", "length.rmse"), 2e-5, 1e-12);
  EXPECT_NEAR(value("shape 1", "length.bias"), 4e-5, 1e-12);
  EXPECT_NEAR(value("shape 1", "specimens.measured"), 5.0 / 6, 1e-12);

  const std::vector<LinePlot> plots = cousins_plots(pooled.scores);
  ASSERT_EQ(plots.size(), 2U);  // length, and what was found: no other trait has rows
  ASSERT_EQ(plots[0].series.size(), 1U);
  EXPECT_EQ(plots[0].series[0].name, "shape");
  ASSERT_EQ(plots[0].series[0].points.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const PlotPoint& point = plots[0].series[0].points[static_cast<std::size_t>(i)];
    EXPECT_DOUBLE_EQ(point.x, 0.5 * i);
    EXPECT_NEAR(point.y.value, 0.01 * (1 << i), 1e-9);  // millimetres
  }
  EXPECT_TRUE(cousins_plots({}).empty());
}

TEST(CousinsSuite, JobsCoverEveryAxisOnceAndKnowWhatTheyDependOn) {
  const auto names = [](const CousinsSuiteConfig& config) {
    std::vector<std::string> list;
    for (const ShardJob& job : cousins_suite_jobs(config)) list.push_back(job.name);
    return list;
  };
  const CousinsSuiteConfig quick{.quick = true, .sets = {}};
  EXPECT_EQ(names(quick).size(), 11U);
  // A job's name is the file of its kept result: another name makes it anew.
  std::vector<std::string> full;
  for (const std::string run : {"0", "1", "2"}) {
    full.push_back("twin_run" + run + ".json");
    for (const std::string axis : {"shape", "growth", "texture", "light", "sensor"}) {
      for (const char* distance : {"_0.25", "_0.5", "_0.75", "_1"})
        full.push_back(axis + distance + "_run" + run + ".json");
    }
  }
  EXPECT_EQ(names({.runs = 3, .sets = {}}), full);
  EXPECT_THAT(
      names(quick),
      testing::ElementsAre("twin_run0.json", "shape_0.5_run0.json", "shape_1_run0.json",
                           "growth_0.5_run0.json", "growth_1_run0.json", "texture_0.5_run0.json",
                           "texture_1_run0.json", "light_0.5_run0.json", "light_1_run0.json",
                           "sensor_0.5_run0.json", "sensor_1_run0.json"));
  CousinsSuiteConfig other = quick;
  other.sets = {"cultivar=jimai22"};
  EXPECT_NE(cousins_suite_jobs(quick).front().key, cousins_suite_jobs(other).front().key);
}

}  // namespace
}  // namespace cousin
