#include "scenes/boards/boards_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <stdexcept>
#include <variant>

#include "sim/render/infrared_pass.h"
#include "sim/render/truth_pass.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

BoardsSceneConfig with_board(const std::string& name) {
  BoardsSceneConfig config;
  config.board = name;
  config.target = board_preset(name);
  return config;
}

const Instance& board_of(const Scene& scene) {
  for (const Instance& instance : scene.instances) {
    if (instance.is_specimen) return instance;
  }
  throw std::runtime_error("no board");
}

TEST(BoardsScene, EveryNumberHasItsSourceWord) {
  for (const char* file : {"boards.toml", "presets.toml"}) {
    std::ifstream in(source_folder() / "scenes/boards" / file);
    int numbers = 0;
    for (std::string line; std::getline(in, line);) {
      const std::size_t equals = line.find(" = ");
      if (line.starts_with("#") || equals == line.npos || line[equals + 3] == '"') continue;
      ++numbers;
      EXPECT_TRUE(line.find("# free") != line.npos || line.find("# sourced: ") != line.npos)
          << file << ": " << line;
    }
    EXPECT_GT(numbers, 30) << file;
  }
}

TEST(BoardsScene, AnInfraredCameraSeesThePrintByItsInksAlbedoThere) {
  BoardsSceneConfig config = with_board("chessboard_a4");
  config.place = "table";
  config.light = "sun";
  config.body.paper_infrared = 0.8;
  config.body.ink_infrared = 0.2;
  Scene scene = build_boards_scene(config, Rng(1));
  std::erase_if(scene.lights,
                [](const Light& light) { return std::holds_alternative<Sky>(light); });
  const Instance& board = board_of(scene);
  TrueView view;
  view.camera.width_px = view.camera.height_px = 120;
  view.camera.fx_px = view.camera.fy_px = 300;
  view.camera.cx_px = view.camera.cy_px = 59.5;
  // Off the middle, so that no edge of the print runs through pixels' centres.
  const Eigen::Vector3d middle_m =
      board.world_from_object.translation_m + Eigen::Vector3d(0.0013, 0.0007, 0);
  view.camera_from_world =
      look_at(middle_m + Eigen::Vector3d(0, 0, 0.413), middle_m, Eigen::Vector3d::UnitY());
  view.camera_from_world_end = view.camera_from_world;
  const RayScene rays(scene);
  const TruthImages truth = render_truth(rays, scene, view, {.instance = true, .part = true});
  const Image<float> radiance =
      render_infrared(rays, scene, view, {}, {.pixel_samples = 1}, Rng(2)).radiance;
  double sum[2] = {0, 0}, count[2] = {0, 0};
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    if (truth.instance.data()[i] != board.id || truth.part.data()[i] > 1) continue;
    sum[truth.part.data()[i]] += static_cast<double>(radiance.data()[i]);
    ++count[truth.part.data()[i]];
  }
  ASSERT_GT(count[0], 3000);
  ASSERT_GT(count[1], 3000);
  // One flat face in even light: 1 % is what the sky's 4 x 4 pattern leaves over thousands of
  // pixels.
  EXPECT_NEAR(sum[1] / count[1] / (sum[0] / count[0]), 0.2 / 0.8, 0.01 * 0.25);
}

TEST(BoardsScene, AStandStandsOnItsFoot) {
  const Scene scene = build_boards_scene(with_board("chessboard_a4"), Rng(1));
  for (const Instance& instance : scene.instances) {
    if (instance.category != "bar") continue;
    double lowest_m = 1, reach_m = 0;
    for (const Eigen::Vector3d& v : mesh_in_world(scene, instance).vertices_m) {
      lowest_m = std::min(lowest_m, v.z());
      if (v.z() < 0.05) reach_m = std::max(reach_m, v.head<2>().norm());
    }
    EXPECT_NEAR(lowest_m, 0, 1e-9);
    EXPECT_GT(reach_m, 0.15);  // wide enough not to fall over
    return;
  }
  FAIL() << "no bar";
}

TEST(BoardsScene, NamesTheTargetAsDesignedWhateverItsFlaws) {
  BoardsSceneConfig config = with_board("charuco_a4");
  config.flaws.warp_x_m = 0.002;
  config.flaws.stretch_x = 1.01;
  const Scene scene = build_boards_scene(config, Rng(1));
  EXPECT_EQ(target_from_text(scene.board), config.target);
}

