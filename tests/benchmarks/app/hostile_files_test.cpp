// Files that somebody made to get into our page, our terminal or our other folders.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "benchmarks/score/scores.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/types/utf8.h"
#include "tests/benchmarks/app/program.h"
#include "tests/benchmarks/report/browser.h"
#include "tests/benchmarks/report/hostile_text.h"

namespace cousin {
namespace {
namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Every text of a result is hostile, in rows of the kinds that a page has a place for.
ScoreFile hostile_scores() {
  std::string bad = hostile_text();
  bad.erase(bad.find('\xff'), 1);  // JSON is UTF-8
  ScoreFile file;
  file.header = {bad,
                 bad,
                 bad,
                 bad,
                 {{"title", bad}, {"summary", bad}, {"command", bad}, {"note", bad}, {bad, bad}}};
  const auto add = [&](const std::string& suite, const std::string& scene,
                       const std::string& case_name, const std::string& method,
                       const std::string& metric, ScoreStatus status) {
    ScoreRow row;
    row.suite = suite;
    row.scene = scene;
    row.case_name = case_name;
    row.method = method;
    row.metric = metric;
    row.unit = bad;
    row.value = row.wall_s = row.cpu_s = 1;
    row.n = 3;
    row.ci_low = 0.5;
    row.ci_high = 2;
    row.status = status;
    file.scores.push_back(row);
  };
  add(bad, bad, bad, bad, bad, ScoreStatus::ok);
  add("seeds", "pooled", bad, bad, "length.rmse", ScoreStatus::fail);
  add("seeds", "pooled", "maize", "ours", "length.rmse", ScoreStatus::fail);
  for (const char* step : {"truth up to <hostile>a", "truth up to b"})
    add("seeds", bad, step, "ours", "length.rmse", ScoreStatus::ok);
  for (const char* setting : {"x run 0 <hostile>1", "x run 0 2", "x run 0 3"})
    add("seeds", bad, setting, bad, "curve.length.rmse", ScoreStatus::ok);
  add("run", "000000", bad, bad, "seconds." + bad, ScoreStatus::ok);
  for (int i = 0; i < 4; ++i) {
    SpecimenRow row;
    row.dataset = row.scene = row.cultivar = row.run = row.method = row.trait = row.unit = bad;
    row.instance = i;
    row.truth = 1 + i;
    row.measured = 1.1 + i;
    row.sigma = 0.1;
    file.specimens.push_back(row);
  }
  return file;
}

class AppHostileFiles : public testing::Test {
 protected:
  void write_result() const {
    write_file(program_.path("r/scores.json"), to_json(hostile_scores()));
    write_file(program_.path("r/config.toml"), hostile_text());
    write_file(program_.path("r/plan.txt"), hostile_text());
    write_file(program_.path("r/report/s/scene.json"),
               nlohmann::json{{"name", "s"}, {"pictures", nlohmann::json::array()}}.dump());
  }
  /// Three grey views without a board in data/000000.
  void write_views() const {
    Capture capture;
    capture.pipeline = "seeds";
    capture.rig.resize(1);
    capture.rig[0].camera = Camera{LensModel::opencv5, 64, 48, 60, 60, 32, 24, {}};
    for (int i = 0; i < 3; ++i) {
      Frame frame;
      frame.id = i;
      frame.sensors.resize(1);
      frame.sensors[0].reported = capture.rig[0].camera;
      frame.sensors[0].color = Image<Rgb8>(64, 48, {90, 90, 90});
      capture.frames.push_back(frame);
    }
    write_capture(program_.path("data/000000"), capture);
  }
  Program program_;
};

TEST_F(AppHostileFiles, AResultsTextsAreNoMarkupOnItsPage) {
  write_result();
  const Outcome outcome = program_.run({"report", "r"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string page = read_file(program_.path("r/report.html"));
  EXPECT_EQ(count(page, "<hostile"), 0);
  EXPECT_EQ(count(page, "<img src=x"), 0);
  EXPECT_EQ(count(page, "href=\"javascript:"), 0);
  EXPECT_GT(count(page, "&lt;hostile&gt;"), 10);
  EXPECT_TRUE(is_utf8(page));
}

TEST_F(AppHostileFiles, AResultRunsNoScriptInItsPage) {
  if (!has_chromium())
    GTEST_SKIP() << "Chromium is not installed (Debian package chromium): the page is not opened";
  write_result();
  ASSERT_EQ(program_.run({"report", "r"}).code, 0);
  const std::string dom = shown_document(read_file(program_.path("r/report.html")), kWithoutWebgl);
  EXPECT_THAT(root_tag(dom), HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(dom), Not(HasSubstr("data-hostile")));
}

TEST_F(AppHostileFiles, AReportTakesNothingFromElsewhere) {
  write_result();
  write_file(program_.path("secret.txt"), "not theirs");
  fs::remove(program_.path("r/plan.txt"));
  fs::create_symlink(program_.path("secret.txt"), program_.path("r/plan.txt"));
  const Outcome outcome = program_.run({"report", "r"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("r/plan.txt"), HasSubstr("secret.txt")));
  EXPECT_FALSE(fs::exists(program_.path("r/report.html")));
}

TEST_F(AppHostileFiles, PerceiveScoreAndVerifyReadNothingFromElsewhere) {
  write_views();
  const fs::path picture = program_.path("data/000000/rgb/000001.png");
  fs::rename(picture, program_.path("elsewhere.png"));
  fs::create_symlink(program_.path("elsewhere.png"), picture);
  for (const Words& words : {Words{"perceive", "data", "--out", "est"}, Words{"verify", "data"},
                             Words{"score", "data", "est"}}) {
    const Outcome outcome = program_.run(words);
    EXPECT_EQ(outcome.code, 3) << words.front();
    EXPECT_THAT(outcome.err + outcome.out,
                AllOf(HasSubstr("rgb/000001.png"), HasSubstr("elsewhere.png")))
        << words.front();
  }
  EXPECT_FALSE(fs::exists(program_.path("est")));
}

TEST_F(AppHostileFiles, NamesReachTheTerminalAsText) {
  const std::string name = "a\x1b[2J\ncousin: all is well";
  fs::create_directories(program_.path(name));
  const Outcome outcome = program_.run({"perceive", name});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("a\\x1b[2J\\x0acousin"), Not(HasSubstr("\x1b"))));
  EXPECT_EQ(count(outcome.err, "\ncousin"), 0);
}

TEST_F(AppHostileFiles, APathThatIsNoUtf8IsPrintedAsJson) {
  write_result();
  const std::string name = "Gr\xfcn";
  fs::rename(program_.path("r"), program_.path(name));
  const Outcome outcome = program_.run({"report", name, "--json"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_FALSE(nlohmann::json::parse(outcome.out, nullptr, false).is_discarded()) << outcome.out;
  const Outcome verified = program_.run({"verify", name, "--json"});
  EXPECT_EQ(verified.code, 3) << verified.err;
  EXPECT_FALSE(nlohmann::json::parse(verified.out, nullptr, false).is_discarded()) << verified.out;
}

TEST_F(AppHostileFiles, AStageProgramEndsAtItsTimeLimit) {
  write_views();
  write_file(program_.path("slow"), "#!/bin/sh\nsleep 1000\n");
  fs::permissions(program_.path("slow"), fs::perms::owner_all);
  const Outcome outcome = program_.run({"perceive", "data", "--out", "est", "--stage",
                                        "corners=exec:./slow", "--stage-time-limit", "0.5"});
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("time limit of 0.5 s"), HasSubstr("--stage-time-limit"),
                                 HasSubstr("corners")));
}

}  // namespace
}  // namespace cousin
