#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/score/score_columns.h"
#include "benchmarks/suites/seedlings/field_training.h"
#include "benchmarks/suites/seedlings/sample_pictures.h"
#include "benchmarks/suites/seedlings/seedlings_jobs.h"
#include "benchmarks/suites/seedlings/seedlings_rows.h"
#include "benchmarks/suites/seedlings/seedlings_suite.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

TEST(SeedlingsJobs, ThreeLightsThreeMethodsThreeSamples) {
  const std::vector<SeedlingsJob> jobs = seedlings_jobs({});
  std::set<std::string> names, keys, lights;
  std::map<std::string, std::set<int>> longest;  // of each method
  int full = 0, between = 0, shapes = 0;
  for (const SeedlingsJob& job : jobs) {
    names.insert(job.grid.name);
    keys.insert(key_of(job));
    lights.insert(job.sample.light);
    EXPECT_EQ(job.sample.width_px, 400);
    EXPECT_GE(job.sample.day, 2);
    EXPECT_LE(job.sample.day, 10);
    EXPECT_TRUE(std::is_sorted(job.plan.at.begin(), job.plan.at.end()));
    full += job.set.name == "30 views" && job.part.empty();
    between += job.part == "between" && job.plan.method == kOurs && job.set.views == 30;
    shapes += job.part == "shape" && job.set.views == 30;
    if (job.part == "long" || job.part == "shape") EXPECT_EQ(job.sample.number, 0);
    if (job.plan.method != kOurs || job.sample.views == 30)
      longest[job.plan.method].insert(job.plan.at.back());
  }
  EXPECT_EQ(names.size(), jobs.size());
  EXPECT_EQ(keys.size(), jobs.size());
  EXPECT_EQ(lights, (std::set<std::string>{"D1", "D2", "D3"}));
  EXPECT_EQ(full, 3 * 3 * 3);
  EXPECT_EQ(between, 3 * 3);
  EXPECT_EQ(shapes, 3 * 2);
  // More photographs of the first tray under each light, for ours alone.
  const auto more = std::count_if(jobs.begin(), jobs.end(), [](const SeedlingsJob& job) {
    return job.sample.views > 30 && job.set.views == job.sample.views && job.sample.number == 0 &&
           job.plan.method == kOurs &&
           job.plan.at == std::vector{kMoreViewsSteps / 2, kMoreViewsSteps};
  });
  EXPECT_EQ(more, 2 * 3);
  EXPECT_EQ(longest[kReference], (std::set<int>{7000, 30000}));
  EXPECT_EQ(longest[kOurs], (std::set<int>{3000, 7000, 30000}));
  EXPECT_EQ(longest[kNgp], (std::set<int>{7000, 30000}));
}

// A job's name is the file of its kept result: another name makes it anew.
TEST(SeedlingsJobs, KeepTheirNames) {
  const auto names = [](const SeedlingsSuiteConfig& config) {
    std::string text;
    for (const SeedlingsJob& job : seedlings_jobs(config)) text += job.grid.name + " ";
    return text;
  };
  std::string full, quick;
  for (const std::string light : {"D1", "D2", "D3"}) {
    for (const char* end : {"0_30_reference",
                            "0_30_ours",
                            "0_30_ngp",
                            "0_30_ours_between",
                            "0_20_reference",
                            "0_10_reference",
                            "0_30_side_reference",
                            "0_60_ours",
                            "0_120_ours",
                            "0_30_reference_shape",
                            "0_30_ours_shape",
                            "0_30_reference_long",
                            "0_30_ours_long",
                            "0_30_ngp_long",
                            "1_30_reference",
                            "1_30_ours",
                            "1_30_ngp",
                            "1_30_ours_between",
                            "2_30_reference",
                            "2_30_ours",
                            "2_30_ngp",
                            "2_30_ours_between"})
      full += light + "_" + end + "_400px ";
    for (const char* end : {"0_30_reference", "0_30_ours", "0_30_ngp", "0_10_reference",
                            "0_30_side_reference", "0_30_reference_shape", "0_30_ours_shape"})
      quick += light + "_" + end + "_200px ";
  }
  EXPECT_EQ(names({}), full);
  EXPECT_EQ(names({.quick = true}), quick);
}

