#include "sim/dataset/rgbd_intrinsics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_json.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const PairSizes kSizes = {ImageSize{20, 12}, ImageSize{10, 8}};

RgbdCameras read(const std::string& text, const std::string& name = "i.json",
                 std::optional<double> length_unit_m = {}) {
  return rgbd_cameras_of_text(text, name, kSizes, length_unit_m);
}
std::string error(const std::string& text, const std::string& name = "i.json") {
  return error_of([&] { read(text, name); });
}

const std::string kColor = R"("width": 20, "height": 12, "fx": 30, "fy": 31, "cx": 9.5, "cy": 5.5)";
const std::string kDepth =
    R"("width": 10, "height": 8, "fx": 12, "fy": 12, "ppx": 4.5, "ppy": 3.5)";

/// librealsense's words, of two cameras.
std::string both(const std::string& more) {
  return R"({"color": {)" + kColor + R"(, "model": "distortion.inverse_brown_conrady",
    "coeffs": [0, 0, 0, 0, 0]}, "depth": {)" +
         kDepth + R"(, "model": "distortion.brown_conrady", "coeffs": [0.01, 0, 0, 0, 0]})" + more +
         "}";
}
/// x of depth is y of colour: a turn that is not its own inverse.
const std::string kTurn = R"(, "depth_to_color": [[0, -1, 0, 0.015], [1, 0, 0, 0], [0, 0, 1, 0],
  [0, 0, 0, 1]])";

TEST(RgbdIntrinsics, OneCameraIsOfBothImages) {
  const RgbdCameras cameras = read("{" + kColor + R"(, "serial": "x", "depth_scale": 0.00025})");
  EXPECT_EQ(cameras.color.fy_px, 31);
  EXPECT_EQ(cameras.color.width_px, 20);
  EXPECT_EQ(cameras.color.model, LensModel::pinhole);
  EXPECT_FALSE(cameras.depth);
  EXPECT_FALSE(cameras.says_aligned);
  EXPECT_EQ(cameras.depth_keys.unit_m, 0.00025);
}

TEST(RgbdIntrinsics, Open3DsMatrixStandsColumnByColumn) {
  const RgbdCameras cameras = read(R"({"width": 20, "height": 12, "depth_scale": 1000,
    "depth_format": "Z16", "intrinsic_matrix": [30, 0, 0, 0, 31, 0, 9.5, 5.5, 1]})");
  EXPECT_EQ(cameras.color.cx_px, 9.5);
  EXPECT_EQ(cameras.color.cy_px, 5.5);
  EXPECT_EQ(cameras.depth_keys.unit_m, 0.001);
  EXPECT_EQ(read(R"({"width": 20, "height": 12, "intrinsic_matrix":
    [[30, 0, 9.5], [0, 31, 5.5], [0, 0, 1]]})")
                .color,
            cameras.color);
}

TEST(RgbdIntrinsics, TwoCamerasStandWhereTheMatrixSays) {
  const RgbdCameras cameras = read(both(kTurn));
  ASSERT_TRUE(cameras.depth);
  EXPECT_EQ(cameras.depth->cx_px, 4.5);
  EXPECT_EQ(cameras.depth->model, LensModel::opencv5);
  // 1 m along x of depth is 1 m along y of colour, 15 mm to the right of it.
  EXPECT_LT(
      (cameras.depth_from_color * Eigen::Vector3d(0.015, 1, 0) - Eigen::Vector3d(1, 0, 0)).norm(),
      1e-12);
  const RgbdCameras back = read(both(R"(, "color_to_depth": [[0, 1, 0, 0], [-1, 0, 0, 0.015],
    [0, 0, 1, 0], [0, 0, 0, 1]])"));
  EXPECT_LT((to_matrix(back.depth_from_color) - to_matrix(cameras.depth_from_color)).norm(), 1e-12);
}

/// As scripts/rosbag2_to_rgbd.py writes it.
TEST(RgbdIntrinsics, ARosbagsPartOfTheImagerIsRefused) {
  const auto of_roi = [](const std::string& x_offset) {
    return R"({"color": {)" + kColor + R"(, "model": "plumb_bob", "coeffs": [0.1, 0, 0, 0, 0],
      "binning_x": 0, "binning_y": 0, "roi": {"x_offset": )" +
           x_offset + R"(, "y_offset": 0}}, "depth": {)" + kDepth +
           R"(, "model": "", "coeffs": []}, "aligned": false, "depth_unit_m": 0.001)" + kTurn + "}";
  };
  EXPECT_EQ(read(of_roi("0")).color.distortion[0], 0.1);
  EXPECT_EQ(read(of_roi("0")).depth->model, LensModel::pinhole);
  EXPECT_THAT(error(of_roi("4")), HasSubstr("color: roi.x_offset = 4"));
}

