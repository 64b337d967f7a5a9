// Rigs other than phones in the loop: small images, an empty board.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/loop/truth_choice.h"
#include "benchmarks/loop/truth_stages.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/truth_io.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

/// What a mistake of the caller is told; "" if there is none.
template <class Work>
std::string refusal_of(const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

std::vector<std::string> sphere_with(const std::vector<std::string>& more) {
  std::vector<std::string> sets = {"sphere=true",
                                   "views=2",
                                   "ring_distances_m=[0.30, 0.30, 0.30]",
                                   "render.irradiance_samples=16",
                                   "render.edge_samples=16",
                                   "render.board_texel_m=0.01"};
  sets.insert(sets.end(), more.begin(), more.end());
  return sets;
}

const std::vector<std::string> kSmallD405 = {"rig=d405", "rig.columns=424", "rig.color_columns=160",
                                             "rig.color_rows=120", "rig.color_focal_px=95"};

SimulatedRun simulate(std::vector<std::string> rig, const std::vector<std::string>& more) {
  rig.insert(rig.end(), more.begin(), more.end());
  const RunConfig config = seeds_run_config(sphere_with(rig));
  return simulate(config, 4, 0, default_truth(planned_streams(config)));
}

void expect_same(const Capture& a, const Capture& b) {
  ASSERT_EQ(a.rig.size(), b.rig.size());
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].time_s, b.frames[i].time_s);
    EXPECT_EQ(a.frames[i].rig_from_world.has_value(), b.frames[i].rig_from_world.has_value());
    for (std::size_t s = 0; s < a.rig.size(); ++s) {
      const SensorFrame &x = a.frames[i].sensors[s], &y = b.frames[i].sensors[s];
      EXPECT_EQ(a.rig[s].name, b.rig[s].name);
      EXPECT_TRUE(same_pose(a.rig[s].sensor_from_rig, b.rig[s].sensor_from_rig));
      EXPECT_EQ(x.reported, y.reported);
      EXPECT_EQ(x.color, y.color);
      EXPECT_EQ(x.grey, y.grey);
      EXPECT_EQ(x.depth, y.depth);
      EXPECT_EQ(x.depth_unit_m, y.depth_unit_m);
      EXPECT_EQ(x.time_s, y.time_s);
    }
  }
}

TEST(DepthCaptures, ThroughFilesComesBackWhatIsInMemory) {
  const SimulatedRun run = simulate(kSmallD405, {"streams=all"});
  EXPECT_EQ(sensors_with_truth(run.truth), std::vector<std::size_t>{0});  // one is in colour
  const TemporaryFolder folder;
  write_capture(folder.path(), run.capture);
  write_truth(folder.path(), run.truth);
  expect_same(read_capture(folder.path()), run.capture);
  const SceneTruth truth = read_truth(folder.path());
  ASSERT_EQ(truth.images.size(), 2U);
  ASSERT_EQ(truth.other_sensors.size(), 3U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(
        same_bits(truth.images[i].noise_free_depth_m, run.truth.images[i].noise_free_depth_m));
    EXPECT_EQ(truth.images[i].invalid_reason, run.truth.images[i].invalid_reason);
    EXPECT_EQ(truth.images[i].invalid_reason.width(), 424);
  }
}

TEST(DepthCaptures, OfTimeOfFlightAndStructuredLightComeBackFromFilesToo) {
  const std::vector<std::vector<std::string>> rigs = {
      {"rig=kinect_v2", "rig.time_of_flight.columns=128", "rig.time_of_flight.rows=106"},
      {"rig=kinect_v1", "rig.structured_light.columns=160", "rig.structured_light.rows=120"}};
  for (std::vector<std::string> rig : rigs) {
    rig.insert(rig.end(), {"rig.rgb.width_px=96", "rig.rgb.height_px=64"});
    const SimulatedRun run =
        simulate(rig, {"streams=all", "ring_distances_m=[0.6, 0.6, 0.6]", "knows_pose=true"});
    ASSERT_EQ(run.capture.rig.size(), 2U) << rig.front();
    const TemporaryFolder folder;
    write_capture(folder.path(), run.capture);
    write_truth(folder.path(), run.truth);
    expect_same(read_capture(folder.path()), run.capture);
    const SceneTruth truth = read_truth(folder.path());
    ASSERT_EQ(truth.other_sensors.size(), 1U);
    EXPECT_EQ(truth.other_sensors[0].sensor, "depth");
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_TRUE(
          same_bits(truth.images[i].noise_free_depth_m, run.truth.images[i].noise_free_depth_m));
      EXPECT_EQ(truth.images[i].invalid_reason, run.truth.images[i].invalid_reason);
    }
    const Image<std::uint16_t>& depth = run.capture.frames[0].sensors[1].depth;
    EXPECT_GT(std::count_if(depth.begin(), depth.end(), [](auto z) { return z != 0; }),
              static_cast<std::ptrdiff_t>(depth.size() / 10));
  }
}

