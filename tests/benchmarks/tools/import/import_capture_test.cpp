#include "benchmarks/tools/import/import_capture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmarks/tools/import/unknown_lens.h"
#include "benchmarks/tools/import/video_frames.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "sim/process/program_run.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

template <class Work>
std::string usage_error_of(const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

Capture blank_photographs(int count) {
  Capture capture;
  for (int i = 0; i < count; ++i) {
    Frame& frame = capture.frames.emplace_back();
    frame.sensors.emplace_back().color = Image<Rgb8>(64, 48, {100, 100, 100});
  }
  return capture;
}

TEST(UnknownLens, OfTooFewPhotographsIsSaidToBeAnAssumption) {
  const AssumedLens lens = unknown_lens(blank_photographs(2));
  EXPECT_NEAR(lens.camera.fx_px, 0.85 * 64, 1e-9);
  EXPECT_NEAR(lens.focal_sigma_px, 0.25 * 0.85 * 64, 1e-9);
  EXPECT_THAT(lens.from, AllOf(HasSubstr("an assumption"), HasSubstr("needs 3 photographs"),
                               HasSubstr("--intrinsics")));
}

TEST(UnknownLens, WithoutColmapItIsSaidToBeAnAssumption) {
  ColmapConfig config;
  config.program = "no_such_colmap";
  EXPECT_THAT(unknown_lens(blank_photographs(3), config).from,
              AllOf(HasSubstr("an assumption"), HasSubstr("not_built")));
}

TEST(ImportCapture, OptionsThatAFormatHasNoUseForAreWrongUsage) {
  const auto error = [](const ImportRequest& request) {
    return usage_error_of([&] { import_capture(request); });
  };
  EXPECT_THAT(error({.format = "zip", .source = "x"}), HasSubstr("--format \"zip\""));
  EXPECT_THAT(error({.format = "colmap", .source = "x", .intrinsics = "1,1,1,1"}),
              HasSubstr("--intrinsics"));
  EXPECT_THAT(error({.format = "folder", .source = "x", .depth_unit_m = 0.001}),
              HasSubstr("--depth-unit"));
  EXPECT_THAT(error({.format = "stereo", .source = "x", .depth_unit_m = 0.001}),
              HasSubstr("--depth-unit"));
  EXPECT_THAT(error({.format = "tum", .source = "x", .length_unit_m = 0.001}),
              HasSubstr("--length-unit"));
  EXPECT_THAT(error({.format = "folder", .source = "x", .frames = 3}), HasSubstr("--frames"));
}

TEST(ImportCapture, ABlenderSetsPartsAreNamed) {
  const TemporaryFolder folder;
  write_file(folder.path() / "transforms_train.json", "{}");
  EXPECT_THAT(error_of([&] { import_capture({.format = "nerfstudio", .source = folder.path()}); }),
              AllOf(HasSubstr("no transforms.json"), HasSubstr("transforms_train.json")));
}

TEST(ImportCapture, PhotographsWithoutALensAreImported) {
  const TemporaryFolder folder;
  write_png(folder.path() / "a.png", Image<Rgb8>(64, 48));
  const Capture capture = import_capture({.format = "folder", .source = folder.path()});
  EXPECT_NEAR(capture.rig[0].camera.fx_px, 54.4, 1e-9);
  EXPECT_THAT(capture.warnings,
              testing::ElementsAre(AllOf(HasSubstr("54.4 px"), HasSubstr("(25 %)"))));
}

TEST(Sharpness, IsLargerOfSharperPictures) {
  std::vector<unsigned char> sharp(20 * 10), flat(20 * 10, 90);
  for (std::size_t i = 0; i < sharp.size(); ++i) sharp[i] = i % 2 == 0 ? 0 : 200;
  EXPECT_EQ(sharpness(flat.data(), 20, 10), 0);
  EXPECT_GT(sharpness(sharp.data(), 20, 10), 1000);
}

class Video : public testing::Test {
 protected:
  void SetUp() override {
    if (find_program("ffmpeg").empty() || find_program("ffprobe").empty())
      GTEST_SKIP() << "the programs ffmpeg and ffprobe are not installed";
    // Two seconds at 10 Hz, 96 x 64; in every fifth frame alone the test pattern is sharp.
    ProgramCall call;
    call.words = {"ffmpeg",
                  "-v",
                  "error",
                  "-nostdin",
                  "-f",
                  "lavfi",
                  "-i",
                  "testsrc=size=96x64:rate=10:duration=2",
                  "-vf",
                  "boxblur=luma_radius=6:luma_power=2:enable='mod(n,5)-2'",
                  "-c:v",
                  "mpeg4",
                  "-q:v",
                  "2",
                  video().string()};
    call.log = folder_.path() / "log";
    ASSERT_TRUE(succeeded(run_program(call))) << last_lines(call.log);
  }
  fs::path video() const { return folder_.path() / "a b.mp4"; }
  TemporaryFolder folder_;
};

TEST_F(Video, GivesTheSharpestFrameOfEachInterval) {
  const Capture capture = import_capture({.format = "video",
                                          .source = video(),
                                          .intrinsics = "80,80,47.5,31.5",
                                          .depth_unit_m = {},
                                          .frames = 4});
  ASSERT_EQ(capture.frames.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(capture.frames[i].time_s, 0.2 + 0.5 * static_cast<double>(i), 1e-6);
    EXPECT_EQ(capture.frames[i].sensors[0].color.width(), 96);
  }
}

TEST_F(Video, IsTurnedAsItSays) {
  const fs::path turned = folder_.path() / "turned.mp4";
  ProgramCall call;
  call.words = {"ffmpeg", "-v",   "error",           "-nostdin",  "-i",           video().string(),
                "-c",     "copy", "-metadata:s:v:0", "rotate=90", turned.string()};
  call.log = folder_.path() / "log";
  ASSERT_TRUE(succeeded(run_program(call))) << last_lines(call.log);
  const Capture capture = import_capture({.format = "video",
                                          .source = turned,
                                          .intrinsics = "80,80,31.5,47.5",
                                          .depth_unit_m = {},
                                          .frames = 2});
  EXPECT_EQ(capture.frames[0].sensors[0].color.width(), 64);
  EXPECT_EQ(capture.frames[0].sensors[0].color.height(), 96);
}

TEST_F(Video, FilesThatAreNoneAreNamed) {
  const fs::path text = folder_.path() / "list.m3u8";
  write_file(text, "#EXTM3U\n#EXTINF:2,\n" + video().string() + "\n#EXT-X-ENDLIST\n");
  const auto error = [](const fs::path& file) {
    return error_of([&] {
      import_capture({.format = "video", .source = file, .intrinsics = "80,80,47.5,31.5"});
    });
  };
  EXPECT_THAT(error(text), AllOf(HasSubstr("list.m3u8"), HasSubstr("not read as a video")));
  EXPECT_THAT(error(folder_.path() / "absent.mp4"), HasSubstr("absent.mp4: no such file"));
  EXPECT_THAT(usage_error_of([&] { extract_sharp_frames(video(), 1001, folder_.path()); }),
              HasSubstr("[1, 1000]"));
}

}  // namespace
}  // namespace cousin