TEST(RgbdIntrinsics, LibrealsensesRotationStandsColumnByColumn) {
  const RgbdCameras cameras = read(both(R"(, "depth_to_color": {
    "rotation": [0, 1, 0, -1, 0, 0, 0, 0, 1], "translation": [0.015, 0, 0]})"));
  EXPECT_LT(
      (to_matrix(cameras.depth_from_color) - to_matrix(read(both(kTurn)).depth_from_color)).norm(),
      1e-12);
  EXPECT_THAT(error(both(R"(, "depth_to_color": {"rotation": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
    "translation": [0.015, 0, 0]})")),
              AllOf(HasSubstr("depth_to_color: rotation has rows"), HasSubstr("4 x 4")));
}

TEST(RgbdIntrinsics, WhereTheDepthCameraStandsMustBeSaid) {
  EXPECT_THAT(error(both("")), AllOf(HasSubstr("i.json: has color and depth"),
                                     HasSubstr("\"depth_to_color\" is missing")));
  EXPECT_THAT(error(both(kTurn + R"(, "color_to_depth": [])")), HasSubstr("keep one of them"));
  EXPECT_THAT(
      error(both(R"(, "depth_to_color": [[1, 0, 0, 15], [0, 1, 0, 0], [0, 0, 1, 0],
    [0, 0, 0, 1]])")),
      AllOf(HasSubstr("i.json: depth_to_color: the cameras are 15 m apart"),
            HasSubstr("[0, 0.5] m"), HasSubstr("--length-unit"), HasSubstr("0.001 (mm: 0.015 m)")));
  EXPECT_THAT(error(both(R"(, "depth_to_color": [[1, 0, 0.01, 0], [0, 1, 0, 0], [0, 0, 1, 0],
    [0, 0, 0, 1]])")),
              AllOf(HasSubstr("depth_to_color: the 3 x 3 block is not a rotation")));
  EXPECT_THAT(error(R"({"depth": {)" + kDepth + "}, " + kColor + "}"),
              HasSubstr("has depth, but no section color"));
}

TEST(RgbdIntrinsics, LengthsMayBeMillimetres) {
  const RgbdCameras cameras = read(both(R"(, "depth_to_color": [[1, 0, 0, 15], [0, 1, 0, 0],
    [0, 0, 1, 0], [0, 0, 0, 1]])"),
                                   "i.json", 0.001);
  EXPECT_NEAR(cameras.depth_from_color.translation_m.x(), -0.015, 1e-12);
}

TEST(RgbdIntrinsics, AlignedDepthHasTheColourCamera) {
  const RgbdCameras said = read(both(R"(, "aligned": true)"));
  EXPECT_FALSE(said.depth);
  EXPECT_TRUE(said.says_aligned);
  const std::string same = R"({"color": {)" + kColor + R"(}, "depth": {)" + kColor + "}";
  EXPECT_TRUE(read(same + "}").says_aligned);
  EXPECT_FALSE(read(same + "}").depth);
  EXPECT_TRUE(read(same + kTurn + "}").depth);
  EXPECT_THAT(error(same + R"(, "aligned": false})"), HasSubstr("\"depth_to_color\" is missing"));
  EXPECT_THAT(error("{" + kColor + R"(, "aligned": false})"), HasSubstr("there is one camera"));
  EXPECT_THAT(error("{" + kColor + R"(, "aligned": "maybe"})"), HasSubstr("aligned = maybe"));
}

