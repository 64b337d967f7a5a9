#include "sim/dataset/camera_pair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/camera_values.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const PairSizes kSizes = {ImageSize{20, 12}, ImageSize{20, 12}};
const PairLimits kLimits = {0.005, 2};

Eigen::Vector3d centre(const CameraPair& pair) { return centre_in_world_m(pair.second_from_first); }

std::string matrix(const std::string& name, const std::string& data) {
  return name + ": !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ " + data + " ]\n";
}
const std::string kFirst = "30., 0., 9.5, 0., 31., 5.5, 0., 0., 1.",
                  kSecond = "32., 0., 9., 0., 33., 5., 0., 0., 1.",
                  kDistortion = "1.0e-02, 0., 0., 0., 0.",
                  kNoTurn = "1., 0., 0., 0., 1., 0., 0., 0., 1.";
std::string lenses(const std::string& m = "M", const std::string& d = "D") {
  return matrix(m + "1", kFirst) + matrix(d + "1", kDistortion) + matrix(m + "2", kSecond) +
         matrix(d + "2", kDistortion);
}
const std::string kPose = matrix("R", kNoTurn) + matrix("T", "-0.12, 0., 0.");

std::optional<CameraPair> read(const std::string& text, const std::string& name = "s.yaml") {
  return pair_of_values(values_of_file(text, name), kSizes);
}
std::string error(const std::string& text, const std::string& name = "s.yaml") {
  return error_of([&] { read(text, name); });
}

TEST(CameraPairs, OpenCvsKeysAreRead) {
  for (const char* m : {"M", "K", "cameraMatrix", "camera_matrix_"}) {
    const auto pair = read("%YAML:1.0\n---\n" + lenses(m) + kPose);
    ASSERT_TRUE(pair) << m;
    EXPECT_EQ(pair->first.fx_px, 30);
    EXPECT_EQ(pair->second.cy_px, 5);
    EXPECT_EQ(pair->second.distortion[0], 0.01);
    EXPECT_EQ(pair->first.width_px, 20);
    EXPECT_NEAR(centre(*pair).x(), 0.12, 1e-12);
  }
  EXPECT_EQ(read("image_size: [24, 16]\n" + lenses() + kPose)->first.width_px, 24);
}

TEST(CameraPairs, ErrorsNameFileAndKey) {
  EXPECT_THAT(error(lenses()), HasSubstr("s.yaml: has no R and T"));
  EXPECT_THAT(error(matrix("M1", kFirst) + matrix("M2", kSecond) + kPose),
              HasSubstr("the key \"D1\" is missing"));
  EXPECT_THAT(error(lenses() + matrix("R", "1., 0., 0.") + matrix("T", "1., 0., 0.")),
              HasSubstr("R.data has 3 numbers, not 9"));
  EXPECT_THAT(error(lenses() + matrix("R", "-" + kNoTurn) + matrix("T", "1., 0., 0.")),
              HasSubstr("R: the 3 x 3 block mirrors"));
  EXPECT_FALSE(read("a: 1\n"));
}

TEST(CameraPairs, BoofCvsRightToLeftIsTheInverse) {
  const std::string lens =
      "  pinhole:\n    fx: 30\n    fy: 31\n    cx: 9.5\n    cy: 5.5\n"
      "    width: 20\n    height: 12\n  model: pinhole\n";
  const auto pair = read("left:\n" + lens + "model: stereo_camera\nrightToLeft:\n  rotation:\n" +
                         "  - 1\n  - 0\n  - 0\n  - 0\n  - 1\n  - 0\n  - 0\n  - 0\n  - 1\n" +
                         "  x: 120.5\n  y: 0\n  z: 0\nright:\n" + lens);
  ASSERT_TRUE(pair);
  EXPECT_NEAR(centre(*pair).x(), 120.5, 1e-9);
  EXPECT_THAT(error("left:\n" + lens + "right:\n" + lens),
              HasSubstr("\"right_to_left\" is missing"));
}

CameraPair of_two(const std::string& first, const std::string& second) {
  return pair_of_two(YamlValues(first, "left.yaml"), YamlValues(second, "right.yaml"), kSizes);
}
const std::string kRos =
    "image_width: 20\nimage_height: 12\ncamera_matrix:\n  data: [30, 0, 9.5, 0, 31, 5.5, 0, 0, 1]\n"
    "distortion_model: plumb_bob\ndistortion_coefficients:\n  data: [0, 0, 0, 0, 0]\n";

TEST(CameraPairs, RosSaysTheBaselineByItsProjection) {
  const auto rectified = [](const std::string& tx, const std::string& turn) {
    return kRos + "rectification_matrix:\n  data: [" + turn +
           "]\nprojection_matrix:\n  data: [40, "
           "0, 9, " +
           tx + ", 0, 40, 5, 0, 0, 0, 1, 0]\n";
  };
  const CameraPair pair = of_two(rectified("0", "1, 0, 0, 0, 1, 0, 0, 0, 1"),
                                 rectified("-4.8", "1, 0, 0, 0, 1, 0, 0, 0, 1"));
  EXPECT_NEAR(centre(pair).x(), 0.12, 1e-12);
  // Both cameras roll by 90 degrees against the level: their base is along y.
  const CameraPair rolled = of_two(rectified("0", "0, 1, 0, -1, 0, 0, 0, 0, 1"),
                                   rectified("-4.8", "0, 1, 0, -1, 0, 0, 0, 0, 1"));
  EXPECT_NEAR(centre(rolled).y(), 0.12, 1e-12);
  EXPECT_THAT(error_of([&] { of_two(kRos, rectified("0", "1, 0, 0, 0, 1, 0, 0, 0, 1")); }),
              HasSubstr("right.yaml: projection_matrix has no distance"));
  EXPECT_THAT(error_of([&] { of_two(kRos, kRos); }), HasSubstr("right.yaml: does not say where"));
}