TEST(BoardsScene, KeypointsAreTheDesignStretchedAndBent) {
  BoardsSceneConfig config = with_board("chessboard_a4");
  config.flaws = {.warp_x_m = 0.003,
                  .warp_y_m = -0.001,
                  .wave_m = 0,
                  .stretch_x = 1.002,
                  .stretch_y = 0.999,
                  .shear = 0.001};
  const Scene scene = build_boards_scene(config, Rng(1));
  const auto& keypoints = scene.models[static_cast<std::size_t>(board_of(scene).model)].keypoints;
  const auto points = target_points(config.target);
  ASSERT_EQ(keypoints.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d at = points[i].at_m;
    const double x = 1.002 * at.x() + 0.001 * at.y(), y = 0.999 * at.y();
    const double u = x / 0.125, v = y / 0.0875;  // over half of 10 x 7 squares of 25 mm
    const Eigen::Vector3d expected(x, y, 0.003 * (1 - u * u) - 0.001 * (1 - v * v));
    EXPECT_LT((keypoints[i].in_object_m - expected).norm(), 1e-15);
    EXPECT_EQ(keypoints[i].name, "corner " + std::to_string(i));
  }
}

TEST(BoardsScene, EveryKeypointIsAVertexOfTheBentFace) {
  BoardsSceneConfig config = with_board("charuco_a4");
  config.flaws.warp_x_m = 0.004;
  config.flaws.wave_m = 0.0005;
  const Scene scene = build_boards_scene(config, Rng(1));
  const ObjectModel& model = scene.models[static_cast<std::size_t>(board_of(scene).model)];
  for (const Keypoint& keypoint : model.keypoints) {
    double nearest = 1;
    for (const Eigen::Vector3d& vertex : model.mesh.vertices_m)
      nearest = std::min(nearest, (vertex - keypoint.in_object_m).norm());
    EXPECT_LT(nearest, 1e-14) << keypoint.name;
  }
}

/// Share of the print's points outside a pinhole's picture.
double share_outside(const BoardsSceneConfig& config, const Pose& camera_from_board) {
  int out = 0, all = 0;
  for (const TargetPoint& point : target_points(config.target)) {
    const Eigen::Vector3d p =
        camera_from_board * Eigen::Vector3d(point.at_m.x(), point.at_m.y(), 0);
    const Eigen::Vector2d u = p.head<2>().cwiseQuotient(config.half_view) / p.z();
    out += p.z() <= 0 || u.cwiseAbs().maxCoeff() > 1;
    ++all;
  }
  return static_cast<double>(out) / all;
}

TEST(BoardPoses, KeepTheWholePrintInThePictureUnlessTheyMayLeaveIt) {
  for (const char* plan : {"planned", "random"}) {
    BoardsSceneConfig config = with_board("aprilgrid_a4");
    config.plan = plan;
    config.views = 60;
    const auto anywhere = [](const Pose&) { return true; };
    for (const Pose& pose : board_poses(config, anywhere, Rng(2)))
      EXPECT_EQ(share_outside(config, pose), 0) << plan;
    config.outside = 0.5;
    int cut = 0;
    for (const Pose& pose : board_poses(config, anywhere, Rng(2))) {
      // A lattice of 13 x 13 points measures an area to about 1 / 13.
      EXPECT_LE(share_outside(config, pose), 0.5 + 0.08) << plan;
      cut += share_outside(config, pose) > 0.1;
    }
    EXPECT_GT(cut, 10) << plan;
  }
}

TEST(BoardPoses, CoverageAndTiltReachWhatIsAsked) {
  BoardsSceneConfig config = with_board("chessboard_a4");
  config.views = 100;
  const auto anywhere = [](const Pose&) { return true; };
  const auto spread = [&] {
    double most = 0;
    for (const Pose& pose : board_poses(config, anywhere, Rng(3)))
      most = std::max(most, (pose.translation_m.head<2>() / pose.translation_m.z()).norm());
    return most;
  };
  EXPECT_GT(spread(), 0.25);
  config.coverage = 0;
  EXPECT_LT(spread(), 1e-12);
  config.setting.poses.tilt_min_rad = 0.5;
  config.setting.poses.tilt_max_rad = 0.6;
  for (const Pose& pose : board_poses(config, anywhere, Rng(3))) {
    const double tilt = std::acos(-(pose.rotation * Eigen::Vector3d::UnitZ()).z());
    EXPECT_GE(tilt, 0.5 - 1e-9);
    EXPECT_LE(tilt, 0.6 + 1e-9);
  }
}

TEST(BoardsScene, EveryPlaceAndLightBuildsAndTheSameTwice) {
  for (const char* place : {"table", "stand", "hand"}) {
    for (const char* light : {"soft", "hard", "sun"}) {
      BoardsSceneConfig config = with_board("aprilgrid_a4");
      config.place = place;
      config.light = light;
      config.views = 7;
      const Scene a = build_boards_scene(config, Rng(4)), b = build_boards_scene(config, Rng(4));
      ASSERT_EQ(a.views.size(), 7U);
      for (std::size_t i = 0; i < a.views.size(); ++i) {
        EXPECT_EQ(a.views[i].rig_from_world.translation_m, b.views[i].rig_from_world.translation_m);
        // The camera sees the face.
        const Pose camera_from_board =
            a.views[i].rig_from_world * world_from_object(board_of(a), a.views[i].time_s);
        EXPECT_GT(centre_in_world_m(camera_from_board).z(), 0.02) << place;
        EXPECT_EQ(share_outside(config, camera_from_board), 0) << place;
      }
    }
  }
}

