// Keys and images of transforms.json as nerfstudio, instant-ngp and Blender's scripts write them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/import.h"
#include "sim/imaging/image_io.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kMatrix = R"([[1,0,0,0],[0,1,0,0],[0,0,1,2],[0,0,0,1]])";
const std::string kSize = R"("w": 64, "h": 48)";
const std::string kLens = R"("fl_x": 80, "w": 64, "h": 48)";

std::string file_of(const std::string& keys, const std::string& frame_keys = "",
                    const std::string& image = "images/0.png") {
  return "{" + keys + R"(, "frames": [{"file_path": ")" + image + R"(", "transform_matrix": )" +
         kMatrix + (frame_keys.empty() ? "" : ", " + frame_keys) + "}]}";
}

NerfstudioFile parse(const std::string& keys, const std::string& frame_keys = "") {
  return parse_nerfstudio(file_of(keys, frame_keys), "t.json");
}
Camera camera(const std::string& keys, const std::string& frame_keys = "") {
  return parse(keys, frame_keys).frames[0].camera;
}
std::string error(const std::string& keys, const std::string& frame_keys = "") {
  return error_of([&] { parse(keys, frame_keys); });
}

// ---- lenses -------------------------------------------------------------------------------------

TEST(NerfstudioLens, BothAnglesOfViewCount) {
  // 64 px over 2 atan(0.4) and 48 px over 2 atan(0.2).
  const std::string angles =
      R"(, "camera_angle_x": 0.7610127542247298, "camera_angle_y": 0.3947911196997615)";
  EXPECT_NEAR(camera(kSize + angles).fx_px, 80, 1e-9);
  EXPECT_NEAR(camera(kSize + angles).fy_px, 120, 1e-9);
  EXPECT_NEAR(camera(kSize, angles.substr(2)).fy_px, 120, 1e-9);
  const Camera degrees = camera(kSize + R"(, "x_fov": 90, "y_fov": 60)");
  EXPECT_NEAR(degrees.fx_px, 32, 1e-9);
  EXPECT_NEAR(degrees.fy_px, 24 * std::sqrt(3.0), 1e-9);
}

TEST(NerfstudioLens, OfOneAxisAlonePixelsAreSquare) {
  for (const char* key : {R"("fl_x": 80)", R"("fl_y": 80)",
                          R"("camera_angle_x": 0.7610127542247298)", R"("y_fov": 33.3984887)"}) {
    const Camera lens = camera(kSize + ", " + key);
    EXPECT_NEAR(lens.fx_px, 80, 1e-6) << key;
    EXPECT_EQ(lens.fy_px, lens.fx_px) << key;
  }
}

TEST(NerfstudioLens, AFramesOwnKeysComeFirst) {
  const Camera lens =
      camera(kSize + R"(, "camera_angle_x": 0.7610127542247298)", R"("fl_x": 100, "fl_y": 110)");
  EXPECT_EQ(lens.fx_px, 100);
  EXPECT_EQ(lens.fy_px, 110);
  EXPECT_NEAR(camera(kLens, R"("camera_angle_x": 1.5707963267948966)").fx_px, 32, 1e-9);
}

TEST(NerfstudioLens, TwoFocalLengthsThatDifferAreSaid) {
  // As COLMAP's converter of instant-ngp writes them, rounded.
  EXPECT_THAT(parse(kLens + R"(, "camera_angle_x": 0.761)").warnings, IsEmpty());
  const NerfstudioFile other = parse(kLens + R"(, "camera_angle_x": 0.5)");
  EXPECT_EQ(other.frames[0].camera.fx_px, 80);
  EXPECT_THAT(other.warnings,
              testing::ElementsAre(AllOf(HasSubstr("camera_angle_x"), HasSubstr("fl_x gives 80"))));
  EXPECT_THAT(error(kLens + R"(, "x_fov": 90)"), AllOf(HasSubstr("/x_fov"), HasSubstr("fl_x")));
}

TEST(NerfstudioLens, DistortionParamsAreTheSixInTheirOrder) {
  const Camera lens =
      camera(kLens + R"(, "distortion_params": [0.01, 0.02, 0.03, 0, 0.004, 0.005])");
  EXPECT_EQ(lens.model, LensModel::opencv5);
  EXPECT_EQ(lens.distortion, (std::array<double, 12>{0.01, 0.02, 0.004, 0.005, 0.03}));
  EXPECT_THAT(error(kLens + R"(, "k1": 0.1, "distortion_params": [0,0,0,0,0,0])"),
              HasSubstr("/distortion_params"));
  EXPECT_THAT(error(kLens + R"(, "distortion_params": [0,0,0,0])"),
              HasSubstr("/distortion_params"));
}

