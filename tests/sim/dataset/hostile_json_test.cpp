#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "sim/dataset/capture_json.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/seam_json.h"
#include "sim/types/memory_limit.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// `text` with the first `from` replaced. A test that replaces nothing tests nothing.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

std::string poses_text() {
  Poses poses(1);
  poses[0].status = PoseStatus::ok;
  poses[0].frame = 3;
  poses[0].camera = {
      .width_px = 640, .height_px = 480, .fx_px = 500, .fy_px = 501, .cx_px = 320, .cy_px = 240};
  return poses_to_json(poses);
}

std::string rig_text() { return rig_to_json(sample_capture()); }

std::string camera_text(const Capture& capture) {
  std::vector<std::vector<ImageKinds>> kinds(
      3, {{.color = true, .raw = true}, {.color = true, .depth = true}});
  return scene_camera_to_json(capture, kinds);
}

std::string poses_error(const std::string& text) {
  return error_of([&] { poses_from_json(text, "poses.json"); });
}
std::string rig_error(const std::string& text) {
  return error_of([&] { rig_from_json(text, "rig.json"); });
}
std::string frames_error(const std::string& text) {
  Capture capture = sample_capture();
  return error_of([&] { frames_from_json(text, "scene_camera.json", capture); });
}

TEST(HostileJson, EveryTruncationIsAnError) {
  const std::string poses = poses_text();
  const std::string rig = rig_text();
  const std::string frames = camera_text(sample_capture());
  ASSERT_EQ(poses_error(poses), "");
  ASSERT_EQ(rig_error(rig), "");
  ASSERT_EQ(frames_error(frames), "");
  for (std::size_t n = 0; n + 2 < poses.size(); n += 7)
    EXPECT_THAT(poses_error(poses.substr(0, n)), HasSubstr("poses.json: not JSON"));
  for (std::size_t n = 0; n + 2 < rig.size(); n += 31)
    EXPECT_THAT(rig_error(rig.substr(0, n)), HasSubstr("rig.json: not JSON"));
  for (std::size_t n = 0; n + 2 < frames.size(); n += 101)
    EXPECT_THAT(frames_error(frames.substr(0, n)), HasSubstr("not JSON"));
}

TEST(HostileJson, AKeyThatStandsTwiceInAnObjectIsNamed) {
  const std::string twice = replaced(poses_text(), "\"frame\": 3,", "\"frame\": 3, \"frame\": 4,");
  EXPECT_THAT(poses_error(twice), HasSubstr("poses.json: the key \"frame\" stands twice"));
}

