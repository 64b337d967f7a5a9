// Parts of the program that were not built: the verb says which, and how to build it.
#include "benchmarks/app/parts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "sim/dataset/atomic_file.h"
#include "sim/process/program_run.h"
#include "tests/benchmarks/app/program.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// The program in a folder without any of its parts.
class Alone {
 public:
  Alone() { fs::copy_file(COUSIN_PROGRAM, folder_.path() / "cousin"); }
  void add(const Part& part) const {
    fs::create_symlink(fs::path(COUSIN_PROGRAM).parent_path() / part.file,
                       folder_.path() / part.file);
  }
  /// What `cousin words...` says; its exit code goes to `code`.
  std::string say(const std::vector<std::string>& words, int& code) const {
    ProgramCall call{.words = {(folder_.path() / "cousin").string()},
                     .log = folder_.path() / "log"};
    call.words.insert(call.words.end(), words.begin(), words.end());
    code = run_program(call).code;
    return read_file(call.log);
  }

 private:
  TemporaryFolder folder_;
};

TEST(AppParts, AVerbWhosePartIsAbsentNamesTheCommandThatBuildsIt) {
  const Alone program;
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"bench", "program"}, "bench"},
      {{"calibrate", "photos", "--board", "chessboard:6x4:0.030"}, "calibrate"},
      {{"import", "photos", "--format", "folder"}, "scenes"},
      {{"export", "dataset", "--format", "coco"}, "scenes"},
      {{"fit-sensor", "desk", "--rig", "d457"}, "fit-sensor"}};
  for (const auto& [words, part] : cases) {
    int code = -1;
    const std::string text = program.say(words, code);
    EXPECT_EQ(code, 2) << text;
    EXPECT_THAT(text, AllOf(HasSubstr("\"" + words[0] + "\" is not built in"),
                            HasSubstr("scripts/build " + part)));
  }
}

TEST(AppParts, TheFirstPartAloneNamesThePartThatHasOtherScenesAndPosesByColmap) {
  const Alone program;
  program.add(kJobsPart);
  const Words small = {"--set", "sphere=true",     "--set", "views=2",
                       "--set", "rig.width_px=64", "--set", "rig.height_px=36"};
  std::vector<Words> cases = {{"render", "maize", "--frames", "1"},
                              {"run", "strawberries", "--pipeline", "scene"}};
  int listed = -1;
  const bool has_physics =
      program.say({"scenes"}, listed).find("WITH_MUJOCO is OFF") == std::string::npos;
  if (has_physics) {
    cases.push_back(Words{"run", "seeds", "--pipeline", "scene"} + small);
    cases.push_back(
        Words{"run", "seeds", "--method", "splats", "--set", "pipeline.splats.poses=sfm"} + small);
  }
  for (const Words& words : cases) {
    int code = -1;
    const std::string text = program.say(words, code);
    EXPECT_EQ(code, 2) << text;
    EXPECT_THAT(text, testing::Not(HasSubstr("render"))) << "refused before any work";
    EXPECT_THAT(text, HasSubstr("not built in; build it with: scripts/build scenes"));
  }
  int code = -1;
  EXPECT_THAT(
      program.say({"scenes"}, code),
      AllOf(testing::AnyOf(HasSubstr("seeds                built in"),
                           HasSubstr("seeds                not built in: WITH_MUJOCO is OFF")),
            HasSubstr("scripts/build scenes")));
  EXPECT_EQ(code, 0);
}

TEST(AppParts, HelpNeedsNoPart) {
  const Alone program;
  int code = -1;
  EXPECT_THAT(program.say({"bench", "--help"}, code), HasSubstr("bench"));
  EXPECT_EQ(code, 0);
}

TEST(AppParts, EachPartIsAFileOfItsOwn) {
  std::set<std::string> files, names;
  for (const Part& part : {kJobsPart, kScenesPart, kBenchPart, kCalibratePart, kFitSensorPart}) {
    files.insert(part.file);
    names.insert(part.name);
    EXPECT_TRUE(fs::exists(fs::path(COUSIN_PROGRAM).parent_path() / part.file)) << part.file;
  }
  EXPECT_EQ(files.size(), 5U);
  EXPECT_EQ(names.size(), 5U);
}

}  // namespace
}  // namespace cousin