TEST(SeedlingsJobs, TheKeyTellsWhatDecidesTheResult) {
  const SeedlingsJob job = seedlings_jobs({.quick = true}).front();
  const auto changed = [&](auto change) {
    SeedlingsJob other = job;
    change(other);
    return key_of(other) != key_of(job);
  };
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.sample.light = "D3"; }));
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.sample.number = 1; }));
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.sample.day += 1; }));
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.sample.width_px += 8; }));
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.sample.pixel_samples += 1; }));
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.set.views -= 1; }));
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.plan.at.push_back(12345); }));
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.plan.method = kNgp; }));
  EXPECT_TRUE(changed([](SeedlingsJob& j) { j.plan.start_points += 1; }));
  EXPECT_FALSE(changed([](SeedlingsJob& j) { j.shown = !j.shown; }));
  // Defaults that a build may change.
  SeedlingsJob ours = job;
  ours.plan.method = kOurs;
  EXPECT_NE(key_of(ours).find("low_pass0.1"), std::string::npos);
  EXPECT_NE(key_of(ours).find("swept"), std::string::npos);
}

TEST(FieldScores, OfManyViewsTrainedOnTenAreScored) {
  EXPECT_EQ(scored_views(3), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(scored_views(10).back(), 9u);
  const std::vector<std::size_t> of_thirty = scored_views(30);
  ASSERT_EQ(of_thirty.size(), 10u);
  EXPECT_EQ(of_thirty[1], 3u);
  EXPECT_EQ(of_thirty.back(), 27u);
  EXPECT_TRUE(scored_views(0).empty());
}

/// The mean difference of the first channel, in a network's place.
class MeanDifference final : public LearnedDistance {
 public:
  double between(const FidelityPlanes& image, const FidelityPlanes& photograph) const override {
    double sum = 0;
    for (std::size_t i = 0; i < image[0].size(); ++i)
      sum += std::abs(image[0].data()[i] - photograph[0].data()[i]);
    return sum / static_cast<double>(image[0].size());
  }
};

TEST(FieldScores, ANetworkSeesNoDifferenceWhereThePhotographShowsNothing) {
  constexpr int kSide = 16;
  SampleView view;
  SplatViewLevel level;
  level.camera = {LensModel::pinhole, kSide, kSide, 20, 20, 7.5, 7.5};
  for (Image<float>& channel : level.color.channel) channel = Image<float>(kSide, kSide, 0.0F);
  view.photograph.full = level;
  view.shown = Image<std::uint8_t>(kSide, kSide, 255);
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide / 4; ++y) view.shown(x, y) = 0;
  }
  view.seedlings = view.shown;
  const FieldRenderer white = [](const SplatView&) {
    const Image<float> one(kSide, kSide, 1.0F);
    return FidelityPlanes{one, one, one};
  };
  FieldViews views{{&view}, {}, {}, {}};
  EXPECT_TRUE(std::isnan(score_field(white, views).train.learned));
  views.learned = std::make_shared<MeanDifference>();
  EXPECT_EQ(score_field(white, views).train.learned, 0.75);

  // Right wherever the photograph shows something: neither windows nor filters see the rest.
  const FieldRenderer right = [](const SplatView& seen) {
    FidelityPlanes image = seen.full.color.channel;
    for (Image<float>& channel : image) {
      for (int i = 0; i < kSide * kSide / 4; ++i) channel.data()[i] = 1;
    }
    return image;
  };
  const ViewScores scores = score_field(right, views).train;
  EXPECT_EQ(scores.ssim, 1);
  EXPECT_EQ(scores.flip, 0);
}

SeedlingsJob tiny_job(const std::string& method, std::vector<int> at) {
  SeedlingsJob job;
  job.sample.views = 6;
  job.sample.width_px = 80;
  job.sample.height_px = 60;
  job.sample.pixel_samples = 4;
  job.set = {"6 views", 6, false};
  job.plan = {method, std::move(at), 1500, 4096};
  job.noise_views = 1;
  return job;
}

double value_of(const ScoreFile& file, const std::string& case_end, const std::string& metric) {
  const auto row = std::find_if(file.scores.begin(), file.scores.end(), [&](const ScoreRow& r) {
    return r.metric == metric && r.case_name.ends_with(case_end);
  });
  return row == file.scores.end() ? std::nan("") : row->value;
}