TEST(DepthCaptures, ARunOfAColourPipelineHoldsColourAlone) {
  const SimulatedRun run = simulate(kSmallD405, {});
  for (const Frame& frame : run.capture.frames) {
    EXPECT_FALSE(frame.sensors[0].color.empty());
    EXPECT_TRUE(frame.sensors[1].grey.empty() && frame.sensors[3].depth.empty());
  }
  EXPECT_TRUE(run.truth.images[0].invalid_reason.empty());
}

TEST(DepthCaptures, TheBoardIsWhereTheDepthSaysThroughTheReportedCalibration) {
  const SimulatedRun run = simulate(
      {"rig=d405", "rig.columns=640"},
      {"knows_pose=true", "pose_error_m=0", "pose_error_rad=0", "pipeline.method=depth_only"});
  EXPECT_TRUE(run.capture.frames[0].sensors[0].color.empty());
  const Poses poses = poses_of_rig(run.capture);
  const DepthVolume plate{{-0.05, -0.05, -0.02}, {0.05, 0.05, 0.03}};
  const Depths depths = depths_of_sensor(run.capture, poses, plate);
  // Heights of the plate's points over z = 0: beside the sphere and its shadow in the depth image.
  double sum_m = 0;
  int count = 0;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    for (int y = 0; y < depths[i].depth_m.height(); ++y) {
      for (int x = 0; x < depths[i].depth_m.width(); ++x) {
        const float z_m = depths[i].depth_m(x, y);
        const auto ray = unproject(poses[i].camera, Eigen::Vector2d(x, y));
        if (std::isnan(z_m) || !ray) continue;
        const Eigen::Vector3d point_m = inverse(poses[i].camera_from_world) *
                                        (*ray * (static_cast<double>(z_m) / ray->z())).eval();
        if (point_m.head<2>().norm() < 0.03) continue;
        sum_m += point_m.z();
        ++count;
      }
    }
  }
  ASSERT_GT(count, 500);
  // A unit's yaw of 5e-5 rad is 0.02 px of f B / Z = 382 * 0.018 / 0.3 = 23 px, its focal length
  // and baseline 0.05 % each: 0.3 mm of 0.3 m; colour's turn of 0.5 mrad moves points 0.15 mm.
  // Matching is biased by up to 0.1 px, 1.3 mm, at the print's edges, either way.
  EXPECT_NEAR(sum_m / count, 0, 0.0015);
}

TEST(DepthCaptures, TheZedHandsOverBothEyesAndTheirDisparity) {
  RunConfig config =
      seeds_run_config(sphere_with({"rig=zed_hd720", "rig.rgb.width_px=160", "rig.rgb.height_px=90",
                                    "rig.rgb_right.width_px=160", "rig.rgb_right.height_px=90"}));
  const SimulatedRun run = simulate(config, 4, 0, {.disparity = true});
  ASSERT_EQ(run.capture.rig.size(), 2U);
  EXPECT_EQ(run.capture.rig[1].name, "rgb_right");
  for (const SensorFrame& sensor : run.capture.frames[1].sensors)
    EXPECT_EQ(sensor.color.width(), 160);
  EXPECT_NE(run.capture.frames[1].sensors[0].color, run.capture.frames[1].sensors[1].color);
  EXPECT_EQ(run.truth.images[1].stereo.state.width(), 160);
}

