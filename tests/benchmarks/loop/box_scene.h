#pragma once

#include <cmath>

#include "benchmarks/suites/stability/splat_cube.h"
#include "perception/pipelines/seeds.h"
#include "sim/dataset/truth_io.h"
#include "tests/sim/physics/solids.h"

namespace cousin {

inline constexpr double kBoxSide_m = 0.2;

/// A box on z = `foot_m`.
inline Mesh box(const Eigen::Vector3d& size_m, double foot_m) {
  Mesh mesh = box_solid(size_m);
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex.z() += foot_m + size_m.z() / 2;
  return mesh;
}

inline Instance of_model(int model, bool is_specimen) {
  Instance instance;
  instance.id = model;
  instance.name = instance.category = is_specimen ? "box" : "bench";
  instance.is_specimen = is_specimen;
  instance.model = model;
  return instance;
}

/// A box of 0.2 m on a bench of 1 m, seen by twelve cameras from above.
inline SceneTruth box_on_bench() {
  SceneTruth truth;
  truth.scene.materials.push_back({.name = "grey"});
  ObjectModel bench{.name = "bench"}, specimen{.name = "box"};
  bench.mesh = box({1, 1, 0.02}, -0.02);
  specimen.mesh = box(Eigen::Vector3d::Constant(kBoxSide_m), 0);
  truth.scene.models = {bench, specimen};
  truth.scene.instances = {of_model(0, false), of_model(1, true)};
  for (int i = 0; i < 12; ++i) {
    const double turn = 2 * M_PI * i / 12;
    TrueView view;
    view.frame = i;
    view.camera = cube_camera();
    view.camera_from_world = view.camera_from_world_end =
        look_at({1.5 * std::cos(turn), 1.5 * std::sin(turn), i % 2 == 0 ? 1.5 : 1.1}, {0, 0, 0.1});
    truth.views.push_back(view);
  }
  return truth;
}

/// True poses, and points `off_m` above the tops of bench and box and before the box's sides.
inline Estimate measured_box(const SceneTruth& truth, float off_m) {
  Estimate estimate;
  for (const TrueView& view : truth.views)
    estimate.poses.push_back({.frame = view.frame,
                              .status = PoseStatus::ok,
                              .camera_from_world = view.camera_from_world,
                              .camera = view.camera});
  const auto add = [&](float x, float y, float z) {
    CloudPoint point;
    point.position_m = {x, y, z};
    estimate.cloud.push_back(point);
  };
  constexpr float kStep_m = 0.004F;
  const auto half = static_cast<float>(kBoxSide_m / 2);
  for (float x = -0.498F; x < 0.5F; x += kStep_m) {
    for (float y = -0.498F; y < 0.5F; y += kStep_m) {
      const bool on_box = std::abs(x) < half && std::abs(y) < half;
      add(x, y, on_box ? 2 * half + off_m : off_m);
    }
  }
  for (float a = -half + kStep_m / 2; a < half; a += kStep_m) {
    for (float z = kStep_m; z < 2 * half; z += kStep_m) {
      add(a, -half - off_m, z);
      add(a, half + off_m, z);
      add(-half - off_m, a, z);
      add(half + off_m, a, z);
    }
  }
  return estimate;
}

}  // namespace cousin