TEST(SeedlingsJobs, ATinyJobOfEachMethodLearnsItsPhotographs) {
  LastCaptures captures;
  for (const auto& [method, at] :
       {std::pair{kReference, std::vector{20, 150}}, std::pair{kOurs, std::vector{20, 150}},
        std::pair{kNgp, std::vector{5, 40}}}) {
    const ScoreFile file = run_seedlings_job(tiny_job(method, at), 2, captures);
    const auto after = [&](int steps, const std::string& metric) {
      return value_of(file, ", " + std::to_string(steps) + " steps", metric);
    };
    for (const char* set : {"train", "held_out"}) {
      EXPECT_GT(after(at[1], std::string(set) + ".psnr"), 10) << method;
      EXPECT_LT(after(at[1], std::string(set) + ".psnr"), 60) << method;
      EXPECT_LE(after(at[1], std::string(set) + ".ssim"), 1) << method;
      EXPECT_GT(after(at[1], std::string(set) + ".flip"), 0) << method;
      EXPECT_GT(after(at[1], std::string(set) + ".psnr_exposed"),
                after(at[1], std::string(set) + ".psnr") - 1e-3)
          << method;
    }
    EXPECT_GT(after(at[1], "train.psnr"), after(at[0], "train.psnr")) << method;
    if (method == kReference) {
      const double covered = value_of(file, "80x60", "coverage.seen_by_3");
      EXPECT_GT(covered, 0);
      EXPECT_LT(covered, value_of(file, "80x60", "coverage.seen_by_1"));
      EXPECT_LE(value_of(file, "80x60", "coverage.seen_by_1"), 1);
    }
    for (const ScoreRow& row : file.scores) EXPECT_EQ(row.status, ScoreStatus::ok) << row.metric;
  }
}

