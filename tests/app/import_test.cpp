// Captures of other programs and of a camera's folder, from `import` to `perceive`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/imaging/image_io.h"
#include "tests/app/program.h"
#include "tests/app/specimen_files.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

TEST(AppImport, NerfstudioGivesPosedViewsAndNamesTheImageThatIsAbsent) {
  const Program program;
  for (const char* name : {"a.png", "b.png"}) {
    write_png(program.path("fox/images") / name, Image<Rgb8>(20, 12, {90, 90, 90}));
  }
  write_file(program.path("fox/transforms.json"), R"({
    "fl_x": 30, "fl_y": 31, "cx": 10, "cy": 6, "w": 20, "h": 12, "frames": [
    {"file_path": "images/a.png", "transform_matrix": [[1,0,0,0], [0,1,0,0], [0,0,1,2], [0,0,0,1]]},
    {"file_path": "images/c.png", "transform_matrix": [[1,0,0,0], [0,1,0,0], [0,0,1,2], [0,0,0,1]]},
    {"file_path": "images/b.png", "transform_matrix": [[1,0,0,3], [0,1,0,0], [0,0,1,4], [0,0,0,1]]}
  ]})");
  const Outcome imported =
      program.run({"import", "fox", "--format", "nerfstudio", "--out", "real"});
  ASSERT_EQ(imported.code, 0) << imported.err;
  EXPECT_THAT(imported.err, AllOf(HasSubstr("warning: "), HasSubstr("images/c.png"),
                                  HasSubstr("2 frames, 1 warnings")));
  const Capture capture = read_capture(program.path("real/000000"));
  ASSERT_EQ(capture.frames.size(), 2U);
  EXPECT_EQ(capture.frames[0].sensors[0].reported.cx_px, 9.5);  // from the pixel's centre
  EXPECT_LT(
      (centre_in_world_m(*capture.frames[0].rig_from_world) - Eigen::Vector3d(0, 0, 2)).norm(),
      1e-12);
  EXPECT_LT(
      (centre_in_world_m(*capture.frames[1].rig_from_world) - Eigen::Vector3d(3, 0, 4)).norm(),
      1e-12);
  EXPECT_EQ(program.run({"verify", "real"}).code, 0);
  const Outcome perceived =
      program.run({"perceive", "real", "--pipeline", "seeds", "--out", "est"});
  EXPECT_EQ(perceived.code, 3);
  EXPECT_THAT(perceived.err,
              AllOf(HasSubstr("images/c.png"), HasSubstr("view 2 has no pose: no_board")));

  write_file(program.path("fox/transforms.json"),
             R"({"fl_x": 30, "w": 20, "h": 12, "frames": [{}]})");
  const Outcome broken = program.run({"import", "fox", "--format", "nerfstudio", "--out", "no"});
  EXPECT_EQ(broken.code, 3);
  EXPECT_THAT(broken.err, AllOf(HasSubstr("fox/transforms.json: "), HasSubstr("/frames/0")));
}

