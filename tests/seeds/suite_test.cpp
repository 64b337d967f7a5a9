#include "benchmarks/seeds/suite.h"

#include <gmock/gmock.h>

#include <cmath>

#include "benchmarks/seeds/result_folder.h"
#include "benchmarks/seeds/score_seeds.h"
#include "sim/dataset/atomic_file.h"
#include "tests/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::HasSubstr;

/// A finished job's text: ten seeds of a cultivar, each `error_m` too long, and the run's rows.
ShardResult finished(const std::string& cultivar, int run, double error_m, double centre_m,
                     const std::string& suite = "seeds") {
  ScoreFile file;
  for (const char* method : {"ours", "paper"}) {
    for (int i = 0; i < 10; ++i) {
      SpecimenRow row;
      row.dataset = suite;
      row.scene = row.cultivar = cultivar;
      row.run = std::to_string(run);
      row.instance = i;
      row.method = method;
      row.trait = "length";
      row.unit = "m";
      row.truth = 0.006 + 1e-4 * i;
      row.measured = row.truth + (method == std::string("ours") ? 1 : 4) * error_m;
      row.sigma = 1e-5;
      file.specimens.push_back(row);
    }
  }
  const auto add = [&](const std::string& metric, double value, std::int64_t n, double wall_s) {
    ScoreRow row;
    row.suite = suite;
    row.scene = cultivar;
    row.case_name = cultivar + " run " + std::to_string(run) + " 60 views 1920x1080";
    row.method = "ours";
    row.metric = metric;
    row.value = value;
    row.n = n;
    row.wall_s = row.cpu_s = wall_s;
    row.peak_rss_mb = 100 * wall_s;
    file.scores.push_back(row);
  };
  add("views.posed", run == 0 ? 1.0 : 0.5, 60, ScoreRow::kNone);
  add("camera.centre_rms", centre_m, run == 0 ? 60 : 30, ScoreRow::kNone);
  add("seconds.perceive", 10.0 + run, 1, 10.0 + run);
  ShardResult result;
  result.name = cultivar + "_run" + std::to_string(run) + ".json";
  result.text = to_json(file);
  return result;
}

const ScoreRow* find(const ScoreFile& file, const std::string& suite, const std::string& group,
                     const std::string& method, const std::string& metric) {
  for (const ScoreRow& row : file.scores) {
    if (row.suite == suite && row.scene == "pooled" && row.case_name == group &&
        row.method == method && row.metric == metric) {
      return &row;
    }
  }
  return nullptr;
}

TEST(SeedsSuite, PoolsSpecimensPosesAndSecondsOfASpecies) {
  const ScoreFile pooled = pool_seeds_suite(
      {finished("suijing18", 0, 3e-5, 3e-4), finished("xiangyaxiangzhan", 1, 3e-5, 6e-4),
       finished("zhengdan958", 0, 2e-4, 1e-4), finished("tianguinuo932", 0, 2e-4, 1e-4),
       finished("jimai22", 0, 2e-4, 1e-4)},
      {});
  const ScoreRow* rmse = find(pooled, "seeds", "rice", "ours", "length.rmse");
  ASSERT_TRUE(rmse);
  EXPECT_NEAR(rmse->value, 3e-5, 1e-12);
  EXPECT_EQ(rmse->n, 20);
  EXPECT_EQ(rmse->status, ScoreStatus::pass);
  EXPECT_DOUBLE_EQ(rmse->wall_s, 10.5);
  EXPECT_DOUBLE_EQ(rmse->peak_rss_mb, 1100);
  EXPECT_EQ(find(pooled, "seeds", "maize", "ours", "length.rmse")->status, ScoreStatus::fail);
  // Of two cultivars one alone is not the species.
  EXPECT_EQ(find(pooled, "seeds", "wheat", "ours", "length.rmse")->status, ScoreStatus::ok);
  const ScoreRow* posed = find(pooled, "seeds", "rice", "ours", "views.posed");
  ASSERT_TRUE(posed);
  EXPECT_DOUBLE_EQ(posed->value, 0.75);
  EXPECT_EQ(posed->status, ScoreStatus::fail);
  // Over views, not over runs: 60 and 30 of them.
  EXPECT_NEAR(find(pooled, "seeds", "rice", "ours", "camera.centre_rms")->value,
              std::sqrt((60 * 9e-8 + 30 * 36e-8) / 90), 1e-12);
  EXPECT_NEAR(find(pooled, "seeds", "rice", "ours/paper", "length.rmse_ratio")->value, 0.25, 1e-9);
}

TEST(SeedsSuite, ARunWithoutPosesIsNoNumberAndKeepsNoLimit) {
  const auto without_poses = [](const std::string& cultivar, int run) {
    ShardResult result = finished(cultivar, run, 3e-5, 3e-4);
    ScoreFile file = scores_from_json(result.text, "test");
    for (ScoreRow& row : file.scores) {
      if (row.metric == "views.posed") row.value = 0;
      if (row.metric == "camera.centre_rms") row.value = ScoreRow::kNone, row.n = 0;
    }
    result.text = to_json(file);
    return result;
  };
  const ScoreFile one = pool_seeds_suite(
      {finished("suijing18", 0, 3e-5, 1e-4), without_poses("xiangyaxiangzhan", 0)}, {});
  EXPECT_NEAR(find(one, "seeds", "rice", "ours", "camera.centre_rms")->value, 1e-4, 1e-12);
  EXPECT_EQ(find(one, "seeds", "rice", "ours", "views.posed")->value, 0.5);
  const ScoreFile none =
      pool_seeds_suite({without_poses("suijing18", 0), without_poses("xiangyaxiangzhan", 0)}, {});
  EXPECT_EQ(find(none, "seeds", "rice", "ours", "views.posed")->status, ScoreStatus::fail);
  EXPECT_EQ(find(none, "seeds", "rice", "ours", "camera.centre_rms")->status, ScoreStatus::fail);
}

