#include "benchmarks/score/scores.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using testing::HasSubstr;

ScoreFile example() {
  ScoreFile file;
  file.header = {"0.1.0", "abc", "def", "2 cores", {{"compiler", "gcc 12"}}};
  ScoreRow row;
  row.suite = "seeds";
  row.scene = "maize, \"dented\"";
  row.case_name = "60 views";
  row.method = "ours\nline two";
  row.metric = "length.rmse";
  row.value = 0.1 + 0.2;
  row.unit = "m";
  row.n = 50;
  row.ci_low = 5e-324;
  row.ci_high = 1.7976931348623157e308;
  row.seed = 18446744073709551615U;
  row = limited(row, at_most(0.2));
  row.run = 4;
  row.steps = 7000;
  row.poses = "sfm";
  file.scores = {row, ScoreRow{}};
  SpecimenRow specimen;
  specimen.dataset = "d";
  specimen.frame = -1;
  specimen.instance = 7;
  specimen.trait = "length";
  specimen.truth = 0.0123;
  specimen.measured = std::nan("");
  specimen.status = ScoreStatus::not_solved;
  file.specimens = {specimen};
  return file;
}

std::string error_of(const auto& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST(ScoresCsv, HasTheColumnsOfTheDesign) {
  EXPECT_EQ(to_csv(std::span<const ScoreRow>{}),
            "suite,scene,case,method,metric,value,unit,n,ci_low,ci_high,wall_s,cpu_s,peak_rss_mb,"
            "peak_above_start_mb,seed,status,limit_low,limit_high,limit_n,run,views,width_px,"
            "height_px,steps,held_out_every,view_set,poses,light\n");
  EXPECT_EQ(
      to_csv(std::span<const SpecimenRow>{}),
      "dataset,scene,frame,instance,cultivar,run,method,trait,unit,true,measured,sigma,status\n");
}

TEST(ScoresCsv, WhatIsWrittenReadsBackEqual) {
  const ScoreFile file = example();
  const std::string scores = to_csv(file.scores);
  EXPECT_EQ(to_csv(scores_from_csv(scores, "scores.csv")), scores);
  const std::vector<ScoreRow> back = scores_from_csv(scores, "scores.csv");
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0].scene, file.scores[0].scene);
  EXPECT_EQ(back[0].method, file.scores[0].method);
  EXPECT_EQ(back[0].value, 0.1 + 0.2);
  EXPECT_EQ(back[0].ci_low, 5e-324);
  EXPECT_EQ(back[0].seed, 18446744073709551615U);
  EXPECT_EQ(back[0].status, ScoreStatus::fail);
  EXPECT_EQ(back[0].limit_high, 0.2);
  EXPECT_TRUE(std::isnan(back[0].limit_low));
  EXPECT_EQ(back[0].steps, 7000);
  EXPECT_EQ(back[0].poses, "sfm");
  EXPECT_TRUE(std::isnan(back[0].wall_s));
  const std::string specimens = to_csv(file.specimens);
  EXPECT_EQ(to_csv(specimens_from_csv(specimens, "specimens.csv")), specimens);
}

TEST(ScoresCsv, RejectsWhatIsNotExact) {
  const std::string good = to_csv(example().specimens);
  const auto read = [](const std::string& text) {
    return error_of([&] { specimens_from_csv(text, "specimens.csv"); });
  };
  EXPECT_EQ(read(good), "no error");
  EXPECT_THAT(read(""), HasSubstr("specimens.csv:1: column 1 must be \"dataset\""));
  EXPECT_THAT(read("dataset,scene\n"), HasSubstr("column 3 must be \"frame\""));
  const std::string header = good.substr(0, good.find('\n'));
  EXPECT_THAT(read(header + ",more\n"), HasSubstr("\"more\" is unknown"));
  EXPECT_THAT(read(header + "\nd,s,0\n"), HasSubstr(":2: 3 cells; expected 13"));
  EXPECT_THAT(read(header + "\nd,s,0,1,c,r,m,t,u,1x,2,3,ok\n"),
              HasSubstr("column \"true\": \"1x\" is not a number"));
  EXPECT_THAT(read(header + "\nd,s,0,1,c,r,m,t,u,nan,2,3,ok\n"), HasSubstr("leave the cell empty"));
  EXPECT_THAT(read(header + "\nd,s,0.5,1,c,r,m,t,u,1,2,3,ok\n"), HasSubstr("column \"frame\""));
  EXPECT_THAT(read(header + "\nd,s,99999999999999999999,1,c,r,m,t,u,1,2,3,ok\n"),
              HasSubstr("column \"frame\""));
  EXPECT_THAT(read(header + "\nd,s,0,1,c,r,m,t,u,1,2,3,fine\n"),
              HasSubstr("\"fine\" is not one of ok, pass"));
  EXPECT_THAT(read(header + "\n\"d,s,0\n"), HasSubstr("a quote is not closed"));
  EXPECT_THAT(read(header + "\nd\"d,s,0,1,c,r,m,t,u,1,2,3,ok\n"),
              HasSubstr("a quote inside a cell"));
  EXPECT_THAT(read(header + "\n\"d\"d,s,0,1,c,r,m,t,u,1,2,3,ok\n"), HasSubstr("expected a comma"));
  EXPECT_THAT(read(header + "\nd" + std::string(1, '\0') + ",s\n"), HasSubstr("NUL"));
  EXPECT_THAT(read(header + "\n" + std::string(100000, 'x')), HasSubstr("64 KiB"));
  EXPECT_EQ(read(header + "\r\nd,s,0,1,c,r,m,t,u,1,2,,ok\r\n"), "no error");
}