TEST(HostileJson, TextThatAsksForMoreMemoryThanTheLimitIsRefusedWhileItIsRead) {
  std::string deep = "{\"frames\": [";
  for (int i = 0; i < 100'000; ++i) deep += "[],";
  set_memory_limit(1'000'000);
  EXPECT_THAT(poses_error(deep + "0]}"), AllOf(HasSubstr("poses.json: its JSON would take"),
                                               HasSubstr("the limit is 1000000 bytes")));
  set_memory_limit(0);
}

TEST(HostileJson, PosesNameKeyValueAndLimit) {
  const std::string good = poses_text();
  const auto error = [&](const std::string& from, const std::string& to) {
    return poses_error(replaced(good, from, to));
  };
  EXPECT_THAT(error("\"status\": \"ok\"", "\"status\": \"fine\""),
              AllOf(HasSubstr("poses.json: /frames/0/status = \"fine\""), HasSubstr("no_board")));
  EXPECT_THAT(error("\"frame\": 3", "\"frame\": 3.5"),
              HasSubstr("/frames/0/frame = 3.5 is not an integer"));
  EXPECT_THAT(error("\"frame\": 3", "\"frame\": -1"), HasSubstr("is outside [0, 999999]"));
  EXPECT_THAT(error("\"frame\": 3", "\"frame\": 99999999999999999999"),
              HasSubstr("/frames/0/frame"));
  EXPECT_THAT(error("\"frame\": 3", "\"frame\": 18446744073709551615"),
              HasSubstr("/frames/0/frame"));
  EXPECT_THAT(error("\"frame\": 3,", ""), HasSubstr("lacks the key \"frame\""));
  EXPECT_THAT(error("\"frame\": 3,", "\"frame\": 3, \"extra\": 1,"),
              HasSubstr("unknown key \"extra\""));
  EXPECT_THAT(error("\"fx_px\": 500.0", "\"fx_px\": \"500\""),
              HasSubstr("/frames/0/camera/fx_px = \"500\" is not a number"));
  EXPECT_THAT(error("\"fx_px\": 500.0", "\"fx_px\": NaN"), HasSubstr("not JSON"));
  EXPECT_THAT(error("\"fx_px\": 500.0", "\"fx_px\": null"),
              HasSubstr("/frames/0/camera/fx_px = null is not a number"));
  EXPECT_THAT(error("\"fx_px\": 500.0", "\"fx_px\": 1e999"), HasSubstr("poses.json"));
  EXPECT_THAT(error("\"fx_px\": 500.0", "\"fx_px\": 0"),
              AllOf(HasSubstr("/frames/0/camera"), HasSubstr("frame 3"), HasSubstr("fx_px = 0")));
  EXPECT_THAT(error("\"model\": \"pinhole\"", "\"model\": \"magic\""),
              AllOf(HasSubstr("\"magic\""), HasSubstr("opencv5")));
  EXPECT_THAT(error("\"distortion\": []", "\"distortion\": [0.1]"),
              HasSubstr("/frames/0/camera/distortion"));
  EXPECT_THAT(error("[1.0, 0.0, 0.0, 0.0]", "[2.0, 0.0, 0.0, 0.0]"), HasSubstr("unit norm"));
  EXPECT_THAT(error("[1.0, 0.0, 0.0, 0.0]", "[1.0, 0.0, 0.0]"),
              HasSubstr("/frames/0/camera_from_world/rotation_wxyz"));
  EXPECT_THAT(error("[1.0, 0.0, 0.0, 0.0]", "[1.0, 0.0, \"0\", 0.0]"),
              HasSubstr("/rotation_wxyz/2 = \"0\" is not a finite number"));
  EXPECT_THAT(poses_error("[]"), HasSubstr("is not an object"));
  EXPECT_THAT(poses_error("{\"frames\": {}}"), HasSubstr("/frames = an object is not an array"));
  EXPECT_THAT(poses_error(std::string(100'000, '[')), HasSubstr("not JSON"));
}

TEST(HostileJson, ALensThatFoldsNamesTheFrame) {
  const std::string text =
      replaced(replaced(poses_text(), "\"model\": \"pinhole\"", "\"model\": \"opencv5\""),
               "\"distortion\": []", "\"distortion\": [-1.0, 0, 0, 0, 0]");
  EXPECT_THAT(poses_error(text), AllOf(HasSubstr("poses.json"), HasSubstr("frame 3"),
                                       HasSubstr("folds inside the image")));
  Capture capture = sample_capture();
  capture.frames[1].sensors[1].reported.distortion[0] = -30;
  EXPECT_THAT(frames_error(camera_text(capture)),
              AllOf(HasSubstr("scene_camera.json"), HasSubstr("/10/cousin/sensors/1/camera"),
                    HasSubstr("frame 10"), HasSubstr("folds")));
}

/// A rig whose first lens is splined and whose raw images are a mosaic.
Capture splined_capture(int order) {
  Capture capture = sample_capture();
  Camera& camera = capture.rig.front().camera;
  camera.model = LensModel::splined_stereographic;
  camera.distortion = {};
  camera.spline = {.order = order, .columns = 7, .rows = 6, .fov_x_rad = 2 / 3.0, .delta_u = {}};
  for (int i = 0; i < 84; ++i) camera.spline.delta_u.push_back(0.001 / (1 + i));
  capture.rig.front().raw_format = {Mosaic::grbg, 12, 240};
  return capture;
}

TEST(SplinedJson, EveryDigitComesBack) {
  for (const int order : {2, 3}) {
    const Capture capture = splined_capture(order);
    const Capture back = rig_from_json(rig_to_json(capture), "rig.json");
    EXPECT_EQ(back.rig.front().camera, capture.rig.front().camera);
    EXPECT_EQ(back.rig.front().raw_format, capture.rig.front().raw_format);
    EXPECT_EQ(back.rig.back().raw_format, RawFormat{});
  }
}

TEST(SplinedJson, NamesWhatIsWrong) {
  const std::string good = rig_to_json(splined_capture(3));
  ASSERT_EQ(rig_error(good), "");
  const auto error = [&](const std::string& from, const std::string& to) {
    return rig_error(replaced(good, from, to));
  };
  EXPECT_THAT(error("\"order\": 3", "\"order\": 4"),
              HasSubstr("/sensors/0/camera/spline/order = 4 is outside [2, 3]"));
  EXPECT_THAT(error("\"columns\": 7", "\"columns\": 1025"),
              HasSubstr("/spline/columns = 1025 is outside [1, 1024]"));
  EXPECT_THAT(error("\"columns\": 7", "\"columns\": 8"), HasSubstr("length = 84 is not"));
  EXPECT_THAT(error("\"fov_x_rad\": 0.6", "\"fov_x_rad\": 0.0006"),
              HasSubstr("not one-to-one at pixel"));
  EXPECT_THAT(error("\"fov_x_rad\": 0.6", "\"fov_x_rad\": 1e999"), HasSubstr("not JSON"));
  EXPECT_THAT(error("\"delta_u\": [0.001", "\"delta_u\": [1e300"),
              HasSubstr("is not in [-100, 100]"));
  EXPECT_THAT(error("\"delta_u\": [0.001", "\"delta_u\": [\"x\""), HasSubstr("/delta_u/0"));
  EXPECT_THAT(error("splined_stereographic", "pinhole"), HasSubstr("spline is set"));
  EXPECT_THAT(rig_error(replaced(rig_text(), "opencv5", "splined_stereographic")),
              HasSubstr("distortion"));
  EXPECT_THAT(error("\"bits\": 12", "\"bits\": 17"), HasSubstr("/raw_format/bits = 17"));
  EXPECT_THAT(error("\"black_level\": 240", "\"black_level\": 4095"),
              HasSubstr("black_level = 4095 is outside 0..4094"));
  EXPECT_THAT(error("\"grbg\"", "\"rgbw\""), HasSubstr("is not one of grey, rggb"));
}

TEST(HostileJson, TheRigNamesWhatIsWrong) {
  const std::string good = rig_text();
  const auto error = [&](const std::string& from, const std::string& to) {
    return rig_error(replaced(good, from, to));
  };
  EXPECT_THAT(error("\"schema\": 1", "\"schema\": 2"), HasSubstr("/schema = 2 is outside [1, 1]"));
  EXPECT_THAT(error("\"name\": \"rgb\"", "\"name\": \"../rgb\""), HasSubstr("../rgb"));
  EXPECT_THAT(error("\"name\": \"rgb\"", "\"name\": \"ir_left\""),
              HasSubstr("share the folder \"ir_left\""));
  EXPECT_THAT(error("\"shutter\": \"rolling\"", "\"shutter\": \"folding\""),
              HasSubstr("/sensors/0/shutter"));
  EXPECT_THAT(error("\"linear_raw\": true", "\"linear_raw\": 1"),
              HasSubstr("/sensors/0/linear_raw = 1 is neither true nor false"));
  EXPECT_THAT(error("\"width_px\": 24", "\"width_px\": 0"),
              HasSubstr("/sensors/0/camera/width_px = 0 is outside [1, 65535]"));
  EXPECT_THAT(error("\"board\": \"markers\"", "\"board\": \"chess\""), HasSubstr("/board"));
  EXPECT_THAT(error("\"board\": \"markers\"", "\"board\": \"chessboard columns=1000000000\""),
              HasSubstr("columns"));
  EXPECT_THAT(error("\"board\": \"markers\"", "\"board\": \"circles pitch_m=1e999\""),
              HasSubstr("pitch_m"));
  EXPECT_THAT(rig_error(R"({"schema": 1, "sensors": []})"), HasSubstr("0 sensors"));
}

TEST(HostileJson, SceneCameraNamesWhatIsWrong) {
  const std::string good = camera_text(sample_capture());
  const auto error = [&](const std::string& from, const std::string& to) {
    return frames_error(replaced(good, from, to));
  };
  EXPECT_THAT(error("\"0\": {", "\"zero\": {"), HasSubstr("/zero"));
  EXPECT_THAT(error("\"0\": {", "\"1234567\": {"), HasSubstr("/1234567"));
  EXPECT_THAT(error("\"10\": {", "\"00\": {"), HasSubstr("second entry of frame 0"));
  EXPECT_THAT(error("\"cam_K\": [", "\"cam_K\": [1.0, "), HasSubstr("/0/cam_K"));
  EXPECT_THAT(error("\"cam_K\": [5", "\"cam_K\": [6"),
              HasSubstr("differs from cousin/sensors/0/camera (frame 0)"));
  EXPECT_THAT(error("\"cam_R_w2c\"", "\"cam_R_x\""), HasSubstr("unknown key \"cam_R_x\""));
  EXPECT_THAT(error("\"images\": [\"color\"", "\"images\": [\"colour\""),
              HasSubstr("images/0 = \"colour\""));
  EXPECT_THAT(error("\"depth_unit_m\": 0.001", "\"depth_unit_m\": 0"), HasSubstr("depth_unit_m"));
}

TEST(HostileJson, MasksNameWhatIsWrong) {
  const auto error = [](const std::string& text) {
    return error_of([&] { silhouettes_from_json(text, "masks.json"); });
  };
  const auto mask = [](const std::string& rest) {
    return R"([{"image_id": 1, "instance_id": 0, )" + rest + "}]";
  };
  EXPECT_EQ(error(mask(R"("segmentation": [[0, 0, 4, 0, 4, 4]])")), "");
  EXPECT_THAT(error(mask(R"("segmentation": {"counts": "abc", "size": [4, 4]})")),
              HasSubstr("/0/segmentation/counts = \"abc\""));
  EXPECT_THAT(error(mask(R"("segmentation": [[0, 0, 4]])")), HasSubstr("even number"));
  EXPECT_THAT(error(mask(R"("segmentation": [[0, 0, 4, 0, 1e9, 4]])")),
              HasSubstr("/0/segmentation/0/4"));
  EXPECT_THAT(error(mask(R"("segmentation": [[0, 0, 4, 0, null, 4]])")),
              HasSubstr("/0/segmentation/0/4 = null is not a finite number"));
  EXPECT_THAT(error(mask(R"("segmentation": [[0, 0], [1, 1]])")),
              HasSubstr("/0/segmentation/0 = an array of 2 does not have 6 to"));
  EXPECT_THAT(error(mask(R"("segmentation": [[0, 0, 4, 0, 4, 4]], "cousin": {"normal": [1, 0]})")),
              HasSubstr("/0/cousin/normal"));
  EXPECT_THAT(
      error(mask(
          R"("segmentation": [[0, 0, 4, 0, 4, 4]], "cousin": {"normal": [1, 0, 1, 0, 0, 0]})")),
      HasSubstr("unit vector at point 2"));
  EXPECT_THAT(
      error(mask(R"("segmentation": [[0, 0, 4, 0, 4, 4]], "cousin": {"on_object": [1, 1, 1]})")),
      HasSubstr("/0/cousin/on_object/0"));
  EXPECT_THAT(error(R"([{"image_id": 1, "segmentation": []}])"),
              HasSubstr("lacks the key \"instance_id\""));
  EXPECT_THAT(error(
                  R"([{"image_id": 1, "instance_id": 0, "segmentation": []}, 
             {"image_id": 1000001, "instance_id": 0, "segmentation": []}])"),
              HasSubstr("/1/image_id = 1000001 is of another scene"));
}

std::string trait_in(const std::string& unit, const std::string& value = "12.5") {
  return R"({"specimens": [{"instance": 0, "status": "ok", "traits": [{"name": "length", "unit": ")" +
         unit + R"(", "value": )" + value + R"(, "sigma": 0.5}]}]})";
}

