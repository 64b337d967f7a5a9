// The command line: what each verb takes, and what it says of mistakes. Nothing is computed here.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kVerbs[] = {
    "scenes",    "rigs",       "methods", "doctor", "render", "perceive", "score",  "run",
    "calibrate", "fit-sensor", "bench",   "import", "export", "verify",   "report", "board"};

/// The message of a command that must be refused as wrong usage, before anything is written.
std::string refusal(const Words& words) {
  const Program program;
  const Outcome outcome = program.run(words);
  EXPECT_EQ(outcome.code, 2) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(std::filesystem::is_empty(program.path()));
  EXPECT_THAT(outcome.err, testing::StartsWith("cousin: "));
  return outcome.err;
}

TEST(AppCommandLine, EveryVerbExplainsItself) {
  const Program program;
  const Outcome whole = program.run({"--help"});
  EXPECT_EQ(whole.code, 0);
  for (const char* verb : kVerbs) {
    EXPECT_THAT(whole.out, HasSubstr(std::string("  ") + verb));
    const Outcome outcome = program.run({verb, "--help"});
    EXPECT_EQ(outcome.code, 0) << verb;
    EXPECT_THAT(outcome.out, HasSubstr(std::string("cousin ") + verb));
    EXPECT_EQ(outcome.err, "");
  }
  EXPECT_THAT(program.run({"run", "--help"}).out,
              AllOf(HasSubstr("--frames"), HasSubstr("--set"), HasSubstr("--gate")));
  EXPECT_THAT(program.run({"--version"}).out, testing::MatchesRegex("cousin [0-9.]+\n"));
}

TEST(AppCommandLine, AnUnknownOptionIsNamed) {
  EXPECT_THAT(refusal({"run", "seeds", "--plan", "--stage", "bogus=dir:/"}), HasSubstr("bogus"));
  EXPECT_THAT(refusal({"run", "seeds", "-o", "x"}),
              AllOf(HasSubstr("unknown option -o; did you mean --out?"),
                    HasSubstr("cousin run --help"), Not(HasSubstr("SCENE"))));
  EXPECT_THAT(refusal({"run", "seeds", "--uot", "x"}),
              HasSubstr("unknown option --uot; did you mean --out?"));
  EXPECT_THAT(refusal({"run", "seeds", "--frame=4"}),
              HasSubstr("unknown option --frame; did you mean --frames?"));
  EXPECT_THAT(refusal({"bench", "seeds", "--quik"}),
              HasSubstr("unknown option --quik; did you mean --quick?"));
  EXPECT_THAT(refusal({"verify", "d", "--zzzzzz"}),
              AllOf(HasSubstr("unknown option --zzzzzz"), Not(HasSubstr("did you mean"))));
  EXPECT_THAT(refusal({"--zzzzzz"}), HasSubstr("unknown option --zzzzzz"));
  for (const char* verb : kVerbs) {
    EXPECT_THAT(refusal({verb, "--zzzzzz"}), HasSubstr("unknown option --zzzzzz")) << verb;
  }
}

