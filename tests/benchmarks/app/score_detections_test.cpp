// score DATASET FILE: somebody's boxes become numbers, a page and an exit code.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/manifest.h"
#include "tests/benchmarks/app/program.h"
#include "tests/sim/dataset/small_dataset.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Two pictures, each of an apple at (8 + frame, 5), 6 x 5 pixels, and a zea (small_dataset.h).
class AppScoreDetections : public testing::Test {
 protected:
  AppScoreDetections() { write_small_dataset(program_.path("data"), {}); }
  Outcome score(const std::string& results, const Words& more = {}) const {
    write_file(program_.path("found.json"), results);
    return program_.run(Words{"score", "data", "found.json"} + more);
  }
  Program program_;
};

constexpr const char* kApples =
    R"([{"image_id": "000000_000000", "category_id": 1, "bbox": [8, 5, 6, 5], "score": 0.9},
        {"image_id": 1, "category_id": 1, "bbox": [9, 5, 6, 5], "score": 0.8}])";

TEST_F(AppScoreDetections, BoxesBecomeNumbersAndAPage) {
  const Outcome outcome = score(kApples);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("class apple"));
  EXPECT_THAT(outcome.err, HasSubstr("2 of 4 objects in 2 pictures were found"));
  const std::string page = read_file(program_.path("out/found_scores/report.html"));
  EXPECT_THAT(page, AllOf(HasSubstr("Every object that was missed"), HasSubstr("000000_000001")));
  const std::string rows = read_file(program_.path("out/found_scores/scores.csv"));
  EXPECT_THAT(rows, AllOf(HasSubstr("score,data,class apple,found.json,AP50.of_class,1,"),
                          HasSubstr("score,data,all classes,found.json,recall,0.5,")));
  // The same again replaces it; anything else there is in the way.
  EXPECT_EQ(score(kApples).code, 0);
  write_file(program_.path("mine/report.html"), "mine");
  EXPECT_EQ(score(kApples, {"--out", "mine"}).code, 2);
  EXPECT_EQ(read_file(program_.path("mine/report.html")), "mine");
}

TEST_F(AppScoreDetections, ACategoryThatTheDatasetLacksIsRefusedAndNoneIsOfEstimates) {
  const Outcome none = score(kApples, {"--category", "variety"});
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, AllOf(HasSubstr("no label \"variety\""), HasSubstr("its labels: none")));
  const Outcome folder = program_.run({"score", "data", "data", "--category", "variety"});
  EXPECT_EQ(folder.code, 2);
  EXPECT_THAT(folder.err, HasSubstr("--category"));
}

TEST_F(AppScoreDetections, AGateSetsTheExitCode) {
  EXPECT_EQ(score(kApples, {"--gate", "recall>=0.9"}).code, 1);
  EXPECT_EQ(score(kApples, {"--gate", "precision>=0.9"}).code, 0);
}

TEST_F(AppScoreDetections, TruthThatWasChangedSinceItWasRenderedIsRefused) {
  const fs::path truth = program_.path("data/000000/truth/scene.json");
  write_manifest(program_.path("data"), {.config_hash = sha256_hex("a")});
  EXPECT_EQ(score(kApples).code, 0);
  write_file(truth, read_file(truth) + " ");
  const Outcome changed = score(kApples);
  EXPECT_EQ(changed.code, 3);
  EXPECT_THAT(changed.err, HasSubstr("scene.json: its SHA-256 is not the one in manifest.json"));
}

TEST_F(AppScoreDetections, MistakesAreNamed) {
  const Outcome unknown =
      score(R"([{"image_id": 1, "category_id": 0, "bbox": [8, 5, 6, 5], "score": 1}])");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("class 0"), HasSubstr("--class-map")));
  const Outcome named =
      score(R"([{"image_id": 1, "category_id": 0, "bbox": [9, 5, 6, 5], "score": 1}])",
            {"--class-map", "0=apple"});
  EXPECT_EQ(named.code, 0) << named.err;
  const Outcome foreign =
      score(R"([{"image_id": 99, "category_id": 1, "bbox": [8, 5, 6, 5], "score": 1}])");
  EXPECT_EQ(foreign.code, 3);
  EXPECT_THAT(foreign.err, AllOf(HasSubstr("found.json: /0"), HasSubstr("picture \"99\"")));
  fs::create_directories(program_.path("est/000000"));
  const Outcome folder = program_.run({"score", "data", "est", "--class-map", "0=apple"});
  EXPECT_EQ(folder.code, 2);
  EXPECT_THAT(folder.err, HasSubstr("--class-map"));
  EXPECT_EQ(score(kApples, {"--confidence", "nan"}).code, 2);
  const Outcome unread = program_.run({"run", "seeds", "--plan", "--stage", "boxes=dir:data"});
  EXPECT_EQ(unread.code, 2);
  EXPECT_THAT(unread.err, HasSubstr("pipeline seeds has corners"));
  fs::remove_all(program_.path("data/000000/truth/instance"));
  const Outcome poor = score(kApples);
  EXPECT_EQ(poor.code, 3);
  EXPECT_THAT(poor.err, HasSubstr("render with --truth visibility,instance"));
}

}  // namespace
}  // namespace cousin