TEST(ScoresCsv, AnyDamageIsAnErrorOrATable) {
  const std::string good = to_csv(example().scores);
  Rng rng(1);
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text = good;
    for (int k = 0; k < 3; ++k) text[uniform_index(rng, text.size())] = static_cast<char>(rng());
    text.resize(uniform_index(rng, text.size() + 1));
    error_of([&] {
      scores_from_csv(text, "scores.csv");
    });  // anything but std::runtime_error ends the test
  }
}

TEST(ScoresJson, WhatIsWrittenReadsBackEqual) {
  const std::string text = to_json(example());
  const ScoreFile back = scores_from_json(text, "scores.json");
  EXPECT_EQ(to_json(back), text);
  EXPECT_EQ(back.header.more.at("compiler"), "gcc 12");
  EXPECT_EQ(back.scores[0].seed, 18446744073709551615U);
  EXPECT_TRUE(std::isnan(back.specimens[0].measured));
}

TEST(Scores, ALimitIsKeptByWhatIsThere) {
  ScoreRow row;
  row.n = 10;
  const auto status = [&](double value, const ScoreLimit& limit) {
    row.value = value;
    return limited(row, limit).status;
  };
  EXPECT_EQ(status(2, at_most(2)), ScoreStatus::pass);
  EXPECT_EQ(status(2.1, at_most(2)), ScoreStatus::fail);
  EXPECT_EQ(status(1.9, at_least(2)), ScoreStatus::fail);
  EXPECT_EQ(status(-0.1, about(0, 0.1)), ScoreStatus::pass);
  EXPECT_EQ(status(0.2, about(0, 0.1)), ScoreStatus::fail);
  EXPECT_EQ(status(ScoreRow::kNone, at_most(2)), ScoreStatus::fail);
  EXPECT_EQ(status(1, {.high = 2, .least_n = 11}), ScoreStatus::fail);
  EXPECT_FALSE(has_limit(row));
  EXPECT_TRUE(has_limit(limited(row, at_least(0))));
}

/// What the program wrote before rows had limits and settings.
constexpr const char* kSchema1Csv =
    "suite,scene,case,method,metric,value,unit,n,ci_low,ci_high,wall_s,cpu_s,peak_rss_mb,"
    "peak_above_start_mb,seed,status\n"
    "seeds_splats,zhengdan958,\"zhengdan958 run 2 60 views 1280x720, one in 8 held out, 900 "
    "steps\","
    "splats,psnr,31.5,dB,60,,,10,20,,,7,pass\n";

TEST(Scores, Schema1IsReadAndItsNamesBecomeSettings) {
  const std::vector<ScoreRow> rows = scores_from_csv(kSchema1Csv, "old.csv");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].run, 2);
  EXPECT_EQ(rows[0].views, 60);
  EXPECT_EQ(rows[0].width_px, 1280);
  EXPECT_EQ(rows[0].held_out_every, 8);
  EXPECT_EQ(rows[0].steps, 900);
  EXPECT_EQ(rows[0].status, ScoreStatus::pass);
  EXPECT_FALSE(has_limit(rows[0]));
  ScoreFile file;
  file.scores = rows;
  std::string json = to_json(file);
  json.replace(json.find("\"schema\": 2"), 11, "\"schema\": 1");
  EXPECT_THAT(error_of([&] { scores_from_json(json, "new.json"); }), HasSubstr("is unknown"));
}

TEST(ScoresJson, KeepsInfinity) {
  ScoreFile file = example();
  file.scores[0].value = INFINITY;
  file.scores[0].ci_low = -INFINITY;
  const ScoreFile back = scores_from_json(to_json(file), "scores.json");
  EXPECT_EQ(back.scores[0].value, INFINITY);
  EXPECT_EQ(back.scores[0].ci_low, -INFINITY);
  EXPECT_EQ(to_csv(scores_from_csv(to_csv(file.scores), "s")), to_csv(file.scores));
}