// Ours shows a view trained on as its own exposure was: no factor makes that image better, while
// the photographs' exposures differ.
TEST(SeedlingsJobs, OursKnowsTheExposuresOfWhatItIsTrainedOn) {
  LastCaptures captures;
  SeedlingsJob job = tiny_job(kOurs, {150});
  job.sample.width_px = 240;
  job.sample.height_px = 180;
  job.sample.views = job.set.views = 24;
  job.set.name = "24 views";
  const SampleCapture& whole = captures.of(job.sample, SamplePlan::whole_tray, 0, 2);
  std::vector<const SampleView*> train, held_out;
  for (const SampleView& view : whole.views)
    (is_held_out(view.photograph.frame) ? held_out : train).push_back(&view);
  const TrainedField field =
      train_field(job.plan, field_views(train, held_out),
                  {sample_start(job.sample, 1500, Rng(1)), sample_volume(job.sample),
                   unswept_start(job.sample, 1500, Rng(1))},
                  2);
  ASSERT_EQ(field.status, "ok");
  ASSERT_EQ(field.exposures.status, ExposureStatus::ok);
  double squares = 0;
  for (std::size_t v = 0; v < train.size(); ++v)
    squares += field.exposures.gain_of(v) * field.exposures.gain_of(v);
  EXPECT_GT(squares / static_cast<double>(train.size()), 0.05 * 0.05);
  EXPECT_LT(field.exposures.vignetting.log_at(1),
            -0.1);  // the phone's corners have 0.75 of the light
  EXPECT_GT(field.exposures.vignetting.log_at(1), -0.6);
  const ViewScores& scores = field.scores.back().train;
  EXPECT_NEAR(scores.psnr_exposed_db, scores.psnr_db, 0.3);
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

// A job that dies after its training, before its result is written: the next process trains no
// more, and says the same seconds and scores.
TEST(SeedlingsJobs, WhatWasTrainedBeforeIsNotTrainedAgain) {
  const fs::path folder = fs::path(testing::TempDir()) / "seedlings_job_unfinished";
  LastCaptures captures;
  for (const char* method : {kReference, kOurs}) {
    fs::remove_all(folder);
    const SeedlingsJob job = tiny_job(method, {20, 60});
    const ScoreFile alone = run_seedlings_job(job, 2, captures);
    const ScoreFile first = run_seedlings_job(job, 2, captures, {}, folder);
    const ScoreFile again = run_seedlings_job(job, 2, captures, {}, folder);
    ASSERT_EQ(first.scores.size(), alone.scores.size()) << method;
    ASSERT_EQ(first.scores.size(), again.scores.size()) << method;
    for (std::size_t i = 0; i < first.scores.size(); ++i) {
      const ScoreRow& row = first.scores[i];
      if (row.metric.starts_with("seconds.photographs")) continue;
      EXPECT_EQ(row.metric, again.scores[i].metric);
      EXPECT_TRUE(same(row.value, again.scores[i].value)) << row.metric;
      EXPECT_TRUE(same(row.wall_s, again.scores[i].wall_s)) << row.metric;
      if (!row.metric.starts_with("seconds")) {
        EXPECT_TRUE(same(row.value, alone.scores[i].value)) << row.metric;
      }
    }
  }
  fs::remove_all(folder);
}

TEST(SeedlingsJobs, ShownJobsKeepPictures) {
  const fs::path folder = fs::path(testing::TempDir()) / "seedlings_job_pictures";
  fs::remove_all(folder);
  LastCaptures captures;
  SeedlingsJob job = tiny_job(kReference, {10});
  job.shown = true;
  job.grid.name = "D1_0_6_reference_80px";
  run_seedlings_job(job, 2, captures, folder);
  const std::vector<ReportScene> scenes = read_report_scenes(folder);
  ASSERT_EQ(scenes.size(), 1u);
  EXPECT_EQ(scenes[0].name, "D1_0_6_reference_80px");
  EXPECT_EQ(scenes[0].pictures.size(), 3u);
  fs::remove_all(folder);
}

TEST(SeedlingsJobs, PicturesStandSideBySide) {
  const auto grey = [](float value) {
    return FidelityPlanes{Image<float>(3, 2, value), Image<float>(3, 2, value),
                          Image<float>(3, 2, value)};
  };
  const Image<Rgb8> both = side_by_side(grey(0), grey(2));  // beyond white is white
  EXPECT_EQ(both.width(), 10);
  EXPECT_EQ(both.height(), 2);
  EXPECT_EQ(both(0, 0), (Rgb8{0, 0, 0}));
  EXPECT_EQ(both(9, 1), (Rgb8{255, 255, 255}));
}

TEST(SeedlingsSuite, PooledTablesHaveThePublishedNumbersAndWhatFailed) {
  ShardResult failed;
  failed.name = "D1_0_30_ngp_400px.json";
  failed.error = "no memory";
  const ScoreFile file = pool_seedlings_suite({failed}, {});
  const auto count = [&](auto accept) {
    return std::count_if(file.scores.begin(), file.scores.end(), accept);
  };
  EXPECT_EQ(count([](const ScoreRow& r) { return r.status == ScoreStatus::error; }), 1);
  EXPECT_EQ(count([](const ScoreRow& r) { return r.case_name.starts_with("sample S"); }), 108);
  EXPECT_EQ(count([](const ScoreRow& r) { return r.case_name.starts_with("mean, "); }), 9);
}

TEST(SeedlingsSuite, OursIsHeldToTheReferenceAndToWhatItDidNotSee) {
  ScoreFile file;
  const auto add = [&](const char* method, int steps, const char* metric, double value,
                       double cpu_s) {
    ScoreRow row;
    row.suite = "seedlings";
    row.scene = "D1";
    row.case_name = "sample 0, 30 views, 400x300, " + std::to_string(steps) + " steps";
    settings_of_schema_1(row);
    row.method = method;
    row.metric = metric;
    row.value = value;
    row.wall_s = row.cpu_s = cpu_s;
    file.scores.push_back(row);
  };
  add(kReference, 7000, "train.psnr", 37, 370);
  for (const char* metric : {"train.psnr", "train.psnr_exposed"}) {
    add(kOurs, 1000, metric, 31.6, 30);
    add(kOurs, 5000, metric, 43, 310);
  }
  add(kOurs, 1000, "held_out.psnr_exposed", 30.2, 30);
  add(kOurs, 5000, "held_out.psnr_exposed", 27.8, 310);
  ShardResult result;
  result.name = "D1.json";
  result.text = to_json(file);
  std::map<std::string, ScoreStatus> found;
  ScoreFile pooled = pool_seedlings_suite({result}, {});
  const std::size_t count = pooled.scores.size();
  hold_seedlings_suite({.quick = true}, pooled);
  EXPECT_EQ(pooled.scores.size(), count);  // a quick run has no limits
  hold_seedlings_suite({}, pooled);
  for (const ScoreRow& row : pooled.scores) {
    if (row.status == ScoreStatus::pass || row.status == ScoreStatus::fail)
      found[row.metric + std::to_string(row.steps)] = row.status;
  }
  EXPECT_EQ(found, (std::map<std::string, ScoreStatus>{
                       {"train.psnr_gain_at_equal_cpu_seconds7000", ScoreStatus::pass},
                       {"psnr_exposed.train_less_held_out1000", ScoreStatus::pass},
                       {"psnr_exposed.train_less_held_out5000", ScoreStatus::fail}}));
}

TEST(SeedlingsSuite, EachJobIsAShardAndItsKeyHasTheSeed) {
  const auto first = seedlings_suite_jobs({.seed = 1, .quick = true});
  const auto second = seedlings_suite_jobs({.seed = 2, .quick = true});
  EXPECT_EQ(first.size(), seedlings_jobs({.quick = true}).size());
  EXPECT_EQ(first[0].name, second[0].name);
  EXPECT_NE(first[0].key, second[0].key);
}

}  // namespace
}  // namespace cousin