TEST(SeamUnits, TraitsOfAKnownUnitAreConverted) {
  struct Case {
    const char* unit;
    const char* si;
    double factor;
  };
  for (const Case& c :
       {Case{"m", "m", 1}, Case{"mm", "m", 1e-3}, Case{"cm", "m", 1e-2}, Case{"µm", "m", 1e-6},
        Case{"m2", "m2", 1}, Case{"mm2", "m2", 1e-6}, Case{"cm^2", "m2", 1e-4},
        Case{"mm²", "m2", 1e-6}, Case{"m3", "m3", 1}, Case{"mm3", "m3", 1e-9},
        Case{"cm³", "m3", 1e-6}, Case{"ml", "m3", 1e-6}, Case{"l", "m3", 1e-3},
        Case{"deg", "rad", 0.017453292519943295}, Case{"%", "1", 1e-2}, Case{"g", "kg", 1e-3}}) {
    const Traits traits = traits_from_json(trait_in(c.unit), "traits.json");
    EXPECT_EQ(traits[0].traits[0].unit, c.si) << c.unit;
    EXPECT_DOUBLE_EQ(traits[0].traits[0].value, 12.5 * c.factor) << c.unit;
    EXPECT_DOUBLE_EQ(traits[0].traits[0].sigma, 0.5 * c.factor) << c.unit;
  }
}