TEST(ScoresJson, RejectsWhatIsNotExact) {
  const std::string good = to_json(example());
  const auto read_with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return error_of([&] { scores_from_json(text, "scores.json"); });
  };
  EXPECT_THAT(read_with("\"schema\": 2", "\"schema\": 3"), HasSubstr("schema: expected 2 or 1"));
  EXPECT_THAT(read_with("\"n\": 50", "\"n\": \"50\""),
              HasSubstr("scores[0].n: expected a whole number"));
  EXPECT_THAT(read_with("\"n\": 50", "\"n\": 50.5"), HasSubstr("scores[0].n"));
  EXPECT_THAT(read_with("\"n\": 50", "\"m\": 50"), HasSubstr("\"n\" is missing"));
  EXPECT_THAT(read_with("\"n\": 50", "\"n\": 50, \"extra\": 1"), HasSubstr("\"extra\" is unknown"));
  EXPECT_THAT(read_with("\"machine\"", "\"machines\""), HasSubstr("\"machine\" is missing"));
  EXPECT_THAT(read_with("\"seed\": 18446744073709551615", "\"seed\": -1"),
              HasSubstr("scores[0].seed"));
  EXPECT_THAT(read_with("\"fail\"", "\"failed\""), HasSubstr("scores[0].status"));
  EXPECT_THAT(error_of([] { scores_from_json("", "scores.json"); }),
              HasSubstr("scores.json: not JSON"));
  EXPECT_THAT(error_of([] { scores_from_json("[]", "scores.json"); }),
              HasSubstr("\"schema\" is missing"));
  EXPECT_THAT(error_of([] { scores_from_json(std::string(100000, '['), "scores.json"); }),
              HasSubstr("not JSON"));
}

TEST(ScoreRows, CarryTheirCaseAndInterval) {
  ScoreRow row;
  row.suite = "seeds";
  row.method = "ours";
  row.seed = 3;
  TraitStatistics statistics;
  statistics.n = 12;
  statistics.bias = {0.1, 0.05, 0.2};
  const std::vector<ScoreRow> rows = score_rows(row, "length", "m", statistics);
  ASSERT_EQ(rows.size(), 9U);
  EXPECT_EQ(rows[2].metric, "length.bias");
  EXPECT_EQ(rows[2].unit, "m");
  EXPECT_EQ(rows[2].ci_low, 0.05);
  EXPECT_EQ(rows[2].n, 12);
  EXPECT_EQ(rows[2].method, "ours");
  EXPECT_EQ(rows[1].unit, "1");
}

TEST(ScoresJson, NumbersThatNoRulerGivesAreRefused) {
  const std::string good = to_json(example());
  const auto error = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return error_of([&] { scores_from_json(text, "scores.json"); });
  };
  EXPECT_EQ(error("\"value\": 0.30000000000000004", "\"value\": \"inf\""), "no error");
  EXPECT_THAT(error("\"value\": 0.30000000000000004", "\"value\": \"much\""),
              HasSubstr("scores.json: scores[0].value: expected a number or null"));
  EXPECT_THAT(error("\"value\": 0.30000000000000004", "\"value\": NaN"), HasSubstr("not JSON"));
  EXPECT_THAT(error("\"value\": 0.30000000000000004", "\"value\": 1e999"), HasSubstr("not JSON"));
  EXPECT_THAT(error("\"true\": 0.0123", "\"true\": \"-inf\""),
              HasSubstr("specimens[0].true: expected a finite number"));
  EXPECT_THAT(error("\"wall_s\": null", "\"wall_s\": \"inf\""),
              HasSubstr("scores[0].wall_s: expected a finite number"));
  EXPECT_THAT(error("\"length.rmse\"", "\"" + std::string(70'000, 'x') + "\""),
              HasSubstr("scores[0].metric: expected a text of at most 64 KiB"));
  EXPECT_THAT(error("\"length.rmse\"", "\"a\\u0000b\""), HasSubstr("NUL"));
}

TEST(TraitPairs, TakeSolvedRowsOnly) {
  std::vector<SpecimenRow> rows(3);
  for (SpecimenRow& row : rows) {
    row.trait = "length";
    row.truth = 1;
    row.measured = 2;
  }
  rows[1].status = ScoreStatus::not_solved;
  rows[2].trait = "width";
  EXPECT_EQ(trait_pairs(std::span<const SpecimenRow>(rows), "length",
                        [](const SpecimenRow&) { return true; })
                .size(),
            1U);
}

}  // namespace
}  // namespace cousin