TEST(BoardsScene, AHeldBoardRestsAboutEachViewsTime) {
  BoardsSceneConfig config = with_board("charuco_a4");
  config.place = "hand";
  config.views = 5;
  const Scene scene = build_boards_scene(config, Rng(5));
  const Instance& board = board_of(scene);
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const double t = scene.views[i].time_s;
    const Pose early = world_from_object(board, t - 0.5), late = world_from_object(board, t + 0.5);
    EXPECT_LT((early.translation_m - late.translation_m).norm(), 1e-12);
    if (i > 0) {
      const Pose before = world_from_object(board, scene.views[i - 1].time_s);
      EXPECT_GT((before.translation_m - early.translation_m).norm(), 1e-3);
    }
  }
}

std::string refusal(const BoardsSceneConfig& config) {
  try {
    validate(config);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(BoardsScene, RefusesByName) {
  BoardsSceneConfig config;
  EXPECT_EQ(refusal(config), "accepted");
  config.place = "moon";
  EXPECT_THAT(refusal(config), HasSubstr("place \"moon\""));
  config = {};
  config.setting.poses.tilt_min_rad = 1.0;
  EXPECT_THAT(refusal(config), HasSubstr("poses.tilt_min_rad"));
  config = {};
  config.setting.poses.fill_max = 1.5;
  EXPECT_THAT(refusal(config), HasSubstr("outside is 0"));
  config = {};
  config.target.dictionary = "DICT_3X3";
  EXPECT_THAT(refusal(config), HasSubstr("DICT_3X3"));
  config = {};
  config.flaws.stretch_x = std::nan("");
  EXPECT_THAT(refusal(config), HasSubstr("stretch_x"));
  EXPECT_THROW(board_preset("a5"), std::invalid_argument);
}

/// Turn and shift from one pose to another, of what the camera sees.
double angle_between(const Pose& a, const Pose& b) {
  return a.rotation.angularDistance(b.rotation);
}

TEST(BoardVideo, TheCameraMovesOnWhileRowsAreReadAsItDoesFromPictureToPicture) {
  BoardsSceneConfig config = with_board("chessboard_a4");
  config.plan = "video";
  config.views = 60;
  config.readout_s = 0.02;
  config.setting.video = {.rate_hz = 50, .pose_step_s = 0.8};
  const Scene scene = build_boards_scene(config, Rng(4));
  ASSERT_EQ(scene.views.size(), 60U);
  double farthest_m = 0, most_turned = 0;
  for (std::size_t i = 0; i + 1 < scene.views.size(); ++i) {
    const View &here = scene.views[i], &next = scene.views[i + 1];
    EXPECT_NEAR(next.time_s - here.time_s, 0.02, 1e-12);
    // A readout as long as a picture ends where the next one begins.
    EXPECT_LT(angle_between(here.rig_from_world_end, next.rig_from_world), 1e-9);
    EXPECT_LT((here.rig_from_world_end.translation_m - next.rig_from_world.translation_m).norm(),
              1e-9);
    const Pose& first = scene.views.front().rig_from_world;
    farthest_m = std::max(
        farthest_m, (centre_in_world_m(next.rig_from_world) - centre_in_world_m(first)).norm());
    most_turned = std::max(most_turned, angle_between(first, next.rig_from_world));
    if (i == 0) continue;
    // No jump of the velocity: a step differs from the last one by the acceleration alone.
    const Vector3d before = centre_in_world_m(scene.views[i - 1].rig_from_world);
    const Vector3d at = centre_in_world_m(here.rig_from_world);
    const Vector3d after = centre_in_world_m(next.rig_from_world);
    EXPECT_LT((after - 2 * at + before).norm() / (0.02 * 0.02), 6) << i;  // m/s^2
  }
  EXPECT_GT(farthest_m, 0.05);
  EXPECT_GT(most_turned, 0.1);
}

TEST(BoardVideo, AHeldBoardHasNone) {
  BoardsSceneConfig config = with_board("chessboard_a4");
  config.plan = "video";
  config.place = "hand";
  EXPECT_THROW(build_boards_scene(config, Rng(1)), std::invalid_argument);
}

TEST(BoardsScene, ViewsArePlannedForTheCameraThatTheRigSeesBy) {
  BoardsSceneConfig config = with_board("chessboard_a4");
  config.views = 4;
  for (const char* place : {"stand", "hand"}) {
    config.place = place;
    config.eye_from_rig = {};
    const Scene plain = build_boards_scene(config, Rng(1));
    config.eye_from_rig.translation_m = {-0.06, 0, 0};
    const Scene beside = build_boards_scene(config, Rng(1));
    for (std::size_t i = 0; i < plain.views.size(); ++i) {
      const Pose eye = config.eye_from_rig * beside.views[i].rig_from_world;
      EXPECT_LT((eye.translation_m - plain.views[i].rig_from_world.translation_m).norm(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace cousin
