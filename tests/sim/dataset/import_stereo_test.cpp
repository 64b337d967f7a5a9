// Pairs of pictures of two cameras side by side.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/camera_files.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/import.h"
#include "sim/imaging/image_io.h"
#include "tests/places/places.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const Camera kLens = {
    .width_px = 20, .height_px = 12, .fx_px = 30, .fy_px = 31, .cx_px = 9.5, .cy_px = 5.5};

std::string calib_txt(double baseline_mm = 120) {
  return "cam0=[30 0 9.5; 0 30 5.5; 0 0 1]\ncam1=[30 0 9.5; 0 30 5.5; 0 0 1]\ndoffs=0\nbaseline=" +
         std::to_string(baseline_mm) + "\nwidth=20\nheight=12\n";
}
const std::string kKitti =
    "P0: 30 0 9.5 0 0 30 5.5 0 0 0 1 0\nP1: 30 0 9.5 -15 0 30 5.5 0 0 0 1 0\n"
    "P2: 30 0 9.5 1.5 0 30 5.5 0 0 0 1 0\nP3: 30 0 9.5 -10.5 0 30 5.5 0 0 0 1 0\n";

class Stereo : public testing::Test {
 protected:
  void picture(const std::string& name, std::uint64_t seed = 1) {
    write_png(folder_.path() / name, noise<Rgb8>(20, 12, Rng(seed)));
  }
  void write(const std::string& name, const std::string& text) {
    write_file(folder_.path() / name, text);
  }
  Capture import(const std::string& intrinsics = "", std::optional<double> unit_m = {}) const {
    return import_stereo(folder_.path(), intrinsics, unit_m);
  }
  std::string error() const {
    return error_of([&] { import(); });
  }
  static double baseline_m(const Capture& capture) {
    return centre_in_world_m(capture.rig.at(1).sensor_from_rig).x();
  }
  TemporaryFolder folder_;
};

TEST_F(Stereo, TakesTheUsualFolders) {
  picture("left/2.png", 1);
  picture("left/10.png", 2);
  picture("right/2.png", 3);
  picture("right/10.png", 4);
  write("calib.txt", calib_txt());
  const Capture capture = import();
  ASSERT_EQ(capture.rig.size(), 2U);
  EXPECT_EQ(capture.rig[0].name, "rgb");
  EXPECT_EQ(capture.rig[1].name, "rgb_right");
  EXPECT_NEAR(baseline_m(capture), 0.12, 1e-12);
  ASSERT_EQ(capture.frames.size(), 2U);
  EXPECT_EQ(capture.frames[1].sensors[0].color, noise<Rgb8>(20, 12, Rng(2)));
  EXPECT_EQ(capture.frames[0].sensors[1].color, noise<Rgb8>(20, 12, Rng(3)));
  const TemporaryFolder out;
  write_capture(out.path() / "000000", capture);
  EXPECT_NEAR(baseline_m(read_capture(out.path() / "000000")), 0.12, 1e-12);
}

TEST_F(Stereo, TakesOnePairAndNamesWithWords) {
  picture("im0.png", 1);
  picture("im1.png", 2);
  picture("im1E.png", 3);  // another exposure of Middlebury's
  write("calib.txt", calib_txt());
  EXPECT_EQ(import().frames.size(), 1U);
  EXPECT_EQ(import().frames[0].sensors[1].color, noise<Rgb8>(20, 12, Rng(2)));
  const TemporaryFolder other;
  for (const char* name : {"chair01_left.png", "chair01_right.png", "left02.png", "right02.png"})
    write_png(other.path() / name, Image<Rgb8>(20, 12));
  write_file(other.path() / "calib.txt", calib_txt());
  EXPECT_EQ(import_stereo(other.path(), "").frames.size(), 2U);
}