TEST(NerfstudioLens, LensesThatAreNotReadAreRefusedByTheirKey) {
  for (const std::string key :
       {R"("k5": 0.1)", R"("k6": -0.1)", R"("s1": 0.1)", R"("b1": 2)", R"("ftheta_p0": 0.1)",
        R"("latlong": true)", R"("equirectangular": true)", R"("orthographic": 1)",
        R"("camera_model": "FISHEYE624")", R"("camera_model": "EQUIRECTANGULAR")",
        R"("camera_model": "OPENCV_FISHEYE", "is_fisheye": false)",
        R"("camera_model": "OPENCV", "is_fisheye": true)",
        R"("camera_model": "OPENCV_FISHEYE", "p1": 0.1)"}) {
    EXPECT_NE(error(kLens + ", " + key), "") << key;
    EXPECT_NE(error(kLens, key), "") << key;
  }
  EXPECT_EQ(error(kLens + R"(, "k5": 0, "s1": 0.0, "latlong": false)"), "");
}

// ---- poses and lengths --------------------------------------------------------------------------

TEST(ImportNerfstudioKeys, KeysThatChangeWhatAPoseMeansAreRefused) {
  for (const std::string key :
       {R"("from_na": true)", R"("from_mitsuba": true)", R"("normal_mts_args": [[1]])",
        R"("rolling_shutter": [0.1, 0, 0, 0])", R"("transform_matrix_start": [[1,0,0,0]])"}) {
    EXPECT_THAT(error(kLens + ", " + key), HasSubstr("changes what the poses mean")) << key;
    EXPECT_THAT(error(kLens, key), HasSubstr("changes what the poses mean")) << key;
  }
  EXPECT_EQ(error(kLens + R"(, "from_na": false, "rolling_shutter": [0, 0, 0, 0])"), "");
}

TEST(ImportNerfstudioKeys, LengthsAreThoseOfTheCapture) {
  const auto height = [](const std::string& keys) {
    return centre_in_world_m(parse(kLens + keys).frames[0].camera_from_world).z();
  };
  EXPECT_EQ(height(""), 2);
  EXPECT_NEAR(height(R"(, "applied_scale": 0.5)"), 4, 1e-12);
  EXPECT_NEAR(height(R"(, "unit": "mm")"), 0.002, 1e-12);
  EXPECT_NEAR(height(R"(, "units": "cm", "applied_scale": 4)"), 0.005, 1e-12);
  EXPECT_THAT(error(kLens + R"(, "unit": "furlong")"), HasSubstr("/unit"));
  EXPECT_THAT(error(kLens + R"(, "applied_scale": 0)"), HasSubstr("/applied_scale"));
  EXPECT_THAT(parse(kLens + R"(, "applied_scale": 0.5)").warnings,
              testing::ElementsAre(HasSubstr("applied_scale = 0.5")));
}

TEST(ImportNerfstudioKeys, ATurnOfTheWorldIsHarmlessAndAScaleInItIsNot) {
  EXPECT_THAT(parse(kLens + R"(, "applied_transform": [[1,0,0,0],[0,0,1,0],[0,-1,0,0]])").warnings,
              IsEmpty());
  EXPECT_THAT(error(kLens + R"(, "applied_transform": [[2,0,0,0],[0,2,0,0],[0,0,2,0]])"),
              HasSubstr("/applied_transform"));
  EXPECT_THAT(error(kLens + R"(, "applied_transform": [[-1,0,0,0],[0,1,0,0],[0,0,1,0]])"),
              HasSubstr("/applied_transform"));
}

TEST(ImportNerfstudioKeys, APlaceBeyondAllMeasureIsDamage) {
  std::string text = file_of(kLens);
  text.replace(text.find("[0,0,1,2]"), 9, "[0,0,1,1e308]");
  EXPECT_THAT(error_of([&] { parse_nerfstudio(text, "t.json"); }),
              AllOf(HasSubstr("/frames/0/transform_matrix"), HasSubstr("1e9")));
}

// ---- images -------------------------------------------------------------------------------------

class NerfstudioFolder : public testing::Test {
 protected:
  Capture import(const std::string& text, std::optional<double> depth_unit_m = {}) {
    write_file(folder_.path() / "transforms.json", text);
    return import_nerfstudio(folder_.path() / "transforms.json", depth_unit_m);
  }
  std::string import_error(const std::string& text) {
    return error_of([&] { import(text); });
  }
  fs::path at(const std::string& name) {
    fs::create_directories((folder_.path() / name).parent_path());
    return folder_.path() / name;
  }
  TemporaryFolder folder_;
};