TEST(SeamUnits, AnUnknownUnitIsRefused) {
  for (const char* unit : {"furlong", "mm4", "", "M", "mm 2", "m-1"}) {
    EXPECT_THAT(error_of([&] { traits_from_json(trait_in(unit), "traits.json"); }),
                AllOf(HasSubstr("traits.json: /specimens/0/traits/0/unit = \"" + std::string(unit)),
                      HasSubstr("is not a unit that is read: m, dm, cm, mm")))
        << unit;
  }
}

TEST(SeamUnits, KeysThatNameAUnitOrAFrameAreRefusedInEverySeam) {
  const auto frames = [](const std::string& more) { return R"({"frames": [])" + more + "}"; };
  for (const char* key : {R"(, "unit": "mm")", R"(, "convention": "opengl")"}) {
    EXPECT_THAT(poses_error(frames(key)), HasSubstr("has the unknown key"));
    EXPECT_THAT(error_of([&] { corners_from_json(frames(key), "corners.json"); }),
                HasSubstr("has the unknown key"));
  }
  EXPECT_THAT(poses_error(replaced(poses_text(), "\"translation_m\"",
                                   "\"unit\": \"mm\", \"translation_m\"")),
              HasSubstr("unknown key \"unit\""));
}

TEST(SceneCamera, KeysOfBopThatSayNothingOfAnImageAreAccepted) {
  Capture capture = sample_capture();
  capture.rig.resize(1);
  const auto error = [&](const std::string& more) {
    return error_of([&] {
      frames_from_json(R"({"0": {"cam_K": [50, 0, 9, 0, 50, 9, 0, 0, 1])" + more + "}}",
                       "scene_camera.json", capture);
    });
  };
  EXPECT_EQ(error(R"(, "depth_scale": 0.1, "view_level": 1, "elev": 3, "mode": 0)"), "");
  EXPECT_THAT(error(R"(, "cam_model": {"k1": 1})"), HasSubstr("unknown key \"cam_model\""));
}