TEST(RgbdIntrinsics, UnitsOfDepthAreReadOrRefused) {
  const auto unit = [](const std::string& key) {
    return read("{" + kColor + ", " + key + "}").depth_keys.unit_m;
  };
  EXPECT_EQ(unit(R"("depth_scale": 0.001)"), 0.001);
  EXPECT_EQ(unit(R"("depth_scale": 5000)"), 0.0002);
  EXPECT_EQ(unit(R"("DepthMapFactor": 5000.0)"), 0.0002);
  EXPECT_EQ(unit(R"("depth_unit_m": 0.5)"), 0.5);
  EXPECT_EQ(unit(R"("depth_unit": "mm")"), 0.001);
  EXPECT_EQ(unit(R"("depth_scale": 1000, "depth_unit": "mm")"), 0.001);
  const auto refusal = [](const std::string& key) {
    return error("{" + kColor + ", " + key + "}");
  };
  EXPECT_THAT(refusal(R"("depth_scale": 1)"),
              AllOf(HasSubstr("i.json: depth_scale = 1 is neither"), HasSubstr("[100, 1e6]")));
  EXPECT_THAT(refusal(R"("depth_scale": 1000, "depth_unit_m": 0.0001)"), HasSubstr("but i.json"));
  EXPECT_THAT(refusal(R"("depth_unit": "ft")"), HasSubstr("depth_unit = ft is not a unit"));
  EXPECT_THAT(refusal(R"("depth_unit": "kg")"), HasSubstr("not a length"));
  EXPECT_THAT(refusal(R"("depth_unit_m": 2)"), HasSubstr("[1e-6, 1]"));
  for (const char* key :
       {"depth_offset", "inverse_depth", "units", "disparity_shift", "extrinsics", "scaling"}) {
    EXPECT_THAT(refusal("\"" + std::string(key) + "\": 1"),
                AllOf(HasSubstr(key), HasSubstr("is not read")))
        << key;
  }
}

TEST(RgbdIntrinsics, LensesThatAreNotReadAreRefused) {
  const auto refusal = [](const std::string& more) { return error("{" + kColor + more + "}"); };
  EXPECT_THAT(refusal(R"(, "model": "Inverse Brown Conrady", "coeffs": [0.1, 0, 0, 0, 0])"),
              AllOf(HasSubstr("coeffs is not zero"), HasSubstr("cousin calibrate")));
  EXPECT_THAT(refusal(R"(, "distortion": {"k": 1})"), HasSubstr("distortion is not a list"));
  EXPECT_THAT(refusal(R"(, "skew": 1)"), HasSubstr("skew"));
  EXPECT_EQ(read("{" + kColor + R"(, "k1": 0.01, "p2": 0.002})").color.distortion,
            (std::array<double, 12>{0.01, 0, 0, 0.002, 0}));
}

TEST(RgbdIntrinsics, TextsOfAMatrixHaveTheImagesSize) {
  const RgbdCameras cameras = read("30 0 9.5\n0\t31 5.5\n0 0 1\n", "camera-intrinsics.txt");
  EXPECT_EQ(cameras.color.width_px, 20);
  EXPECT_EQ(cameras.color.cy_px, 5.5);
  EXPECT_EQ(read("30 0 9.5 0\n0 31 5.5 0\n0 0 1 0\n0 0 0 1\n", "i.txt").color, cameras.color);
  EXPECT_THAT(error("30 0 9.5\n0 31 5.5\n", "i.txt"), HasSubstr("has 2 rows"));
  EXPECT_THAT(error("30 1 9.5\n0 31 5.5\n0 0 1\n", "i.txt"), HasSubstr("i.txt: line 1"));
  EXPECT_THAT(error("30 0 9.5\n0 31 5.5 1\n0 0 1\n", "i.txt"), HasSubstr("4 numbers, not 3"));
  EXPECT_THAT(error("0 0 9.5\n0 31 5.5\n0 0 1\n", "i.txt"), HasSubstr("fx_px"));
}

TEST(RgbdIntrinsics, BoofCvsDepthIsAligned) {
  const std::string text =
      "model: visual_depth\nmax_depth: 9000\nno_depth: 3\nintrinsic:\n  pinhole:\n    fx: 30\n"
      "    fy: 31\n    cx: 9.5\n    cy: 5.5\n    width: 20\n    height: 12\n    skew: 0.0\n"
      "  model: pinhole_radial_tangential\n  radial_tangential:\n    radial:\n    - 0.01\n";
  const RgbdCameras cameras = read(text, "visualdepth.yaml");
  EXPECT_EQ(cameras.color.distortion[0], 0.01);
  EXPECT_TRUE(cameras.says_aligned);
  EXPECT_EQ(cameras.depth_keys.none, 3);
  EXPECT_EQ(cameras.depth_keys.most, 9000);
  EXPECT_FALSE(cameras.depth_keys.unit_m);
}

TEST(RgbdIntrinsics, OurRigIsReadWithItsDepthSensor) {
  Capture capture;
  const Camera lens = read("{" + kColor + "}").color;
  capture.rig.push_back({.camera = lens});
  const RgbdCameras one = read(rig_to_json(capture), "rig.json");
  EXPECT_FALSE(one.depth);
  EXPECT_TRUE(one.says_aligned);
  capture.rig.push_back({.name = "depth", .camera = lens, .sensor_from_rig = {}});
  capture.rig.back().sensor_from_rig.translation_m.x() = -0.02;
  const RgbdCameras two = read(rig_to_json(capture), "rig.json");
  ASSERT_TRUE(two.depth);
  EXPECT_EQ(two.depth_from_color.translation_m.x(), -0.02);
}