TEST_F(NerfstudioFolder, WithoutASizeItIsThatOfTheImages) {
  write_png(at("train/r_0.png"), Image<Rgb8>(40, 30));
  const Capture capture = import(
      file_of(R"("camera_angle_x": 1.5707963267948966)", R"("rotation": 0.01)", "./train/r_0"));
  EXPECT_NEAR(capture.rig[0].camera.fx_px, 20, 1e-9);
  EXPECT_EQ(capture.rig[0].camera.height_px, 30);
  EXPECT_EQ(capture.rig[0].camera.cx_px, 19.5);
  EXPECT_THAT(capture.warnings, IsEmpty());
  EXPECT_THAT(import_error(file_of(R"("fl_x": 80, "w": 40)", "", "train/r_0")),
              HasSubstr("lacks the key \"h\""));
}

TEST_F(NerfstudioFolder, NamesWithoutEndingAreFound) {
  const std::vector<std::uint8_t> jpeg = encode_jpeg(Image<Rgb8>(64, 48, {90, 80, 70}), 95);
  write_file(at("images/0.jpg"), {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  EXPECT_EQ(import(file_of(kLens, "", "images/0")).frames.size(), 1U);
  EXPECT_EQ(import(file_of(kLens, "", "images\\\\0.jpg")).frames.size(), 1U);
  write_file(at("images/frame.001.JPG"), read_file(at("images/0.jpg")));
  EXPECT_EQ(import(file_of(kLens, "", "images/frame.001")).frames.size(), 1U);
  EXPECT_THAT(import_error(file_of(kLens, "", "images/1")), HasSubstr("images/1"));
  write_png(at("images/0.png"), Image<Rgb8>(64, 48));
  EXPECT_THAT(import_error(file_of(kLens, "", "images/0")),
              AllOf(HasSubstr("0.png"), HasSubstr("0.jpg")));
}

TEST_F(NerfstudioFolder, NothingOutsideIsRead) {
  const TemporaryFolder secret;
  write_png(secret.path() / "a.png", Image<Rgb8>(64, 48));
  fs::create_directory_symlink(secret.path(), folder_.path() / "images");
  EXPECT_THAT(import_error(file_of(kLens, "", "images/a.png")), HasSubstr("symbolic link"));
  EXPECT_THAT(import_error(file_of(kLens, "", "images/a")), HasSubstr("symbolic link"));
  EXPECT_THAT(import_error(file_of(kLens, "", "..\\\\a.png")), HasSubstr("\"..\""));
  EXPECT_THAT(import_error(file_of(kLens, "", (secret.path() / "a").string())),
              HasSubstr("absolute"));
}

TEST_F(NerfstudioFolder, DepthHasItsUnit) {
  write_png(at("images/0.png"), Image<Rgb8>(64, 48));
  write_png(at("depth/0.png"), Image<std::uint16_t>(64, 48, 1500));
  const std::string depth = R"("depth_file_path": "depth/0.png")";
  const auto metres = [](const Capture& capture) {
    const SensorFrame& sensor = capture.frames[0].sensors[0];
    return sensor.depth(3, 4) * sensor.depth_unit_m;
  };
  EXPECT_NEAR(metres(import(file_of(kLens, depth))), 1.5, 1e-12);
  EXPECT_NEAR(metres(import(file_of(kLens + R"(, "depth_unit_scale_factor": 0.0002)", depth))), 0.3,
              1e-12);
  EXPECT_NEAR(metres(import(file_of(kLens, depth), 0.0001)), 0.15, 1e-12);
  const std::string ngp = R"("depth_path": "depth/0.png")";
  EXPECT_NEAR(metres(import(file_of(kLens + R"(, "integer_depth_scale": 0.002)", ngp))), 3, 1e-12);
  EXPECT_THAT(import_error(file_of(kLens, ngp)), HasSubstr("--depth-unit"));
  EXPECT_TRUE(import(file_of(kLens + R"(, "enable_depth_loading": false)", ngp))
                  .frames[0]
                  .sensors[0]
                  .depth.empty());
  write_png(at("depth/0.png"), Image<std::uint16_t>(32, 24, 1500));
  EXPECT_THAT(import(file_of(kLens, depth)).warnings,
              testing::ElementsAre(AllOf(HasSubstr("frame 0 has no depth"), HasSubstr("32 x 24"))));
}

TEST_F(NerfstudioFolder, AlphaIsSaidToBeUnused) {
  // A PNG of one transparent pixel, 1 x 1, as any program writes it.
  const std::string rgba(
      "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\x08\6\0\0\0\x1f\x15\xc4\x89\0\0\0\nIDATx\x9c"
      "c\0\1\0\0\5\0\1\r\n-\xb4\0\0\0\0IEND\xae"
      "B`\x82",
      67);
  write_file(at("images/0.png"), rgba);
  EXPECT_THAT(import(file_of(R"("fl_x": 2)")).warnings,
              testing::ElementsAre(AllOf(HasSubstr("0.png"), HasSubstr("alpha"))));
}

}  // namespace
}  // namespace cousin