TEST(AppImport, PhenomenalGivesSilhouettesOnATurntable) {
  const Program program;
  // 5 m from the axis, along -y of the cabin, and level: R = [x right, y up, z back].
  write_file(program.path("plant/calibration/calibration_camera_side.json"), R"({
    "cam_width_image": 40, "cam_height_image": 30, "cam_focal_length_x": 200,
    "cam_focal_length_y": 200, "cam_pos_x": 0, "cam_pos_y": -5000, "cam_pos_z": 0, "cam_rot_x": 0,
    "cam_rot_y": 0, "cam_rot_z": 0, "angle_factor": 1,
    "cam_origin_axis": [1,0,0,0, 0,0,-1,0, 0,1,0,0, 0,0,0,1]})");
  Image<std::uint8_t> silhouette(40, 30, 0);
  silhouette(21, 11) = 1;
  for (const char* angle : {"0.png", "90.png"}) {
    write_png(program.path("plant/bin/side") / angle, silhouette);
  }
  const Outcome imported =
      program.run({"import", "plant", "--format", "phenomenal", "--out", "real", "--json"});
  ASSERT_EQ(imported.code, 0) << imported.err;
  EXPECT_EQ(nlohmann::json::parse(imported.out)["frames"], 2);
  const Capture capture = read_capture(program.path("real/000000"));
  ASSERT_EQ(capture.frames.size(), 2U);
  const Image<Rgb8>& color = capture.frames[0].sensors[0].color;
  EXPECT_EQ(color(21, 11), (Rgb8{255, 255, 255}));
  EXPECT_EQ(color(20, 11), (Rgb8{0, 0, 0}));
  const auto in_camera_m = [&](std::size_t frame, const Eigen::Vector3d& p) {
    return Eigen::Vector3d(*capture.frames[frame].rig_from_world * p);
  };
  // What is beside the axis at 0 degrees has turned towards the camera at 90.
  EXPECT_LT((in_camera_m(0, {0.1, 0, 0}) - Eigen::Vector3d(0.1, 0, 5)).norm(), 1e-12);
  EXPECT_LT((in_camera_m(1, {0.1, 0, 0}) - Eigen::Vector3d(0, 0, 4.9)).norm(), 1e-12);
  EXPECT_LT((in_camera_m(1, {0, 0, 0.1}) - Eigen::Vector3d(0, -0.1, 5)).norm(), 1e-12);

  // There is no board for seeds on it, unless the user says so.
  const Words perceive = {"perceive", "real", "--pipeline", "seeds", "--out", "est"};
  const Outcome no_board = program.run(perceive);
  EXPECT_EQ(no_board.code, 2);
  EXPECT_THAT(no_board.err, HasSubstr("cousin: the capture's board is \"none\""));
  EXPECT_FALSE(fs::exists(program.path("est/000000/corners.json")));
  const Outcome not_seen = program.run(perceive + Words{"--set", "board_kind=markers"});
  EXPECT_EQ(not_seen.code, 3);
  EXPECT_THAT(not_seen.err, HasSubstr("view 0 has no pose: no_board (not_seen)"));
}

/// Three grains of 10 x 8 x 5 mm on the plane, in millimetres: two side by side, one apart.
std::vector<Mesh> two_that_touch_and_one_apart() {
  std::vector<Mesh> grains;
  for (const Eigen::Vector3d& centre :
       {Eigen::Vector3d(0, -4.01, 0), Eigen::Vector3d(0, 4.01, 0), Eigen::Vector3d(20, 0, 0)}) {
    grains.push_back(ellipsoid_solid({5, 4, 2.5}));
    for (Eigen::Vector3d& v : grains.back().vertices_m) v += centre;
  }
  return grains;
}

TEST(AppImport, PhotographsInAFolderAreMeasuredAndGrainsThatTouchAreSaidToTouch) {
  const Program program;
  write_obj(program.path("grains.obj"), two_that_touch_and_one_apart());
  const Outcome rendered =
      program.run(Words{"render", "seeds", "--out", "data", "--set", "seeds=1", "--set",
                        "specimen=mesh:grains.obj", "--set", "specimen_scale=0.001"} +
                  measured_scene());
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  // What a person with a camera has: images, and one calibration for all of them.
  const Camera lens = read_capture(program.path("data/000000")).rig[0].camera;
  fs::rename(program.path("data/000000/rgb"), program.path("photos"));
  std::string intrinsics;
  for (const double number :
       {lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px, lens.distortion[0], lens.distortion[1],
        lens.distortion[2], lens.distortion[3], lens.distortion[4]}) {
    intrinsics += (intrinsics.empty() ? "" : ",") + std::to_string(number);
  }
  fs::remove_all(program.path("data"));
  const Outcome imported = program.run(
      {"import", "photos", "--format", "folder", "--intrinsics", intrinsics, "--out", "real"});
  ASSERT_EQ(imported.code, 0) << imported.err;

  const Outcome perceived =
      program.run(Words{"perceive", "real", "--pipeline", "seeds", "--out", "est", "--json"} +
                  quick_pipeline());
  ASSERT_EQ(perceived.code, 0) << perceived.err;
  auto rows = nlohmann::json::parse(perceived.out);
  ASSERT_EQ(rows.size(), 2U) << perceived.out;
  std::sort(rows.begin(), rows.end(),
            [](const auto& a, const auto& b) { return a["status"] > b["status"]; });
  EXPECT_EQ(rows[0]["status"], "ok");
  // A pixel spans 0.37 mm.
  EXPECT_NEAR(rows[0]["traits"]["length"]["value"], 0.010, 3e-4);
  EXPECT_NEAR(rows[0]["traits"]["width"]["value"], 0.008, 3e-4);
  EXPECT_NEAR(rows[0]["traits"]["height"]["value"], 0.005, 3e-4);
  EXPECT_EQ(rows[1]["status"], "not_solved");
  EXPECT_EQ(rows[1]["reason"], "surface: touching");
}

}  // namespace
}  // namespace cousin
