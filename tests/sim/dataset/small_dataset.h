#pragma once

#include <cmath>
#include <filesystem>

#include "sim/dataset/capture_io.h"
#include "sim/dataset/truth_io.h"
#include "tests/sim/dataset/sample_capture.h"

namespace cousin {

/// What a made-up dataset is like.
struct SmallDataset {
  Camera camera{.model = LensModel::pinhole,
                .width_px = 40,
                .height_px = 30,
                .fx_px = 50 + 1 / 3.0,
                .fy_px = 51 + 1 / 7.0,
                .cx_px = 19 + 1 / 3.0,
                .cy_px = 15 - 1 / 7.0,
                .distortion = {},
                .spline = {}};
  int scenes = 1;
  bool knows_poses = true;  ///< as on a turntable
  bool has_depth = false;
  bool has_truth = true;
  bool has_right =
      false;  ///< a second camera, that sees all two pixels farther right, and its truth
  bool has_labels = false;   ///< the apple is of low maturity, the zea of high, both "fuji"
  double focus_step_px = 0;  ///< that fx grows by from frame to frame
};

/// Instance ids of the pixels of a frame: a ring of 7 with a pixel of 9 in its hole, and a bar of
/// 9.
inline Image<std::int32_t> small_instances(int frame) {
  Image<std::int32_t> ids(40, 30, -1);
  for (int y = 5; y < 10; ++y) {
    for (int x = 8 + frame; x < 14 + frame; ++x) ids(x, y) = 7;
  }
  ids(10 + frame, 7) = 9;
  ids(11 + frame, 7) = -1;
  for (int y = 12; y < 30; ++y) ids(20, y) = 9;
  return ids;
}

inline Scene small_scene(int number) {
  Scene scene{.name = "seedlings", .rig = "phone", .board = "none"};
  const double size_m = 0.01 * (number + 1);
  const Mesh mesh{{{0, 0, 0}, {size_m, 0, 0}, {0, size_m / 3, 0}, {0, 0, size_m / 7}},
                  {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  scene.models = {{.name = "plant", .mesh = mesh}, {.name = "berry", .mesh = mesh}};
  scene.models[0].keypoints = {
      {"root", {0, 0, 0}}, {"node 1", {0, 0, 1e-3}}, {"tip", {0, 0, 2e-3}}};
  scene.models[1].keypoints = {{"tip", {0, 0, 0}}};
  scene.materials = {{.name = "leaf"}};
  for (const int id : {9, 7, 3}) {
    Instance instance{.id = id, .name = "i" + std::to_string(id)};
    instance.category = id == 9 ? "zea" : id == 7 ? "apple" : "pot";
    instance.is_specimen = id != 3;
    instance.model = id == 9 ? 0 : 1;
    instance.world_from_object.translation_m = {0.01 * id, 0, 0.02};
    scene.instances.push_back(instance);
  }
  return scene;
}

inline TruthImages small_labels(int frame) {
  TruthImages images;
  images.instance = small_instances(frame);
  images.visibility = {{7, 56, 28, 0.5, 8, 5, 6, 5}, {9, 19, 19, 1, 10, 7, 11, 23}};
  images.masks_full.assign(2, Image<std::uint8_t>(40, 30));
  for (std::size_t i = 0; i < images.instance.size(); ++i) {
    if (images.instance.data()[i] >= 7)
      images.masks_full[images.instance.data()[i] == 9 ? 1 : 0].data()[i] = 255;
  }
  images.keypoints = {{7, 0, PointState::visible, {9.25, 6.5}, 0.3},
                      {9, 0, PointState::occluded, {20, 29}, 0.3},
                      {9, 1, PointState::outside, {20, 99}, 0.3},
                      {9, 2, PointState::visible, {20.125, 12.25}, 0.3}};
  return images;
}

/// A scene's true views: off the reported lens and poses by a little.
inline TrueView small_view(const SmallDataset& options, int frame, Rng& rng) {
  TrueView view{.frame = frame, .time_s = frame / 3.0, .camera = options.camera};
  view.camera.fx_px += 1;
  view.camera_from_world = view.camera_from_world_end = odd_pose(rng);
  return view;
}

/// Adds the second camera to all that is of a frame.
inline void add_right(const SmallDataset& options, int frame, Rng& rng, Capture& capture,
                      SceneTruth& truth) {
  if (capture.rig.size() < 2) {
    capture.rig.push_back(
        {.name = "right", .camera = options.camera, .sensor_from_rig = odd_pose(rng)});
    truth.other_sensors.push_back({"right", {}});
  }
  SensorFrame& sensor = capture.frames.back().sensors.emplace_back();
  sensor.reported = options.camera;
  sensor.color = noise<Rgb8>(40, 30, rng.fork("right").fork(static_cast<std::uint64_t>(frame)));
  TruthImages images = small_labels(frame + 2);
  images.visibility[0].visible_fraction = 0.25;
  images.keypoints[0].pixel_px.x() += 2;
  truth.other_sensors[0].views.push_back(small_view(options, frame, rng));
  truth.other_sensors[0].images.push_back(std::move(images));
}

inline void write_small_dataset(const std::filesystem::path& folder, const SmallDataset& options) {
  for (int s = 0; s < options.scenes; ++s) {
    Rng rng(100 + static_cast<std::uint64_t>(s));
    const auto scene_dir = folder / ("00000" + std::to_string(s));
    Capture capture{.pipeline = "seedlings", .board = "none"};
    capture.rig.push_back(
        {.name = "rgb", .camera = options.camera, .sensor_from_rig = odd_pose(rng)});
    SceneTruth truth{.seed = 1, .config_toml = "", .scene = small_scene(s)};
    for (Instance& i : truth.scene.instances) {
      if (options.has_labels && i.is_specimen)
        i.labels = {{"maturity", i.id == 7 ? "low" : "high"}, {"variety", "fuji"}};
    }
    for (int f = 0; f < 2; ++f) {
      Frame frame{.id = f, .time_s = f / 3.0};
      if (options.knows_poses) frame.rig_from_world = odd_pose(rng);
      frame.sensors.resize(1);
      SensorFrame& sensor = frame.sensors[0];
      sensor.reported = options.camera;
      sensor.reported.fx_px += f * options.focus_step_px;
      sensor.color = noise<Rgb8>(40, 30, rng.fork(static_cast<std::uint64_t>(f)));
      if (options.has_depth) sensor.depth = Image<std::uint16_t>(40, 30, 1500);
      capture.frames.push_back(std::move(frame));
      truth.views.push_back(small_view(options, f, rng));
      truth.images.push_back(small_labels(f));
      if (options.has_right) add_right(options, f, rng, capture, truth);
    }
    write_capture(scene_dir, capture);
    if (options.has_truth) write_truth(scene_dir, truth);
  }
}

}  // namespace cousin