TEST_F(Stereo, KittisFoldersSayTheirCameras) {
  for (const char* name : {"image_2/000000.png", "image_3/000000.png"}) picture(name);
  write("calib.txt", kKitti);
  EXPECT_NEAR(baseline_m(import()), 0.4, 1e-12);
  for (const char* name : {"image_0/000000.png", "image_1/000000.png"}) picture(name);
  EXPECT_THAT(import().warnings,
              testing::ElementsAre(HasSubstr("image_0/ and image_1/ are not used")));
  fs::remove_all(folder_.path() / "image_2");
  EXPECT_NEAR(baseline_m(import()), 0.5, 1e-12);
  fs::rename(folder_.path() / "image_0", folder_.path() / "left");
  fs::rename(folder_.path() / "image_1", folder_.path() / "right");
  EXPECT_THAT(error(), AllOf(HasSubstr("calib.txt"), HasSubstr("which of its cameras")));
}

TEST_F(Stereo, EurocsTimesAreTheNames) {
  for (const char* camera : {"cam0", "cam1"}) {
    picture(std::string(camera) + "/data/1403636579763555584.png");
    write(std::string(camera) + "/sensor.yaml",
          "resolution: [20, 12]\ncamera_model: pinhole\nintrinsics: [30, 31, 9.5, 5.5]\n"
          "distortion_model: radial-tangential\ndistortion_coefficients: [0, 0, 0, 0]\nT_BS:\n"
          "  data: [1, 0, 0, " +
              std::string(camera[3] == '0' ? "0" : "0.11") +
              ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n");
  }
  const Capture capture = import();
  EXPECT_NEAR(baseline_m(capture), 0.11, 1e-12);
  EXPECT_NEAR(capture.frames[0].time_s, 1403636579.763555584, 1e-6);
}

TEST_F(Stereo, OurOwnCalibrationsComeBack) {
  for (const char* name : {"left/0.png", "right/0.png"}) picture(name);
  Pose right;
  right.translation_m.x() = -0.063;
  const CalibratedCamera first{"left", kLens, {}}, second{"right", kLens, right};
  write("left.yaml", opencv_yaml(first, first));
  write("right.yaml", opencv_yaml(second, first));
  EXPECT_NEAR(baseline_m(import()), 0.063, 1e-12);
  fs::remove(folder_.path() / "left.yaml");
  write("camchain.yaml", kalibr_camchain({first, second}));
  EXPECT_NEAR(baseline_m(import()), 0.063, 1e-12);
  fs::remove(folder_.path() / "camchain.yaml");
  write_capture(folder_.path() / "rig",
                {.rig = {{.camera = kLens},
                         {.name = "rgb_right", .camera = kLens, .sensor_from_rig = right}}});
  EXPECT_NEAR(baseline_m(import((folder_.path() / "rig/rig.json").string())), 0.063, 1e-12);
}

TEST_F(Stereo, OpenCvsTwoFilesHaveLensesAndPose) {
  for (const char* name : {"left/0.png", "right/0.png"}) picture(name);
  const std::string lens = ": !!opencv-matrix\n   data: [30, 0, 9.5, 0, 31, 5.5, 0, 0, 1]\n",
                    none = ": !!opencv-matrix\n   data: [0, 0, 0, 0, 0]\n";
  write("intrinsics.yml", "%YAML:1.0\n---\nM1" + lens + "D1" + none + "M2" + lens + "D2" + none);
  const auto pose = [&](const std::string& t) {
    write("extrinsics.yml",
          "%YAML:1.0\n---\nR:\n   data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT:\n   data: "
          "[" +
              t + ", 0, 0]\n");
  };
  pose("-0.06");
  EXPECT_NEAR(baseline_m(import()), 0.06, 1e-12);
  pose("-60");
  EXPECT_THAT(error(), AllOf(HasSubstr("extrinsics.yml: T: the cameras are 60 m apart"),
                             HasSubstr("0.001 (mm: 0.06 m)")));
  EXPECT_NEAR(baseline_m(import("", 0.001)), 0.06, 1e-12);
}

TEST_F(Stereo, SwappedCamerasAreSaid) {
  for (const char* name : {"left/0.png", "right/0.png"}) picture(name);
  write("calib.txt", calib_txt(-120));
  EXPECT_THAT(error(), AllOf(HasSubstr("calib.txt: baseline"), HasSubstr("(-0.12, 0, 0) m"),
                             HasSubstr("Are left and right swapped?")));
  write("stereo.json",
        R"({"left": {"width": 20, "height": 12, "fx": 30, "fy": 30, "cx": 9, "cy": 5},
    "right": {"width": 20, "height": 12, "fx": 30, "fy": 30, "cx": 9, "cy": 5},
    "right_to_left": [[1, 0, 0, 0], [0, 1, 0, 0.1], [0, 0, 1, 0], [0, 0, 0, 1]]})");
  EXPECT_THAT(error(), AllOf(HasSubstr("stereo.json and "), HasSubstr("--intrinsics")));
  fs::remove(folder_.path() / "calib.txt");
  EXPECT_THAT(error(), HasSubstr("not on its right"));
}