TEST(AppCommandLine, MistakesNameWhatIsWrong) {
  EXPECT_THAT(refusal({}), HasSubstr("--help"));
  EXPECT_THAT(refusal({"grow"}), HasSubstr("unknown verb \"grow\""));
  EXPECT_THAT(refusal({"run"}), HasSubstr("SCENE is required"));
  EXPECT_THAT(refusal({"perceive"}), HasSubstr("DATASET is required"));
  EXPECT_THAT(refusal({"calibrate"}), HasSubstr("FOLDER is required"));
  EXPECT_THAT(refusal({"score", "dataset"}), HasSubstr("DATASET ESTIMATE"));
  EXPECT_THAT(refusal({"import", "folder"}), HasSubstr("--format is required"));
  EXPECT_THAT(refusal({"run", "seeds", "--threads", "99999"}),
              AllOf(HasSubstr("--threads"), HasSubstr("99999")));
  EXPECT_THAT(refusal({"run", "seeds", "--frames", "-1"}),
              AllOf(HasSubstr("--frames"), HasSubstr("-1")));
  EXPECT_THAT(refusal({"run", "seeds", "--frames", "four"}),
              AllOf(HasSubstr("--frames"), HasSubstr("four")));
  EXPECT_THAT(refusal({"run", "field"}), HasSubstr("scene \"field\" is not one of: seeds"));
  EXPECT_THAT(refusal({"render", "field"}), HasSubstr("scene \"field\" is not one of: seeds"));
  EXPECT_THAT(refusal({"bench", "sedes"}), HasSubstr("suite \"sedes\" is not one of"));
  EXPECT_THAT(refusal({"bench", "seeds", "--shard", "3/3"}), HasSubstr("--shard \"3/3\""));
  EXPECT_THAT(refusal({"bench", "stability", "--captures", "c"}), HasSubstr("takes no --captures"));
  EXPECT_THAT(refusal({"bench", "stability", "--shard", "0/2"}), HasSubstr("takes no --shard"));
  EXPECT_THAT(refusal({"bench", "stability", "--list"}), HasSubstr("takes no --list"));
  EXPECT_THAT(refusal({"bench", "seeds", "--list", "--only", "sorghum"}),
              AllOf(HasSubstr("no job's name holds \"sorghum\""), HasSubstr("--list")));
  EXPECT_THAT(refusal({"bench", "render", "--attribution"}), HasSubstr("takes no --attribution"));
  EXPECT_THAT(refusal({"bench", "seeds", "program", "--quick"}),
              HasSubstr("suite \"program\" takes no --quick"));
  EXPECT_THAT(refusal({"run", "seeds", "--gate", "length"}), HasSubstr("--gate \"length\""));
  EXPECT_THAT(refusal({"run", "seeds", "--stage", "poses=x"}), HasSubstr("--stage \"poses=x\""));
  EXPECT_THAT(refusal({"run", "seeds", "--method", "magic"}), HasSubstr("\"magic\""));
  EXPECT_THAT(refusal({"import", ".", "--format", "zip"}), HasSubstr("--format \"zip\""));
}

