// The words by which calibration files of other programs name a lens.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/import.h"
#include "sim/dataset/lens_words.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string yaml(const std::string& words, const std::string& coefficients) {
  return "image_width: 64\nimage_height: 48\n" + words +
         "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [ 40. , 0. , 31.5,\n"
         "           0. , 40. , 23.5,\n           0. , 0. , 1. ]\n"
         "distortion_coefficients:\n  rows: 1\n  data: [" +
         coefficients + "]\n";
}
const std::string kFour = "-0.05, 0.02, 0.03, -0.01";

LensModel model(const std::string& words, const std::string& coefficients) {
  return camera_from_yaml(yaml(words, coefficients), "c.yaml").model;
}
std::string error(const std::string& words, const std::string& coefficients) {
  return error_of([&] { camera_from_yaml(yaml(words, coefficients), "c.yaml"); });
}

TEST(LensWords, EveryWordForAFisheyeGivesOne) {
  for (const char* words :
       {"camera_model: fisheye\n", "camera_model: \"Fisheye\"\n", "distortion_model: equidistant\n",
        "distortion_model: fisheye\n", "distortion_type: Kannala-Brandt\n",
        "lens_model: opencv_fisheye\n", "model_type: KANNALA_BRANDT\n", "fisheye_model: 1\n",
        "camera_model: pinhole\ndistortion_model: equidistant\n",
        "camera_model: fisheye\ndistortion_model: equidistant\n"}) {
    EXPECT_EQ(model(words, kFour), LensModel::kannala_brandt4) << words;
  }
}

TEST(LensWords, EveryWordForABrownLensGivesOne) {
  for (const char* words : {"", "distortion_model: plumb_bob\n", "distortion_model: radtan\n",
                            "distortion_model: radial-tangential\n", "camera_model: pinhole\n",
                            "camera_model: brown_conrady\n", "fisheye_model: 0\n"}) {
    EXPECT_EQ(model(words, kFour), LensModel::opencv5) << words;
  }
  EXPECT_EQ(model("distortion_model: rational_polynomial\n", "0.1,0,0,0,0,0.01,0,0"),
            LensModel::opencv8);
  EXPECT_EQ(model("distortion_model: rational_polynomial\n",
                  "0.1,0,0,0,0,0.01,0,0,0,0,0,0,0,0"),  // as OpenCV writes it
            LensModel::opencv8);
  EXPECT_EQ(model("distortion_model: plumb_bob\n", "0.1,0,0,0,0,0,0,0"), LensModel::opencv5);
}

TEST(LensWords, AnAngleOfViewBesideTheFocalLengthIsRefused) {
  for (const char* key : {"hfov", "FOV_x", "camera_angle_x", "angle_of_view"})
    EXPECT_THAT(error(std::string(key) + ": 1.2\n", kFour),
                AllOf(HasSubstr(key), HasSubstr("may be an angle of view")))
        << key;
}

TEST(LensWords, WordsThatAreNotKnownAreRefusedByName) {
  for (const char* words :
       {"camera_model: omni\n", "distortion_model: fov\n", "distortion_model: ds\n",
        "model_type: MEI\n", "lens_model: tilted\n", "fisheye_model: maybe\n"}) {
    const std::string text = words;
    EXPECT_THAT(error(words, kFour),
                AllOf(HasSubstr("c.yaml: "), HasSubstr(text.substr(0, text.find(':')) + " = ")))
        << words;
  }
}

TEST(LensWords, WordsThatContradictAreRefused) {
  EXPECT_THAT(error("camera_model: fisheye\ndistortion_model: plumb_bob\n", kFour),
              HasSubstr("contradicts"));
  EXPECT_THAT(error("camera_model: fisheye\nfisheye_model: 0\n", kFour), HasSubstr("contradicts"));
  EXPECT_THAT(error("camera_model: fisheye\n", "0.1, 0, 0, 0, 0"), HasSubstr("5 numbers"));
  EXPECT_THAT(error("distortion_model: plumb_bob\n", "0.1,0,0,0,0,0.1,0,0"),
              HasSubstr("8 numbers"));
  EXPECT_THAT(error("distortion_model: none\n", kFour), HasSubstr("is not zero"));
  EXPECT_THAT(error("", "0.1,0,0,0,0,0.01,0,0,0,0,0,0,0.1,0"), HasSubstr("tilted"));
}

TEST(LensWords, AMessageOfCameraInfoIsReadUnlessItIsOfAPartOfTheImager) {
  const std::string message =
      "height: 48\nwidth: 64\ndistortion_model: \"equidistant\"\nD: [0.01, 0, 0, 0]\n"
      "K: [40.0, 0.0, 31.5, 0.0, 40.0, 23.5, 0.0, 0.0, 1.0]\nbinning_x: 0\nroi:\n  x_offset: 0\n";
  const Camera camera = camera_from_yaml(message, "c.yaml");
  EXPECT_EQ(camera.model, LensModel::kannala_brandt4);
  EXPECT_EQ(camera.width_px, 64);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = message;
    text.replace(text.find(from), from.size(), to);
    return error_of([&] { camera_from_yaml(text, "c.yaml"); });
  };
  EXPECT_THAT(changed("binning_x: 0", "binning_x: 2"), HasSubstr("binning_x = 2"));
  EXPECT_THAT(changed("x_offset: 0", "x_offset: 16"), HasSubstr("roi.x_offset = 16"));
}

TEST(LensWords, BoofCvsOtherModelsAreRefused) {
  const std::string pinhole =
      "pinhole:\n  fx: 40\n  fy: 40\n  cx: 31.5\n  cy: 23.5\n  width: 64\n  height: 48\n";
  EXPECT_EQ(camera_from_yaml("model: pinhole_radial_tangential\n" + pinhole, "c").fx_px, 40);
  EXPECT_THAT(error_of([&] { camera_from_yaml("model: kannala_brandt\n" + pinhole, "c"); }),
              HasSubstr("model = kannala_brandt"));
  EXPECT_THAT(error_of([&] { camera_from_yaml(pinhole + "mirror_offset: 1.2\n", "c"); }),
              HasSubstr("mirror_offset"));
}

TEST(LensWords, NumbersBeyondAllMeasureAreErrorsOfTheFile) {
  std::string text = yaml("", kFour);
  text.replace(text.find("40."), 3, "1e308");
  EXPECT_THAT(error_of([&] { camera_from_yaml(text, "c.yaml"); }), HasSubstr("c.yaml: camera: fx"));
}

}  // namespace
}  // namespace cousin
