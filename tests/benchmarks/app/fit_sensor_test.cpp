// fit-sensor as a user calls it: a folder of recordings to a preset, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "benchmarks/tools/fit_sensor/hidden_device.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/output_folder.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// A D457 in its smallest mode, at the least that is asked for.
struct Desk {
  HiddenDevice device = draw_hidden_device("d457", Rng(1));
  RecordingPlan plan;
  Desk() {
    device.config.columns = 424;
    plan.distances_m = {0.35, 0.5, 0.75, 1.1};
    plan.frames = 5;
    plan.flats = 3;
  }
  void write(const fs::path& folder) const {
    write_recordings(folder, record(device, plan, Rng(2)), device, plan);
  }
};

TEST(AppFitSensor, RecordingsBecomeAPresetThatTheProgramReads) {
  const Program program;
  const Desk desk;
  desk.write(program.path("desk"));
  const Outcome fit = program.run({"fit-sensor", "desk", "--rig", "d457", "--out", "fit"});
  ASSERT_EQ(fit.code, 0) << fit.err << fit.out;
  EXPECT_THAT(fit.out, AllOf(HasSubstr("exponent of sigma_Z"), HasSubstr("gain K"),
                             HasSubstr("wall_0.35m"), HasSubstr("verdict: solved")));
  const std::string preset = read_file(program.path("fit/preset.toml"));
  EXPECT_THAT(preset, AllOf(HasSubstr("columns = 424"), HasSubstr("# fitted: to 4 walls at 0.35"),
                            HasSubstr("in desk")));
  EXPECT_THAT(read_file(program.path("fit/report.html")),
              AllOf(HasSubstr("sigma_Z (mm)"), HasSubstr("Photon transfer"), HasSubstr("</html>")));

  // The file stands where a preset's name does, and the numbers come out again.
  const Outcome again =
      program.run({"fit-sensor", "desk", "--rig", "fit/preset.toml", "--out", "fit2", "--json"});
  ASSERT_EQ(again.code, 0) << again.err;
  const auto json = nlohmann::json::parse(again.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded());
  EXPECT_EQ(json["header"]["more"]["verdict"], "solved");
  EXPECT_TRUE(fs::exists(program.path("fit2/preset.toml")));
}

TEST(AppFitSensor, AWrongModelLeavesNoPresetAndExitCodeOne) {
  const Program program;
  Desk desk;
  desk.plan.noise_exponent = 1;
  desk.plan.flats = 0;
  desk.write(program.path("desk"));
  // Somebody's preset stays; that of an earlier fit goes with it.
  write_file(program.path("mine/preset.toml"), "mine\n");
  const Outcome refused = program.run({"fit-sensor", "desk", "--rig", "d457", "--out", "mine"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("mine/preset.toml is in the way"));
  EXPECT_EQ(read_file(program.path("mine/preset.toml")), "mine\n");
  {
    const OutputFolder folder(program.path("fit"),
                              {.verb = "fit-sensor", .version = "1", .config = {}, .names = {}});
    write_file(program.path("fit/preset.toml"), "of an earlier fit\n");
  }
  const Outcome fit = program.run({"fit-sensor", "desk", "--rig", "d457", "--out", "fit"});
  EXPECT_EQ(fit.code, 1) << fit.err;
  EXPECT_THAT(fit.out, AllOf(HasSubstr("verdict: rejected"), HasSubstr("stereo grows as Z^2")));
  EXPECT_FALSE(fs::exists(program.path("fit/preset.toml")));
  EXPECT_THAT(read_file(program.path("fit/report.html")), HasSubstr("Rejected: "));
}

TEST(AppFitSensor, WrongWordsAndFoldersAreNamed) {
  const Program program;
  const Outcome no_rig = program.run({"fit-sensor", "desk"});
  EXPECT_EQ(no_rig.code, 2);
  EXPECT_THAT(no_rig.err, HasSubstr("--rig"));
  const Outcome unknown = program.run({"fit-sensor", "desk", "--rig", "d999"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("d999"), HasSubstr("d457")));
  const Outcome missing = program.run({"fit-sensor", "desk", "--rig", "d457"});
  EXPECT_EQ(missing.code, 3);
  EXPECT_THAT(missing.err, HasSubstr("desk: no such folder"));
  write_file(program.path("desk/wall_near/0.png"), "x");
  const Outcome nameless = program.run({"fit-sensor", "desk", "--rig", "d457"});
  EXPECT_EQ(nameless.code, 3);
  EXPECT_THAT(nameless.err, HasSubstr("wall_near: the folder's name says no distance"));
}

}  // namespace
}  // namespace cousin