TEST(RgbdIntrinsics, NoBytesOfJsonDoAnythingElseThanThrow) {
  for (const char* text : {"", "[]", "{", "{\"a\": [[[[1]]]]}", "{\"a.b\": 1, \"a\": {\"b\": 2}}",
                           "{\"color\": 1, \"depth\": 2}", "{\"sensors\": 3}"})
    EXPECT_NE(error(text), "") << text;
  EXPECT_THAT(error("{\"a\": " + std::string(40, '[') + std::string(40, ']') + "}"),
              HasSubstr("nested deeper than 32"));
}

// ---- files of a folder --------------------------------------------------------------------------

class IntrinsicsFolder : public testing::Test {
 protected:
  RgbdCameras cameras(const std::string& intrinsics = "") const {
    return rgbd_cameras(folder_.path(), intrinsics, kSizes, {});
  }
  void write(const char* name, const std::string& text) const {
    write_file(folder_.path() / name, text);
  }
  static std::string ros(int width, int height, int focal, const std::string& more = "") {
    return "image_width: " + std::to_string(width) + "\nimage_height: " + std::to_string(height) +
           "\ncamera_matrix:\n  data: [" + std::to_string(focal) + ", 0, 4, 0, " +
           std::to_string(focal) + ", 4, 0, 0, 1]\ndistortion_model: plumb_bob\n" +
           "distortion_coefficients:\n  data: [0, 0, 0, 0, 0]\n" + more;
  }
  TemporaryFolder folder_;
};

TEST_F(IntrinsicsFolder, IntrinsicsAreFoundByTheirNames) {
  EXPECT_THAT(error_of([&] { cameras(); }),
              AllOf(HasSubstr("no intrinsics"), HasSubstr("--intrinsics")));
  EXPECT_EQ(cameras("30,31,9.5,5.5").color.height_px, 12);
  write("camera-intrinsics.txt", "30 0 9.5\n0 31 5.5\n0 0 1\n");
  EXPECT_EQ(cameras().color.fx_px, 30);
  write("intrinsics.json", "{" + kColor + "}");  // the same camera
  EXPECT_EQ(cameras().color.fx_px, 30);
  write("intrinsics.json", "{" + kColor + R"(, "k1": 0.01})");
  EXPECT_THAT(error_of([&] { cameras(); }), AllOf(HasSubstr("camera-intrinsics.txt"),
                                                  HasSubstr("intrinsics.json say different")));
  EXPECT_EQ(cameras((folder_.path() / "intrinsics.json").string()).color.distortion[0], 0.01);
}

TEST_F(IntrinsicsFolder, TwoFilesAreACameraEach) {
  write("color.yaml", ros(20, 12, 30));
  write("depth.yaml", ros(10, 8, 12));
  EXPECT_THAT(error_of([&] { cameras(); }),
              AllOf(HasSubstr("depth.yaml"), HasSubstr("does not say where the camera stands")));
  write("depth.yaml", ros(10, 8, 12,
                          "projection_matrix:\n  data: [12, 0, 4, 0, 0, 12, 4, 0, 0, 0, "
                          "1, 0]\nrectification_matrix:\n  data: [1, 0, 0, 0, 1, 0, 0, "
                          "0, 1]\n"));
  EXPECT_THAT(error_of([&] { cameras(); }), HasSubstr("projection_matrix has no distance"));
  write("depth.yaml", ros(10, 8, 12,
                          "R:\n  data: [0, 1, 0, -1, 0, 0, 0, 0, 1]\n"
                          "T:\n  data: [0, 0.015, 0]\ndepth_unit: mm\n"));
  const RgbdCameras two = cameras();
  ASSERT_TRUE(two.depth);
  EXPECT_EQ(two.depth->fx_px, 12);
  EXPECT_LT((two.depth_from_color * Eigen::Vector3d(0.015, 1, 0) - Eigen::Vector3d(1, 0, 0)).norm(),
            1e-12);
  EXPECT_EQ(two.depth_keys.unit_m, 0.001);
  write("depth.yaml", ros(20, 12, 30));
  EXPECT_FALSE(cameras().depth);
  EXPECT_TRUE(cameras().says_aligned);
}

}  // namespace
}  // namespace cousin
