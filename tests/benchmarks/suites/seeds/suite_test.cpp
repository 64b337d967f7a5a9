#include "benchmarks/suites/seeds/suite.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/score/score_columns.h"
#include "benchmarks/suites/seeds/paper_tables.h"
#include "scenes/seeds/seeds_scene.h"
#include "sim/dataset/atomic_file.h"
#include "tests/sim/dataset/temporary_folder.h"

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
    settings_of_schema_1(row);
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

ScoreFile held_seeds_suite(const std::vector<ShardResult>& results,
                           const SeedsSuiteConfig& config) {
  ScoreFile pooled = pool_seeds_suite(results, config);
  hold_seeds_suite(config, pooled);
  return pooled;
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
  const ScoreFile pooled = held_seeds_suite(
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
  const ScoreFile one = held_seeds_suite(
      {finished("suijing18", 0, 3e-5, 1e-4), without_poses("xiangyaxiangzhan", 0)}, {});
  EXPECT_NEAR(find(one, "seeds", "rice", "ours", "camera.centre_rms")->value, 1e-4, 1e-12);
  EXPECT_EQ(find(one, "seeds", "rice", "ours", "views.posed")->value, 0.5);
  const ScoreFile none =
      held_seeds_suite({without_poses("suijing18", 0), without_poses("xiangyaxiangzhan", 0)}, {});
  EXPECT_EQ(find(none, "seeds", "rice", "ours", "views.posed")->status, ScoreStatus::fail);
  EXPECT_EQ(find(none, "seeds", "rice", "ours", "camera.centre_rms")->status, ScoreStatus::fail);
}

TEST(SeedsSuite, ThePapersSpreadIsPooledApart) {
  const ScoreFile pooled = held_seeds_suite(
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
  const ScoreFile pooled = held_seeds_suite(
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
        find(held_seeds_suite(results, config), "seeds", "rice", "ours", "length.rmse")->status,
        ScoreStatus::ok);
  }
}

TEST(SeedsSuite, TheSameSeedsAreNotCountedTwice) {
  SeedsSuiteConfig config;
  config.quick = true;
  EXPECT_EQ(seeds_suite_jobs(config).size(), 5U);
  config.sets = {"cultivar=jimai22"};
  EXPECT_EQ(seeds_suite_jobs(config).size(), 3U);  // one with Gaussians, one photographed twice
}

// A job's name is the file of its kept result: another name makes it anew.
TEST(SeedsSuite, JobsKeepTheirNames) {
  const auto names = [](const SeedsSuiteConfig& config) {
    std::string text;
    for (const ShardJob& job : seeds_suite_jobs(config))
      text += job.name.substr(0, job.name.find(".json")) + " ";
    return text;
  };
  std::string runs;
  for (const char* run : {"1", "2", "3", "4"}) {
    for (const char* cultivar :
         {"zhengdan958", "tianguinuo932", "jimai22", "aikang58", "suijing18", "xiangyaxiangzhan"})
      runs += std::string(cultivar) + "_run" + run + " ";
  }
  EXPECT_EQ(names({}),
            "zhengdan958_run0 tianguinuo932_run0 jimai22_run0 aikang58_run0 suijing18_run0 "
            "xiangyaxiangzhan_run0 sphere_run0 zhengdan958_720p jimai22_720p suijing18_720p " +
                runs +
                "zhengdan958_splats zhengdan958_ngp zhengdan958_noise tianguinuo932_splats "
                "tianguinuo932_ngp tianguinuo932_noise jimai22_splats jimai22_ngp jimai22_noise "
                "aikang58_splats aikang58_ngp aikang58_noise suijing18_splats suijing18_ngp "
                "suijing18_noise xiangyaxiangzhan_splats xiangyaxiangzhan_ngp "
                "xiangyaxiangzhan_noise sphere_splats zhengdan958_splats_30k "
                "zhengdan958_surfaces_30k zhengdan958_images_30k zhengdan958_ngp_30k "
                "zhengdan958_splats_sfm zhengdan958_splats_adjusted "
                "zhengdan958_270views_splats_sfm zhengdan958_270views tianguinuo932_270views "
                "jimai22_270views aikang58_270views suijing18_270views xiangyaxiangzhan_270views "
                "zhengdan958_paper_spread tianguinuo932_paper_spread jimai22_paper_spread "
                "aikang58_paper_spread suijing18_paper_spread xiangyaxiangzhan_paper_spread ");
  SeedsSuiteConfig quick;
  quick.quick = true;
  EXPECT_EQ(names(quick),
            "quick_zhengdan958 quick_jimai22 quick_suijing18 quick_splats_zhengdan958 "
            "quick_noise_zhengdan958 ");
  // Keys of a job are those that a user would give.
  const ShardJob last = seeds_suite_jobs({}).back();
  EXPECT_THAT(last.grid.sets,
              testing::ElementsAre("cultivar=xiangyaxiangzhan", "rig=phone_video_1080p", "views=60",
                                   "spread=paper"));
}

TEST(SeedsSuite, CapturesForGaussiansAreNotTakenForThoseOfTheCurves) {
  int found = 0;
  for (const ShardJob& job : seeds_suite_jobs(SeedsSuiteConfig{}))
    found += job.name == "zhengdan958_splats.json" || job.name == "zhengdan958_720p.json";
  EXPECT_EQ(found, 2);
}

TEST(SeedsSuite, EachCultivarHasGaussiansRadianceFieldAndNoiseOnceEach) {
  std::map<std::string, int> found;
  for (const ShardJob& job : seeds_suite_jobs(SeedsSuiteConfig{})) ++found[job.name];
  for (const std::string& cultivar : cultivar_names()) {
    for (const char* kind : {"_splats.json", "_ngp.json", "_noise.json"})
      EXPECT_EQ(found[cultivar + kind], 1) << cultivar << kind;
  }
  for (const char* method : {"splats", "surfaces", "images", "ngp"})  // as far, on one run
    EXPECT_EQ(found["zhengdan958_" + std::string(method) + "_30k.json"], 1) << method;
  for (const auto& [name, count] : found) EXPECT_EQ(count, 1) << name;
}

TEST(SeedsSuite, TrainedModelsStandBesideThePublishedOnesAndTheirLimits) {
  ScoreFile file;
  for (const std::string& cultivar : cultivar_names()) {
    const auto add = [&](const char* method, int steps, const char* metric, double value,
                         double cpu_s) {
      ScoreRow row;
      row.suite = kSplatsSuite;
      row.scene = cultivar;
      row.case_name = cultivar + " run 0 60 views 1280x720, " + std::to_string(steps) + " steps";
      settings_of_schema_1(row);
      row.method = method;
      row.metric = metric;
      row.value = value;
      row.wall_s = row.cpu_s = cpu_s;
      file.scores.push_back(row);
    };
    add("splats", 600, "cloud_seen.accuracy_mean", 2e-4, 30);
    add("splats", 1200, "cloud_seen.accuracy_mean", cultivar == "jimai22" ? 1.1e-4 : 9e-5, 60);
    add("splats_paper", 7000, "train.psnr_whole", 38, 700);
    add("splats_paper", 7000, "seconds.perceive", 700, 700);
    add("splats_images", 3000, "train.psnr_whole", 39.5, 200);
    add("splats_images", 9000, "train.psnr_whole", 45, 800);
    add("splats_images", 3000, "held_out.psnr_whole", cultivar == "jimai22" ? 37.9 : 38.1, 200);
    add("splats_images", 9000, "held_out.psnr_whole", 40, 800);
    for (const char* method : {"splats", "splats_paper"}) {
      for (int i = 0; i < 2; ++i) {
        SpecimenRow row;
        row.dataset = kSplatsSuite;
        row.scene = row.cultivar = cultivar;
        row.run = "0";
        row.instance = i;
        row.method = method;
        row.trait = "length";
        row.unit = "m";
        row.truth = 0.01 + 1e-4 * i;
        row.measured = row.truth + (method == std::string("splats") ? 1e-5 : 1e-4) * (i + 1);
        file.specimens.push_back(row);
      }
    }
  }
  ShardResult result;
  result.name = "all.json";
  result.text = to_json(file);
  const ScoreFile pooled = held_seeds_suite({result}, {});
  const auto row_of = [&](const std::string& scene, const std::string& method,
                          const std::string& metric, const std::string& end = "") {
    for (const ScoreRow& row : pooled.scores) {
      if (row.scene == scene && row.method == method && row.metric == metric &&
          row.case_name.ends_with(end))
        return row;
    }
    ADD_FAILURE() << scene << " " << method << " " << metric;
    return ScoreRow();
  };
  const auto status = [&](const std::string& cultivar, const std::string& steps) {
    return row_of(cultivar, "splats", "cloud_seen.accuracy_mean", steps).status;
  };
  EXPECT_EQ(status("jimai22", "1200 steps"), ScoreStatus::fail);
  EXPECT_EQ(status("suijing18", "1200 steps"), ScoreStatus::pass);
  EXPECT_EQ(status("suijing18", ", 600 steps"), ScoreStatus::ok);  // on the way
  const ScoreRow gain =
      row_of("aikang58", "splats_images", "train.psnr_whole_gain_at_equal_cpu_seconds");
  EXPECT_DOUBLE_EQ(gain.value, 1.5);
  EXPECT_EQ(gain.status, ScoreStatus::pass);
  const auto gap = [&](const std::string& cultivar, const std::string& steps) {
    return row_of(cultivar, "splats_images", "psnr_whole.train_less_held_out", steps);
  };
  EXPECT_NEAR(gap("suijing18", "3000 steps").value, 1.4, 1e-12);
  EXPECT_EQ(gap("suijing18", "3000 steps").status, ScoreStatus::pass);
  EXPECT_EQ(gap("jimai22", "3000 steps").status, ScoreStatus::fail);
  EXPECT_EQ(gap("jimai22", "9000 steps").status, ScoreStatus::ok);
  EXPECT_EQ(row_of("pooled", "splats/splats_paper", "length.rmse_ratio", "all").status,
            ScoreStatus::pass);
  // A ratio, and seeds that were found, are not kept by what is missing.
  EXPECT_EQ(row_of("pooled", "splats/splats_paper", "width.rmse_ratio", "all").status,
            ScoreStatus::fail);
  EXPECT_EQ(row_of("jimai22", "splats", "specimens.found").status, ScoreStatus::fail);
  // The paper's way beside what it published: .1 and .2 mm are .158 of .304.
  EXPECT_NEAR(
      row_of("pooled", "splats_paper/published: 3DGS", "length.rmse_over_published", "zhengdan958")
          .value,
      std::sqrt((1e-8 + 4e-8) / 2) / 3.04e-4, 1e-9);
  const std::vector<ReportTable> tables = seeds_paper_tables(pooled.scores);
  const auto line_of = [&](const std::string& title, const std::string& first,
                           const std::string& second) {
    for (const ReportTable& table : tables) {
      if (!table.title.starts_with(title)) continue;
      for (const auto& line : table.lines) {
        if (line[0] == first && line[1] == second) return line;
      }
    }
    ADD_FAILURE() << title << ": " << first << ", " << second;
    return std::vector<std::string>(20);
  };
  EXPECT_EQ(line_of("Seeds, table 1", "published: 3DGS", "7000")[4], "198203");
  EXPECT_EQ(line_of("Seeds, table 1", "3DGS, the paper's way", "7000")[2], "700");
  EXPECT_EQ(line_of("Seeds, table 2", "zhengdan958", "published: 3DGS")[5], "0.304");
  EXPECT_EQ(line_of("Seeds, table 2", "zhengdan958", "3DGS, the paper's way")[5], "0.158");
  EXPECT_EQ(line_of("Seeds, table 3", "jimai22", "3DGS, the paper's way")[4], "38.00");
  EXPECT_EQ(line_of("Seeds, table 4", "jimai22", "published: 3DGS")[5], "0.118");
  EXPECT_EQ(line_of("Seeds, table 5", "aikang58", "34.94")[2], "38.00");
  EXPECT_EQ(line_of("Seeds, paired", "published: 3DGS/SfM-MVS", "zhengdan958")[4], "-2.54");
  // The paper's own numbers, in SI units.
  EXPECT_DOUBLE_EQ(row_of("zhengdan958", "published: SfM-MVS", "height.rmse").value, 0.000553);
  EXPECT_DOUBLE_EQ(row_of("jimai22", "published: 3DGS", "psnr", "7000 steps").value, 34.89);
  EXPECT_DOUBLE_EQ(row_of("zhengdan958", "published: 3DGS/SfM-MVS", "length.paired_t_p").value,
                   0.0143);
  const auto published = [](const ScoreRow& row) { return row.method.starts_with("published"); };
  EXPECT_EQ(std::count_if(pooled.scores.begin(), pooled.scores.end(), published),
            10 + 7 * 9 + 6 * 6 + 6 + 2);
  // Without trained models nothing is said of any.
  const ScoreFile others = held_seeds_suite({finished("suijing18", 0, 2e-4, 3e-4)}, {});
  EXPECT_EQ(std::count_if(others.scores.begin(), others.scores.end(), published), 0);
}

TEST(SeedsSuite, PublishedLinesAreShownOnlyBesideLinesOfOurOwn) {
  ShardResult result;
  result.name = "jimai22_ngp.json";
  ScoreFile file;
  ScoreRow row;
  row.suite = kSplatsSuite;
  row.scene = "jimai22";
  row.case_name = "jimai22 run 0 60 views 1280x720, 7000 steps";
  settings_of_schema_1(row);
  row.method = "instant-ngp";
  row.metric = "train.psnr_whole_small";
  row.value = 53;
  file.scores.push_back(row);
  result.text = to_json(file);
  const ScoreFile pooled = held_seeds_suite({result}, {});
  const std::vector<ReportTable> tables = seeds_paper_tables(pooled.scores);
  ASSERT_EQ(tables.size(), 1U);  // nothing else was measured
  EXPECT_TRUE(tables[0].title.starts_with("Seeds, table 5"));
  ASSERT_EQ(tables[0].lines.size(), 1U);
  EXPECT_EQ(tables[0].lines[0][0], "jimai22");
  EXPECT_EQ(tables[0].lines[0][8], "53.00");
}

TEST(SeedsSuite, PosesByColmapHaveATableAndNoLineInThePapers) {
  std::vector<ScoreRow> rows;
  const auto add = [&](const char* photographs, const char* metric, double value,
                       int steps = 7000) {
    ScoreRow row;
    row.suite = kSplatsSuite;
    row.scene = "zhengdan958";
    row.case_name =
        std::string("zhengdan958 run 0 ") + photographs + ", " + std::to_string(steps) + " steps";
    settings_of_schema_1(row);
    row.method = "splats_paper";
    row.metric = metric;
    row.value = value;
    row.wall_s = 300;
    rows.push_back(row);
  };
  const auto sizes = [&] {
    for (const ReportTable& table : seeds_paper_tables(rows)) {
      if (table.title.starts_with("Seeds, sizes by photographs")) return table.lines;
    }
    return std::vector<std::vector<std::string>>();
  };
  add("60 views 1280x720", "curve.length.rmse", 8e-4);
  add("60 views 1280x720", "train.psnr_whole", 38);
  EXPECT_TRUE(sizes().empty());  // all of the board
  add("270 views 1920x1080, poses sfm", "curve.length.rmse", 3e-4);
  add("270 views 1920x1080, poses sfm", "camera.centre_rms", 2e-3);
  add("270 views 1920x1080, poses sfm", "seconds.perceive", 300);
  ASSERT_EQ(sizes().size(), 2U);
  EXPECT_EQ(sizes()[0][0], "60 views 1280x720");
  EXPECT_EQ(sizes()[0][1], "board");
  EXPECT_EQ(sizes()[0][12], "38.00");
  EXPECT_EQ(sizes()[1][0], "270 views 1920x1080");
  EXPECT_EQ(sizes()[1][1], "sfm");
  EXPECT_EQ(sizes()[1][3], "2.00");
  EXPECT_EQ(sizes()[1][8], "0.300");
  add("270 views 1920x1080, poses sfm", "curve.length.rmse", 4e-4, 30000);
  add("270 views 1920x1080, poses sfm", "curve.length.rmse", 5e-4, 5000);
  add("270 views 1280x720, poses sfm", "curve.length.rmse", 6e-4);
  ASSERT_EQ(sizes().size(), 5U);
  EXPECT_EQ(sizes()[0][0], "60 views 1280x720");
  EXPECT_EQ(sizes()[1][0], "270 views 1280x720");
  EXPECT_EQ(sizes()[2][5], "5000");  // in the order of steps, as a training passes them
  EXPECT_EQ(sizes()[3][5], "7000");
  EXPECT_EQ(sizes()[4][5], "30000");
  for (const ReportTable& table : seeds_paper_tables(rows))
    EXPECT_FALSE(table.title.starts_with("Seeds, table 1"));
}

TEST(SeedsSuite, AGapThatIsMissingWhereViewsWereHeldOutIsAFailure) {
  ScoreFile file;
  ScoreRow row;
  row.suite = kSplatsSuite;
  row.scene = "zhengdan958";
  row.method = "splats_images";
  for (const int steps : {1000, 3000}) {
    row.case_name = "zhengdan958 run 0 60 views 1280x720, one in 8 held out, " +
                    std::to_string(steps) + " steps";
    settings_of_schema_1(row);
    for (const auto& [metric, value] :
         {std::pair("train.psnr_whole", 42.0), std::pair("held_out.psnr_whole", 41.0),
          std::pair("train.psnr_object", 41.0)}) {
      row.metric = metric;
      row.value = value;
      file.scores.push_back(row);
    }
  }
  ShardResult result;
  result.name = "all.json";
  result.text = to_json(file);
  std::map<std::string, ScoreStatus> gaps;
  for (const ScoreRow& pooled : held_seeds_suite({result}, {}).scores) {
    if (pooled.metric.ends_with(".train_less_held_out"))
      gaps[pooled.metric.substr(0, pooled.metric.find('.')) +
           pooled.case_name.substr(pooled.case_name.rfind(','))] = pooled.status;
  }
  EXPECT_THAT(gaps, testing::ElementsAre(std::pair("psnr_object, 3000 steps", ScoreStatus::fail),
                                         std::pair("psnr_whole, 1000 steps", ScoreStatus::ok),
                                         std::pair("psnr_whole, 3000 steps", ScoreStatus::pass)));
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