TEST_F(Stereo, PicturesWithoutTheirPartnersAreRefused) {
  for (const char* name : {"left/0.png", "left/1.png", "right/0.png"}) picture(name);
  write("calib.txt", calib_txt());
  EXPECT_THAT(error(), AllOf(HasSubstr("left/1.png: has no partner"), HasSubstr("/right"),
                             HasSubstr("2 pictures are left, 1 are right")));
  for (const char* name : {"right/1.png", "right/2.png"}) picture(name);
  EXPECT_THAT(error(), HasSubstr("right/2.png: has no partner"));
  fs::remove(folder_.path() / "right/2.png");
  write_png(folder_.path() / "right/1.png", Image<Rgb8>(20, 13));
  EXPECT_THAT(error(), AllOf(HasSubstr("right/1.png (frame 1)"), HasSubstr("20 x 13")));
}

TEST_F(Stereo, WhatIsAbsentIsNamed) {
  EXPECT_THAT(error(), HasSubstr("holds no two folders left/ and right/"));
  for (const char* name : {"left/0.png", "right/0.png"}) picture(name);
  EXPECT_THAT(error(), AllOf(HasSubstr("no calibration"), HasSubstr("--intrinsics")));
  write("calib.txt", "nothing\n");
  EXPECT_THAT(error(), HasSubstr("neither Middlebury's"));
  fs::remove(folder_.path() / "calib.txt");
  write("stereo.yaml", "image_width: 20\nimage_height: 12\ncamera_matrix:\n  data: [1, 2]\n");
  EXPECT_THAT(error(), AllOf(HasSubstr("stereo.yaml: has one camera"), HasSubstr("M1, D1")));
  const TemporaryFolder secret;
  write_file(secret.path() / "c.txt", calib_txt());
  fs::remove(folder_.path() / "stereo.yaml");
  fs::create_symlink(secret.path() / "c.txt", folder_.path() / "calib.txt");
  EXPECT_THAT(error(), HasSubstr("symbolic link"));
}

// ---- real pairs ---------------------------------------------------------------------------------

TEST(RealStereo, ABumblebeesPairsAreReadInMillimetres) {
  const fs::path pairs = real_data() / "stereo/boofcv_bumblebee2_raw_pairs",
                 boards = real_data() / "calib/boofcv_bumblebee2_stereo_chess";
  if (!fs::exists(pairs)) GTEST_SKIP() << "no real captures at " << real_data();
  EXPECT_THAT(error_of([&] { import_stereo(pairs, ""); }),
              AllOf(HasSubstr("stereo.yaml: rightToLeft"), HasSubstr("--length-unit")));
  for (const auto& [folder, count] : {std::pair(pairs, 5U), std::pair(boards, 11U)}) {
    const Capture capture = import_stereo(folder, "", 0.001);
    EXPECT_EQ(capture.frames.size(), count);
    EXPECT_NEAR(centre_in_world_m(capture.rig[1].sensor_from_rig).x(), 0.12004, 1e-5);
    EXPECT_NEAR(capture.rig[1].camera.fx_px, 526.437, 1e-3);
  }
}

}  // namespace
}  // namespace cousin
