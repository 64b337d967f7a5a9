// Captures of other programs and of a camera's folder, from `import` to `perceive`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/imaging/image_io.h"
#include "tests/benchmarks/app/program.h"

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

TEST(AppImport, ColourAndDepthOfTwoCamerasBecomeTwoSensors) {
  const Program program;
  write_png(program.path("shot/rgb/0.png"), Image<Rgb8>(20, 12, {90, 90, 90}));
  write_png(program.path("shot/depth/0.png"), Image<std::uint16_t>(10, 8, 1500));
  write_file(program.path("shot/intrinsics.json"), R"({
    "color": {"width": 20, "height": 12, "fx": 30, "fy": 31, "cx": 9.5, "cy": 5.5},
    "depth": {"width": 10, "height": 8, "fx": 12, "fy": 12, "cx": 4.5, "cy": 3.5},
    "depth_to_color": [[1, 0, 0, 15], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]})");
  const Words import = {"import", "shot", "--format", "rgbd", "--out", "real"};
  const Outcome far = program.run(import);
  EXPECT_EQ(far.code, 3);
  EXPECT_THAT(far.err, AllOf(HasSubstr("depth_to_color"), HasSubstr("--length-unit")));
  const Outcome unit = program.run(import + Words{"--length-unit", "0.001"});
  EXPECT_EQ(unit.code, 3);
  EXPECT_THAT(unit.err, AllOf(HasSubstr("shot/depth"), HasSubstr("--depth-unit")));
  const Outcome imported =
      program.run(import + Words{"--length-unit", "0.001", "--depth-unit", "0.001"});
  ASSERT_EQ(imported.code, 0) << imported.err;
  const Capture capture = read_capture(program.path("real/000000"));
  ASSERT_EQ(capture.rig.size(), 2U);
  EXPECT_EQ(capture.rig[1].name, "depth");
  EXPECT_EQ(capture.frames[0].sensors[1].depth(3, 4) * capture.frames[0].sensors[1].depth_unit_m,
            1.5);
  EXPECT_EQ(program.run({"verify", "real"}).code, 0);
  EXPECT_EQ(program.run(import + Words{"--length-unit", "0.0011", "--depth-unit", "0.001"}).code, 2)
      << "another configuration of the same folder";
}

TEST(AppImport, APairBecomesTwoEyes) {
  const Program program;
  for (const char* name : {"im0.png", "im1.png"})
    write_png(program.path("pair") / name, Image<Rgb8>(20, 12, {90, 90, 90}));
  write_file(program.path("pair/calib.txt"),
             "cam0=[30 0 9.5; 0 30 5.5; 0 0 1]\ncam1=[30 0 9.5; 0 30 5.5; 0 0 1]\ndoffs=0\n"
             "baseline=120\nwidth=20\nheight=12\n");
  const Outcome imported = program.run({"import", "pair", "--format", "stereo", "--out", "real"});
  ASSERT_EQ(imported.code, 0) << imported.err;
  const Capture capture = read_capture(program.path("real/000000"));
  ASSERT_EQ(capture.rig.size(), 2U);
  EXPECT_EQ(capture.rig[1].name, "rgb_right");
  EXPECT_EQ(program.run({"verify", "real"}).code, 0);
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

}  // namespace
}  // namespace cousin