TEST(SceneCamera, ADepthScaleThatDiffersFromOurOwnUnitIsAnError) {
  const std::string good = camera_text(sample_capture());
  const std::size_t at = good.find("\"depth_scale\": ");
  ASSERT_NE(at, std::string::npos);
  std::string edited = good;
  edited.replace(at, edited.find(',', at) - at, "\"depth_scale\": 0.125");
  EXPECT_THAT(frames_error(edited), AllOf(HasSubstr("/depth_scale = 0.125 is not 1000 times"),
                                          HasSubstr("depth_unit_m")));
}

TEST(HostileJson, NamesThatAreNotUtf8AreRefusedBeforeAnythingIsWritten) {
  Capture capture = sample_capture();
  capture.warnings = {"Gr\xfcn.jpg is absent"};
  EXPECT_THAT(error_of([&] { rig_to_json(capture); }),
              AllOf(HasSubstr("/warnings/0"), HasSubstr("Gr\\xfcn.jpg"), HasSubstr("not UTF-8")));
  EXPECT_THAT(error_of([] { to_text(Json{{"\xff", 1}}); }), HasSubstr("\\xff"));
}

TEST(HostileJson, TraitsAndCornersNameWhatIsWrong) {
  const auto traits = [](const std::string& text) {
    return error_of([&] { traits_from_json(text, "traits.json"); });
  };
  EXPECT_THAT(traits(
                  R"({"specimens": [{"instance": 0, "status": "ok", 
             "traits": [{"name": "length", "unit": "m", "value": "1"}]}]})"),
              HasSubstr("traits.json: /specimens/0/traits/0/value = \"1\" is not a number"));
  EXPECT_THAT(traits(
                  R"({"specimens": [{"instance": 0, "status": "ok", 
             "traits": [{"name": "length", "unit": "m", "value": 1, "sigma": -1}]}]})"),
              HasSubstr("sigma = -1 is negative"));
  EXPECT_THAT(traits(
                  R"({"specimens": [{"instance": 0, "status": "ok", "traits": []}, 
             {"instance": 0, "status": "ok", "traits": []}]})"),
              HasSubstr("occurs twice"));
  const auto corners = [](const std::string& text) {
    return error_of([&] { corners_from_json(text, "corners.json"); });
  };
  EXPECT_THAT(corners(
                  R"({"frames": [{"frame": 0, "status": "ok", 
             "corners": [{"column": 0, "row": 0, "pixel_px": [1]}]}]})"),
              HasSubstr("/frames/0/corners/0/pixel_px"));
  EXPECT_THAT(corners(
                  R"({"frames": [{"frame": 0, "status": "ok", "corners": []}, 
             {"frame": 0, "status": "ok", "corners": []}]})"),
              HasSubstr("occurs twice"));
  const auto spread = [&](const std::string& keys) {
    return corners(R"({"frames": [{"frame": 0, "status": "ok", "corners": [
             {"column": 0, "row": 0, "pixel_px": [1, 2], )" +
                   keys + "}]}]}");
  };
  EXPECT_EQ(spread(R"("covariance_px2": [4, -1.9, 1])"), "");
  EXPECT_EQ(spread(R"("sigma_px": 0.1)"), "");
  for (const char* wrong :
       {"[4, 2, 1]", "[4, 2.1, 1]", "[-4, 0, 1]", "[0, 0, 0]", "[1, 0, 2e12]"}) {
    EXPECT_THAT(spread(std::string(R"("covariance_px2": )") + wrong),
                HasSubstr("is not a positive definite covariance [xx, xy, yy]"))
        << wrong;
  }
  EXPECT_THAT(spread(R"("sigma_px": 0)"), HasSubstr("sigma_px = 0 is not positive"));
  EXPECT_THAT(spread(R"("covariance_px2": [1, 0])"),
              HasSubstr("/frames/0/corners/0/covariance_px2"));
  EXPECT_THAT(spread(R"("covariance_px2": [1, 0, 1], "sigma_px": 1)"),
              HasSubstr("comes beside covariance_px2"));
  EXPECT_THAT(error_of([] { timings_from_json(R"({"stages": 3})", "timings.json"); }),
              HasSubstr("/stages = 3 is not an array"));
}

}  // namespace
}  // namespace cousin
