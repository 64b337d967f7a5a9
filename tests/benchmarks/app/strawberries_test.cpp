// Where strawberries hang, as a user asks for it: in one command, and in three from files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "benchmarks/score/scores.h"
#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Two coarse photographs of a stretch of three fruits before a D457.
Words small_bed() {
  return {"--frames", "2",
          "--seed",   "2",
          "--set",    "render.pixel_samples=1",
          "--set",    "depth_by=model",
          "--set",    "plants=1",
          "--set",    "fruits_min=3",
          "--set",    "fruits_max=3",
          "--set",    "fruit_grid=16",
          "--set",    "bed.row.plants=1",
          "--set",    "bed.row.variants=1",
          "--set",    "bed.path.beds=0",
          "--set",    "bed.film.cell_m=0.05"};
}

double value_of(const std::vector<ScoreRow>& rows, const std::string& metric,
                const std::string& scene) {
  for (const ScoreRow& row : rows) {
    if (row.metric == metric && row.scene == scene) return row.value;
  }
  return ScoreRow::kNone;
}

TEST(AppStrawberries, OneCommandMeasuresThemAndFilesGiveTheSame) {
  const Program program;
  const Outcome run =
      program.run(Words{"run", "strawberries", "--out", "berries", "--attribution"} + small_bed());
  ASSERT_EQ(run.code, 0) << run.err;
  const ScoreFile file = scores_from_json(read_file(program.path("berries/scores.json")), "scores");
  const double found = value_of(file.scores, "boxes.found", "000000");
  EXPECT_GE(found, 3);
  EXPECT_EQ(value_of(file.scores, "boxes.missed", "000000"), 0);
  EXPECT_GE(value_of(file.scores, "boxes.measured", "000000"), 0.5 * found);
  EXPECT_LT(value_of(file.scores, "point.error_3d", "000000"), 0.02);
  EXPECT_FALSE(file.specimens.empty());
  const std::string page = read_file(program.path("berries/report.html"));
  for (const char* words : {"Boxes in view", "point_z", "Where the error of point_z comes from"})
    EXPECT_NE(page.find(words), std::string::npos) << words;

  // The same from files, with the boxes of the run as somebody's.
  ASSERT_EQ(program
                .run(Words{"render", "strawberries", "--out", "data", "--truth", "depth,instance"} +
                     small_bed())
                .code,
            0);
  const Words perceive = {"perceive", "data", "--out", "est"};
  const Outcome without = program.run(perceive);
  EXPECT_EQ(without.code, 2);
  EXPECT_THAT(without.err, HasSubstr("give --stage boxes=dir:FOLDER"));
  ASSERT_EQ(program.run(perceive + Words{"--stage", "boxes=dir:berries/estimate"}).code, 0);
  for (const char* seam : {"traits.json", "boxes.json"}) {
    EXPECT_EQ(read_file(program.path("est/000000") / seam),
              read_file(program.path("berries/estimate/000000") / seam))
        << seam;
  }
  ASSERT_EQ(program.run({"score", "data", "est"}).code, 0);
  const ScoreFile scored = scores_from_json(read_file(program.path("est/scores.json")), "scores");
  EXPECT_EQ(value_of(scored.scores, "boxes.found", "000000"), found);
  EXPECT_DOUBLE_EQ(value_of(scored.scores, "point.error_3d", "000000"),
                   value_of(file.scores, "point.error_3d", "000000"));
  // Without the images that say what is under a box there is nothing to score.
  fs::remove_all(program.path("data/000000/truth/depth"));
  fs::remove(program.path("data/manifest.json"));
  const Outcome blind = program.run({"score", "data", "est", "--out", "blind"});
  EXPECT_EQ(blind.code, 3);
  EXPECT_THAT(blind.err, HasSubstr("--truth depth,instance"));
}

TEST(AppStrawberries, ThePapersRuleAndOneDepthlessRigAreChosenByName) {
  const Program program;
  const Outcome plan = program.run({"run", "strawberries", "--method", "paper", "--plan"});
  EXPECT_EQ(plan.code, 0);
  EXPECT_THAT(plan.out, AllOf(HasSubstr("true ones: the pipeline has no stage of its own for it"),
                              HasSubstr("truth: depth")));
  const Outcome keys = program.run({"run", "strawberries", "--keys"});
  EXPECT_THAT(keys.out, AllOf(HasSubstr("pipeline.point.window_share"), HasSubstr("fruits_max")));
  const Outcome blind = program.run({"run", "strawberries", "--set", "rig=dslr_apsc_24mp"});
  EXPECT_EQ(blind.code, 2);
  EXPECT_THAT(blind.err, HasSubstr("method ours reads color,depth"));
  const Outcome other = program.run({"run", "strawberries", "--method", "moon"});
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, AllOf(HasSubstr("--method moon"), HasSubstr("ours, paper")));
}

}  // namespace
}  // namespace cousin