TEST(AppCommandLine, ListedJobsSayTheirFactorsAndKeys) {
  const Program program;
  const Outcome outcome =
      program.run({"bench", "seeds", "--list", "--json", "--only", "jimai22_paper_spread"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const nlohmann::json jobs = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_EQ(jobs[0]["suite"], "seeds");
  EXPECT_EQ(jobs[0]["factors"]["cultivar"], "jimai22");
  EXPECT_EQ(jobs[0]["factors"]["views"], "60");
  EXPECT_EQ(jobs[0]["sets"], nlohmann::json({"cultivar=jimai22", "rig=phone_video_1080p",
                                             "views=60", "spread=paper"}));
}

TEST(AppCommandLine, TheHelpOfBenchNamesItsSuites) {
  const std::string message = refusal({"bench", "sedes"});
  const std::string names = message.substr(message.find("one of ") + 7);
  std::string help = Program().run({"bench", "--help"}).out;
  std::replace(help.begin(), help.end(), '\n', ' ');
  for (std::size_t at = help.find("  "); at != std::string::npos; at = help.find("  "))
    help.erase(at, 1);  // lines are broken where they are long
  EXPECT_THAT(help, HasSubstr(names.substr(0, names.find('\n')) + "; none = all"));
}

TEST(AppCommandLine, NumbersAndWordsThatCannotBeAreNamed) {
  EXPECT_THAT(refusal({"run", "seeds", "--seed", "-1"}),
              HasSubstr("--seed: \"-1\" is not a whole number from 0 to"));
  EXPECT_THAT(refusal({"run", "seeds", "--seed", "99999999999999999999999"}), HasSubstr("--seed"));
  EXPECT_THAT(refusal({"run", "seeds", "--frames", "1,5"}),
              HasSubstr("\"1,5\" is not a whole number from 0 to 100000"));
  EXPECT_THAT(refusal({"run", "seeds", "more"}), HasSubstr("\"more\" is one word too many"));
  EXPECT_THAT(refusal({"score", "a", "b", "c"}), HasSubstr("\"c\" is one word too many"));
  EXPECT_THAT(refusal({"scenes", "seeds"}), HasSubstr("\"seeds\" is one word too many"));
  EXPECT_THAT(refusal({"run", "seeds", "--out"}), HasSubstr("--out: its value is missing"));
  EXPECT_THAT(refusal({"run", "seeds", "--out", ""}), HasSubstr("its value is empty"));
  EXPECT_THAT(refusal({"perceive", ""}), HasSubstr("its value is empty"));
  EXPECT_THAT(refusal({"verify", "d", "--out", "x"}),
              HasSubstr("--out: `cousin verify` writes no files"));
  EXPECT_THAT(refusal({"rnu", "seeds"}), HasSubstr("unknown verb \"rnu\"; did you mean run?"));
}

TEST(AppCommandLine, HelpIsAVerbTooAndHasExamples) {
  const Program program;
  EXPECT_EQ(program.run({"help"}).out, program.run({"--help"}).out);
  for (const char* verb : kVerbs) {
    const Outcome help = program.run({"help", verb});
    EXPECT_EQ(help.code, 0);
    EXPECT_EQ(help.out, program.run({verb, "--help"}).out);
    EXPECT_THAT(help.out, HasSubstr(std::string("Example:\n  cousin ") + verb));
  }
  EXPECT_THAT(refusal({"help", "runn"}), HasSubstr("unknown verb \"runn\"; did you mean run?"));
  EXPECT_THAT(refusal({}), AllOf(HasSubstr("no verb is given"), HasSubstr("cousin run seeds")));
}

/// Options that say what a pipeline does, each with a value.
const Words kPipelineOptions[] = {{"--method", "ours"},
                                  {"--stage", "depth=dir:."},
                                  {"--attribution"},
                                  {"--gate", "length.rmse<=1"}};

TEST(AppCommandLine, AnOptionThatASceneHasNotIsRefusedByItsNameWithWhatThereIs) {
  for (const char* scene : {"seedlings", "boards", "specimen"}) {
    for (const Words& option : kPipelineOptions) {
      const std::string text = refusal(Words{"run", scene, "--plan"} + option);
      EXPECT_THAT(text, AllOf(HasSubstr("cousin: " + option[0] + " is not read"), HasSubstr(scene),
                              HasSubstr("--pipeline scene")))
          << scene << " " << option[0];
    }
    EXPECT_THAT(refusal({"run", scene, "--pipeline", "scene", "--attribution", "--plan"}),
                HasSubstr("--attribution is of pipelines that measure traits"));
    EXPECT_THAT(refusal({"run", scene, "--pipeline", "seeds", "--plan"}),
                HasSubstr("--pipeline \"seeds\" is of scene seeds, not of " + std::string(scene)));
    EXPECT_THAT(refusal({"run", scene, "--plan", "--lpips", "x"}),
                HasSubstr("--lpips is of --pipeline scene"));
  }
  for (const char* scene :
       {"seeds", "seedlings", "maize", "apples", "boards", "specimen", "strawberries"}) {
    for (const char* verb : {"run", "render"}) {
      EXPECT_THAT(refusal({verb, scene, "--frames", "20000", "--plan"}),
                  HasSubstr("--frames 20000: views = 20000: must be in [1, 10000]"))
          << verb << " " << scene;
    }
    EXPECT_THAT(refusal({"render", scene, "--streams", "sound", "--plan"}),
                HasSubstr("--streams sound: "));
    EXPECT_THAT(refusal({"render", scene, "--truth", "beauty", "--plan"}),
                HasSubstr("--truth \"beauty\""));
    EXPECT_THAT(refusal({"render", scene, "--method", "ours"}),
                HasSubstr("unknown option --method of `cousin render`; `cousin perceive`, "
                          "`cousin run` and `cousin measure` have it"));
  }
  EXPECT_THAT(refusal({"run", "seeds", "--align", "--plan"}), HasSubstr("--align is of"));
  EXPECT_THAT(refusal({"run", "seeds", "--method", "magic", "--plan"}),
              HasSubstr("--method magic: "));
}

TEST(AppCommandLine, AnOptionThatAFormatHasNotIsRefusedByItsName) {
  EXPECT_THAT(refusal({"export", "d", "--format", "coco", "--task", "pose"}),
              HasSubstr("--task is of --format yolo; coco takes --undistort, --true-cameras, "
                        "--split, --masks, --category, --least-visible"));
  EXPECT_THAT(refusal({"export", "d", "--format", "tum", "--split", "1,0,0"}),
              HasSubstr("--split is of --format bop, coco, yolo"));
  EXPECT_THAT(refusal({"export", "d", "--format", "blend", "--undistort"}),
              HasSubstr("blend takes none of these options"));
}

TEST(AppCommandLine, RenderSaysWhatItWouldDoAndWritesNothing) {
  const Program program;
  for (const char* scene : {"seeds", "seedlings", "maize", "apples", "boards", "strawberries"}) {
    const Outcome plan = program.run({"render", scene, "--plan", "--frames", "3", "--scenes", "2"});
    EXPECT_EQ(plan.code, 0) << scene << ": " << plan.err;
    EXPECT_THAT(plan.out, AllOf(HasSubstr("renders: 6 views of 2 scenes\n"), HasSubstr(" x "),
                                HasSubstr("_dataset, about "), HasSubstr("left out:"),
                                HasSubstr("--truth normal writes it")))
        << scene;
  }
  const Outcome part = program.run({"render", "seeds", "--plan", "--frames", "4", "--set",
                                    "rig=d405", "--streams", "depth", "--shard", "1/2", "--json"});
  const auto json = nlohmann::json::parse(part.out, nullptr, false);
  ASSERT_TRUE(json.is_object()) << part.out << part.err;
  EXPECT_EQ(json["views"], 2);
  EXPECT_EQ(json["views_of_all"], 4);
  ASSERT_EQ(json["pictures"].size(), 1U);
  EXPECT_EQ(json["pictures"][0]["name"], "depth");
  EXPECT_GT(json["pictures"][0]["width_px"], 0);
  for (const auto& pass : json["passes"]) {
    if (pass["pass"] == "radiance") EXPECT_FALSE(pass["runs"]);
    if (pass["pass"] == "truth: noise_free_depth") EXPECT_TRUE(pass["runs"]);
  }
  EXPECT_TRUE(std::filesystem::is_empty(program.path()));
}

TEST(AppCommandLine, AConfigurationFileThatIsWrongIsWrongUsage) {
  const Program program;
  write_file(program.path("bad.toml"), "[scene]\nviews = 3\nsedes = 3\n");
  const Outcome wrong = program.run({"run", "seeds", "--plan", "--config", "bad.toml"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("bad.toml:3: unknown key 'scene.sedes'; the nearest key is "
                                   "'scene.seeds'"));
  const Outcome absent =
      program.run({"perceive", "data", "--pipeline", "seeds", "--config", "absent.toml"});
  EXPECT_EQ(absent.code, 2);
  EXPECT_THAT(absent.err, HasSubstr("absent.toml: no such file"));
  const Outcome rig = program.run({"run", "seeds", "--plan", "--set", "rig=bad.toml"});
  EXPECT_EQ(rig.code, 2) << rig.err;
}

TEST(AppCommandLine, DoctorNamesThePackageOfWhatIsMissing) {
  const Outcome outcome =
      Program().run({"doctor"}, [] { return setenv("PATH", "/nowhere", 1) == 0; });
  EXPECT_EQ(outcome.code, 0);
  for (const char* name : {"colmap", "blender", "ffmpeg", "chromium"})
    EXPECT_THAT(outcome.out, HasSubstr(std::string("missing: apt install ") + name));
  EXPECT_THAT(outcome.out, HasSubstr("All that is missing, on Debian 12: apt install"));
}

TEST(AppCommandLine, SetNamesKeyValueAndLimit) {
  for (const Words& verb : {Words{"run", "seeds"}, {"render", "seeds"}, {"bench", "seeds"}}) {
    EXPECT_THAT(refusal(verb + Words{"--set", "sedes=3"}),
                HasSubstr("unknown key 'sedes'; the nearest key is 'seeds'"))
        << verb[0];
    EXPECT_THAT(refusal(verb + Words{"--set", "seeds=many"}), HasSubstr("seeds = \"many\""));
    EXPECT_THAT(refusal(verb + Words{"--set", "rig.focal_px_per_width=nan"}),
                HasSubstr("rig.focal_px_per_width = nan: must be in"));
    EXPECT_THAT(refusal(verb + Words{"--set", "rig.focal_px_per_width=0"}),
                HasSubstr("rig.focal_px_per_width = 0: must be in"));
    EXPECT_THAT(refusal(verb + Words{"--set", "rig.distortion=[-5,0,0,0,0]"}),
                HasSubstr("distortion folds inside the image"));
  }
  EXPECT_THAT(refusal({"perceive", "dataset", "--pipeline", "seeds", "--set", "green.sedes=3"}),
              HasSubstr("green.sedes"));
  EXPECT_THAT(refusal({"bench", "stability", "--set", "seeds=3"}),
              HasSubstr("suite \"stability\" takes no --set"));
  EXPECT_THAT(refusal({"bench", "--set", "sedes=3"}), HasSubstr("unknown key 'sedes'"));
}

TEST(AppCommandLine, ListsAreJson) {
  const Program program;
  for (const Words& words :
       {Words{"scenes"}, {"rigs"}, {"methods"}, {"doctor"}, {"run", "seeds", "--plan"}}) {
    const Outcome outcome = program.run(words + Words{"--json"});
    EXPECT_EQ(outcome.code, 0) << words[0];
    const auto rows = nlohmann::json::parse(outcome.out, nullptr, false);
    ASSERT_TRUE(rows.is_array()) << words[0] << ": " << outcome.out;
    EXPECT_GT(rows.size(), 0U) << words[0];
    EXPECT_TRUE(rows[0].contains(words[0] == "run" ? "pass" : "name")) << words[0];
    EXPECT_EQ(program.run(words).code, 0) << words[0];
  }
  EXPECT_THAT(program.run({"run", "seeds", "--plan"}).out, HasSubstr("left out:"));
}

TEST(AppCommandLine, KeysAreListed) {
  const Program program;
  for (const Words& words : {Words{"run", "seeds"}, {"render", "seeds"}, {"bench"}}) {
    const Outcome outcome = program.run(words + Words{"--keys", "--set", "seeds=7"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, testing::ContainsRegex("\nseeds +7 ")) << words[0];
  }
  EXPECT_THAT(program.run({"perceive", "dataset", "--keys"}).out, HasSubstr("mvs."));
  EXPECT_TRUE(std::filesystem::is_empty(program.path()));
}

TEST(AppCommandLine, OutputThatCannotBeWrittenIsAnError) {
  const Outcome outcome = Program().run({"scenes", "--json"}, [] {
    const int full = open("/dev/full", O_WRONLY);
    return full >= 0 && dup2(full, STDOUT_FILENO) >= 0;
  });
  if (outcome.code == kNotPrepared) GTEST_SKIP() << "there is no /dev/full";
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("cannot write the output: No space left on device"));
}

}  // namespace
}  // namespace cousin
