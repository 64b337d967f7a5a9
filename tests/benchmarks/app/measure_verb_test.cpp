// measure: photographs and videos of nobody's calibrated camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <sstream>
#include <tuple>

#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "sim/process/program_run.h"
#include "tests/benchmarks/app/program.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// value and half interval of "seed,trait" in a tidy table.
std::map<std::string, std::pair<double, double>> numbers_of(const fs::path& table) {
  std::map<std::string, std::pair<double, double>> numbers;
  std::istringstream lines(read_file(table));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "sample,seed,trait,unit,value,low,high,status,reason");
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::vector<std::string> cell;
    for (std::string text; std::getline(cells, text, ',');) cell.push_back(text);
    if (cell.size() < 8 || cell[2].empty()) continue;
    const double value = std::stod(cell[4]);
    numbers[cell[1] + "," + cell[2]] = {value, std::stod(cell[6]) - value};
  }
  return numbers;
}

/// Two seeds from 18 places; `photos` holds their pictures.
void photograph(const Program& program) {
  const Outcome rendered =
      program.run(Words{"render", "seeds", "--out", "data", "--set", "seeds=2"} + measured_scene());
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  fs::copy(program.path("data/000000/rgb"), program.path("photos"));
}

/// The first block of this language in docs/measure.md.
std::string documented(const std::string& language) {
  const std::string text = read_file(source_folder() / "docs/measure.md");
  const std::string open = "```" + language + "\n";
  const std::size_t first = text.find(open);
  EXPECT_NE(first, text.npos) << language;
  const std::size_t begin = first + open.size();
  return text.substr(begin, text.find("```", begin) - begin);
}

/// What a documented program prints beside the table; empty where the interpreter is absent.
std::string printed_by(const Program& program, const std::string& interpreter,
                       const std::string& language, const std::string& file) {
  if (find_program(interpreter).empty()) return {};
  write_file(program.path("m/" + file), documented(language));
  ProgramCall call;
  call.words = {"sh", "-c",
                "cd '" + program.path("m").string() + "' && " + interpreter + " " + file};
  call.log = program.path("log");
  call.time_limit_s = 60;
  EXPECT_TRUE(succeeded(run_program(call))) << read_file(program.path("log"));
  return read_file(program.path("log"));
}

TEST(AppMeasure, PhotographsOfALensTwiceAsLongAsAssumedAreMeasuredAtThePrintsSize) {
  const Program program;
  photograph(program);
  const Words measure = Words{"measure", "photos", "--out", "m"} + quick_pipeline();
  const Outcome nominal = program.run(measure + Words{"--expect", "2"});
  ASSERT_EQ(nominal.code, 0) << nominal.err;
  // The rig's lens has 1.7 times the width, 816 px; 408 are assumed.
  EXPECT_THAT(nominal.err,
              AllOf(HasSubstr("408.0 px was assumed"), HasSubstr("by the board in 18")));
  EXPECT_THAT(nominal.err, HasSubstr("18 of 18 views posed, 2 specimens"));
  const auto sizes = numbers_of(program.path("m/specimens.csv"));
  ASSERT_EQ(sizes.size(), 10U);
  EXPECT_THAT(read_file(program.path("m/report.html")),
              AllOf(HasSubstr("2 of 2 seeds that are seen are measured"),
                    HasSubstr("Seeds by number, view"), HasSubstr("Nobody has checked")));
  // The lines of docs/measure.md read the table: two lengths and their mean.
  char mean[32];
  std::snprintf(mean, sizeof mean, "2 %.3f",
                0.5 * (sizes.at("0,length").first + sizes.at("1,length").first));
  for (const auto& [interpreter, language, file] :
       {std::tuple("python3", "python", "read.py"), std::tuple("Rscript", "r", "read.R")}) {
    const std::string printed = printed_by(program, interpreter, language, file);
    if (!printed.empty()) EXPECT_THAT(printed, HasSubstr(std::string(mean).substr(0, 6)));
    fs::remove(program.path("m/" + std::string(file)));
  }
  // The estimate is scored like any other's; a pixel spans 0.37 mm.
  const Outcome scored = program.run({"score", "data", "m/estimate", "--out", "s", "--gate",
                                      "length.rmse<=0.0003", "--gate", "height.rmse<=0.0004"});
  EXPECT_EQ(scored.code, 0) << scored.out << scored.err;

  const Outcome shrunk = program.run(measure + Words{"--ruler", "97", "--expect", "3"});
  EXPECT_EQ(shrunk.code, 1);
  EXPECT_THAT(shrunk.err, HasSubstr("photos: 2 seeds are measured, 3 are expected"));
  for (const auto& [name, number] : numbers_of(program.path("m/specimens.csv"))) {
    const int power = name.find("volume") != name.npos ? 3 : name.find("area") != name.npos ? 2 : 1;
    EXPECT_NEAR(number.first / sizes.at(name).first, std::pow(0.97, power), 1e-4) << name;
    EXPECT_LT(number.second, sizes.at(name).second) << name;  // the print is known better
  }
}