/// Both eyes of a small ZED, and what each sees.
RunConfig small_zed() {
  return seeds_run_config(
      sphere_with({"rig=zed_hd720", "rig.rgb.width_px=160", "rig.rgb.height_px=90",
                   "rig.rgb_right.width_px=160", "rig.rgb_right.height_px=90"}));
}
SimulatedRun run_of_small_zed() {
  return simulate(small_zed(), 4, 0,
                  {.depth = true, .instance = true, .visibility = true, .disparity = true});
}

TEST(DepthCaptures, TruthIsOfBothEyesAndAgreesBetweenThem) {
  const SimulatedRun run = run_of_small_zed();
  ASSERT_EQ(sensors_with_truth(run.truth), (std::vector<std::size_t>{0, 1}));
  const TruthImages& left = run.truth.images[1];
  const TruthImages& right = run.truth.other_sensors[0].images.at(1);
  EXPECT_TRUE(right.stereo.state.empty());
  ASSERT_EQ(right.visibility.size(), left.visibility.size());
  EXPECT_NE(right.visibility[0].box_x, left.visibility[0].box_x);
  // What the left eye sees is where its disparity says in the right one, but for pixels' halves.
  int same = 0, all = 0;
  const int id = left.visibility[0].instance;
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (left.instance(x, y) != id || left.stereo.state(x, y) != PointState::visible) continue;
      const Eigen::Vector2f there =
          Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) + left.stereo.flow_px(x, y);
      ++all;
      same += right.instance(static_cast<int>(std::lround(there.x())),
                             static_cast<int>(std::lround(there.y()))) == id;
    }
  }
  EXPECT_GT(all, 20);
  EXPECT_GE(same, 0.9 * all);
  const Simulation simulation(small_zed(), 4, 0);
  EXPECT_TRUE(other_true_sensors(simulation.rig(), Streams{}, {.depth = true}).empty());
  EXPECT_EQ(other_true_sensors(simulation.rig(), {.color = true}, {.depth = true}),
            std::vector<std::size_t>{1});
}

TEST(DepthCaptures, TrueBoxesAndFilesHaveBothEyes) {
  const SimulatedRun run = run_of_small_zed();
  Stages stages;
  truth_row("boxes").put(stages, run, {});
  const Boxes boxes = stages.boxes(run.capture, {});
  ASSERT_EQ(boxes.size(), 4U);  // a sphere in two views of two eyes
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(boxes[i].id, static_cast<int>(i));
    EXPECT_EQ(boxes[i].sensor, i < 2 ? 0 : 1);
    EXPECT_EQ(boxes[i].frame, static_cast<int>(i % 2));
    const TruthImages& seen = truth_of_sensor(run.truth, i < 2 ? 0 : 1).images[i % 2];
    EXPECT_EQ(boxes[i].mask_at_px,
              Eigen::Vector2i(seen.visibility[0].seen_x, seen.visibility[0].seen_y));
  }
  const TemporaryFolder folder;
  write_truth(folder.path(), run.truth);
  const SceneTruth read = read_truth(folder.path());
  ASSERT_EQ(sensors_with_truth(read), (std::vector<std::size_t>{0, 1}));
  for (std::size_t i = 0; i < 2; ++i) {
    const TruthImages &a = read.other_sensors[0].images[i],
                      &b = run.truth.other_sensors[0].images[i];
    EXPECT_TRUE(same_bits(a.depth_m, b.depth_m));
    EXPECT_TRUE(same_bits(a.instance, b.instance));
    EXPECT_EQ(a.masks_full, b.masks_full);
  }
}

TEST(DepthCaptures, AMethodThatReadsDepthSaysWhatTheCaptureLacks) {
  const SimulatedRun run = simulate(kSmallD405, {});
  SeedsPipelineConfig pipeline;
  pipeline.method = SeedsMethod::sensor_depth;
  const auto message = [&] {
    return refusal_of([&] { perceive(run.capture, pipeline, 1, {}, 0, {}); });
  };
  EXPECT_EQ(message(),
            "method sensor_depth reads the depth images of a depth camera; the capture has none");
  pipeline.method = SeedsMethod::depth_only;
  EXPECT_NE(message().find("the capture has none"), std::string::npos);
}

}  // namespace
}  // namespace cousin