TEST(SeedsSuite, ThePapersSpreadIsPooledApart) {
  const ScoreFile pooled = pool_seeds_suite(
      {finished("suijing18", 0, 3e-5, 1e-4), finished("suijing18", 0, 6e-5, 1e-4, kPaperSpread)},
      {});
  EXPECT_NEAR(find(pooled, "seeds", "rice", "ours", "length.rmse")->value, 3e-5, 1e-12);
  const ScoreRow* spread = find(pooled, kPaperSpread, "rice", "ours", "length.rmse");
  ASSERT_TRUE(spread);
  EXPECT_NEAR(spread->value, 6e-5, 1e-12);
  EXPECT_EQ(spread->status, ScoreStatus::ok);
  EXPECT_TRUE(find(pooled, kPaperSpread, "rice", "ours", "length.r2_paper"));
}

TEST(SeedsSuite, ItsTableTellsSuitesApart) {
  const ScoreFile pooled = pool_seeds_suite(
      {finished("suijing18", 0, 3e-5, 1e-4), finished("suijing18", 0, 6e-5, 1e-4, kSplatsSuite)},
      {});
  const std::string table = summary_table(pooled.scores);
  const std::size_t own = table.find("0.0300 mm"), splats = table.find("0.0600 mm");
  ASSERT_NE(own, std::string::npos) << table;
  ASSERT_NE(splats, std::string::npos) << table;
  const auto line_of = [&](std::size_t at) {
    const std::size_t begin = table.rfind('\n', at) + 1;
    return table.substr(begin, at - begin);
  };
  EXPECT_TRUE(line_of(own).starts_with("seeds "));
  EXPECT_TRUE(line_of(splats).starts_with("seeds_splats "));
}

TEST(SeedsSuite, OnlyTheWholeExperimentIsHeldToItsLimits) {
  const std::vector<ShardResult> results = {finished("suijing18", 0, 2e-4, 3e-4)};
  SeedsSuiteConfig changed;
  changed.sets = {"views=20"};
  SeedsSuiteConfig quick;
  quick.quick = true;
  for (const SeedsSuiteConfig& config : {changed, quick}) {
    EXPECT_EQ(
        find(pool_seeds_suite(results, config), "seeds", "rice", "ours", "length.rmse")->status,
        ScoreStatus::ok);
  }
}

TEST(SeedsSuite, TheSameSeedsAreNotCountedTwice) {
  SeedsSuiteConfig config;
  config.quick = true;
  EXPECT_EQ(seeds_suite_jobs(config).size(), 4U);
  config.sets = {"cultivar=jimai22"};
  EXPECT_EQ(seeds_suite_jobs(config).size(), 2U);  // one of them with Gaussians
}

TEST(SeedsSuite, CapturesForGaussiansAreNotTakenForThoseOfTheCurves) {
  int found = 0;
  for (const ShardJob& job : seeds_suite_jobs(SeedsSuiteConfig{}))
    found += job.name == "zhengdan958_splats.json" || job.name == "zhengdan958_720p.json";
  EXPECT_EQ(found, 2);
}

TEST(SeedsSuite, ItsConfigurationNamesEveryJob) {
  const SeedsSuiteConfig config;
  const std::string text = suite_toml(config);
  for (const ShardJob& job : seeds_suite_jobs(config))
    EXPECT_THAT(text, HasSubstr("# " + job.name));
  EXPECT_THAT(text, HasSubstr("cultivar = \"zhengdan958\""));
}

TEST(SeedsSuite, TheKeyTellsWhatTrainingsForImagesTake) {
  SeedsSuiteConfig config;
  config.quick = true;
  int found = 0;
  for (const ShardJob& job : seeds_suite_jobs(config)) {
    if (job.name != "quick_splats_zhengdan958.json") continue;
    ++found;
    EXPECT_THAT(job.key, HasSubstr("most_splats = 100000"));
    EXPECT_THAT(job.key, HasSubstr("low_pass_px2 = 0.03"));
  }
  EXPECT_EQ(found, 1);
}

TEST(SeedsSuite, AnotherMeshInTheSameFileIsMeasuredAnew) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "mine.obj";
  SeedsSuiteConfig config;
  config.quick = true;
  config.sets = {"specimen=mesh:" + file.string()};
  write_file(file, "v 0 0 0\n");
  const std::string key = seeds_suite_jobs(config).at(0).key;
  write_file(file, "v 0 0 1\n");
  EXPECT_NE(seeds_suite_jobs(config).at(0).key, key);
}

}  // namespace
}  // namespace cousin