TEST(AppMeasure, AVideoIsMeasuredLikeItsPhotographs) {
  if (find_program("ffmpeg").empty()) GTEST_SKIP() << "ffmpeg is not there";
  const Program program;
  photograph(program);
  ProgramCall encode;
  encode.words = {"ffmpeg",
                  "-v",
                  "error",
                  "-framerate",
                  "10",
                  "-i",
                  program.path("photos/%06d.png").string(),
                  "-c:v",
                  "libx264",
                  "-b:v",
                  "8M",
                  "-pix_fmt",
                  "yuv420p",
                  program.path("seeds.mp4").string()};
  encode.log = program.path("log");
  encode.time_limit_s = 60;
  if (!succeeded(run_program(encode))) GTEST_SKIP() << "this ffmpeg has no H.264 encoder";
  const Outcome measured =
      program.run(Words{"measure", "seeds.mp4", "--frames", "18", "--out", "m"} + quick_pipeline());
  ASSERT_EQ(measured.code, 0) << measured.err;
  EXPECT_THAT(measured.err, Not(HasSubstr("cousin_video")));  // no name of a scratch folder
  const Outcome scored = program.run({"score", "data", "m/estimate", "--out", "s", "--gate",
                                      "length.rmse<=0.0004", "--gate", "height.rmse<=0.0006"});
  EXPECT_EQ(scored.code, 0) << scored.out << scored.err;
}

TEST(AppMeasure, MistakesAreNamed) {
  const Program program;
  const auto error_of = [&](const Words& words, int code) {
    const Outcome outcome = program.run(words);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(error_of({"measure"}, 2), HasSubstr("SOURCE"));
  EXPECT_THAT(error_of({"measure", "absent"}, 3), HasSubstr("absent: no such file or folder"));
  EXPECT_THAT(error_of({"measure", "absent", "--ruler", "9.97"}, 2), HasSubstr("--ruler \"9.97\""));
  fs::create_directories(program.path("nothing"));
  EXPECT_THAT(error_of({"measure", "nothing"}, 3), HasSubstr("nothing: holds no photographs"));
  fs::create_directories(program.path("photos"));
  write_png(program.path("photos/1.png"), Image<Rgb8>(64, 48, Rgb8{90, 90, 90}));
  EXPECT_THAT(error_of({"measure", "photos", "--frames", "9"}, 2), HasSubstr("--frames is of vid"));
  EXPECT_THAT(error_of({"measure", "photos", "--group", "seed"}, 2), HasSubstr("--group seed: "));
  for (const char* sigma : {"0.1", "nan"})
    EXPECT_THAT(error_of({"measure", "photos", "--ruler-sigma", sigma}, 2),
                HasSubstr("--ruler-sigma"));
  // A photograph without a board: nothing is measured, and the exit code says so.
  EXPECT_THAT(error_of({"measure", "photos", "--out", "m"}, 3),
              HasSubstr("no view shows the board"));
  EXPECT_EQ(read_file(program.path("m/specimens.csv")),
            "sample,seed,trait,unit,value,low,high,status,reason\n");
}

}  // namespace
}  // namespace cousin