TEST(CameraPairs, EurocsSensorsStandOnABody) {
  const auto sensor = [](double x) {
    return "resolution: [20, 12]\ncamera_model: pinhole\nintrinsics: [30, 31, 9.5, 5.5] #fu, fv\n"
           "distortion_model: radial-tangential\ndistortion_coefficients: [0.01, 0, 0, 0]\n"
           "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " +
           std::to_string(x) + ",\n   0, 1, 0, 0,\n   0, 0, 1, 0,\n   0, 0, 0, 1]\n";
  };
  const CameraPair pair = of_two(sensor(-0.02), sensor(0.09));
  EXPECT_EQ(pair.first.fx_px, 30);
  EXPECT_EQ(pair.first.distortion[0], 0.01);
  EXPECT_NEAR(centre(pair).x(), 0.11, 1e-12);
}

const std::string kMiddlebury =
    "cam0=[3997.684 0 1176.728; 0 3997.684 1011.728; 0 0 1]\r\n"
    "cam1=[3997.684 0 1307.839; 0 3997.684 1011.728; 0 0 1]\ndoffs=131.111\nbaseline=193.001\n"
    "width=2964\nheight=1988\nndisp=280\nisint=0\nvmin=31\nvmax=257\n";

TEST(CameraPairs, MiddleburysBaselineIsMillimetres) {
  CameraPair pair = pair_of_middlebury(kMiddlebury, "calib.txt");
  EXPECT_EQ(pair.second.cx_px, 1307.839);
  EXPECT_EQ(pair.first.height_px, 1988);
  scale_pair(pair, {}, kLimits);
  EXPECT_NEAR(centre(pair).x(), 0.193001, 1e-12);
  const auto refusal = [](const std::string& from, const std::string& to) {
    std::string text = kMiddlebury;
    text.replace(text.find(from), from.size(), to);
    return error_of([&] { pair_of_middlebury(text, "calib.txt"); });
  };
  EXPECT_THAT(refusal("doffs=131", "doffs=-131"),
              AllOf(HasSubstr("calib.txt: line 3"), HasSubstr("contradicts")));
  EXPECT_THAT(refusal("baseline", "base"), HasSubstr("the key \"baseline\" is missing"));
  EXPECT_THAT(refusal("1011.728; 0 0 1]\r", "1011.728; 0 1 1]\r"), HasSubstr("line 1"));
  EXPECT_THAT(refusal("width=2964", "width=0"), HasSubstr("[1, 65535]"));
  EXPECT_THAT(refusal("vmin", "ndisp"), HasSubstr("stands twice"));
}

const std::string kKitti =
    "P0: 707 0 10 0 0 707 5 0 0 0 1 0\nP1: 707 0 10 -379.8 0 707 5 0 0 0 1 0\n"
    "P2: 707 0 10 46.9 0 707 5 0.1 0 0 1 0.003\nP3: 707 0 10 -333.5 0 707 5 2.3 0 0 1 0.003\n";

TEST(CameraPairs, KittisCamerasAreThoseOfTheFolders) {
  const CameraPair grey = pair_of_kitti(kKitti, "calib.txt", {0, 1}, kSizes);
  EXPECT_NEAR(centre(grey).x(), 379.8 / 707, 1e-12);
  const CameraPair color = pair_of_kitti(kKitti, "calib.txt", {2, 3}, kSizes);
  EXPECT_NEAR(centre(color).x(), (46.9 + 333.5) / 707, 1e-12);
  EXPECT_NEAR(centre(color).y(), (0.1 - 2.3) / 707, 1e-12);
  const std::string raw =
      "calib_time: 09-Jan-2012 13:57:47\nS_rect_00: 20.0 12.0\nP_rect_00: 707 0 10 0 0 707 5 0 0 0 "
      "1 0\nS_rect_01: 2.0e+01 12\nP_rect_01: 707 0 10 -379.8 0 707 5 0 0 0 1 0\n";
  EXPECT_EQ(pair_of_kitti(raw, "calib.txt", {0, 1}, {}).first.width_px, 20);
  EXPECT_THAT(error_of([&] {
                pair_of_kitti(raw, "calib.txt", {2, 3}, {});
              }),
              HasSubstr("the key \"P2\" is missing"));
  EXPECT_THAT(error_of([&] {
                pair_of_kitti("P0: 1 2\n", "calib.txt", {0, 1}, kSizes);
              }),
              HasSubstr("line 1: P0 has 2 numbers, not 12"));
}

TEST(CameraPairs, LengthsThatNoPairHasAreAskedAbout) {
  const auto scaled = [](double length, std::optional<double> unit_m) {
    CameraPair pair;
    pair.place = "s.yaml: T";
    pair.second_from_first.translation_m.x() = -length;
    scale_pair(pair, unit_m, kLimits);
    return centre(pair).x();
  };
  EXPECT_NEAR(scaled(0.06, {}), 0.06, 1e-12);
  EXPECT_NEAR(scaled(120, 0.001), 0.12, 1e-12);
  EXPECT_THAT(error_of([&] { scaled(120, {}); }),
              AllOf(HasSubstr("s.yaml: T: the cameras are 120 m apart"), HasSubstr("[0.005, 2] m"),
                    HasSubstr("--length-unit"), HasSubstr("0.001 (mm: 0.12 m)")));
  EXPECT_THAT(error_of([&] { scaled(0.12, 0.001); }), HasSubstr("[0.005, 2] m"));
}

}  // namespace
}  // namespace cousin
