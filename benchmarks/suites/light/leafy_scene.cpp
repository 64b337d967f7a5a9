#include "benchmarks/suites/light/leafy_scene.h"

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <utility>

#include "sim/types/pi.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

constexpr int kLeafModels = 6, kPlants = 60, kLeavesAPlant = 50, kPlantsARow = 10;

/// Blade along +x from the origin, 14 x 2 x 6 cells a side: ovate outline, folded at the midrib,
/// drooping towards the tip.
ObjectModel leaf(double length_m, double width_m, double droop, double wave, int number) {
  constexpr int kAlong = 16, kAcross = 8;
  ObjectModel model;
  model.name = "leaf_" + std::to_string(number);
  for (int i = 0; i <= kAlong; ++i) {
    const double s = static_cast<double>(i) / kAlong;
    const double half_m = 0.5 * width_m * std::pow(std::sin(kPi * std::pow(s, 0.8)), 0.8);
    const double angle = -droop * s;
    for (int j = 0; j <= kAcross; ++j) {
      const double t = 2.0 * j / kAcross - 1;
      const double lift_m = half_m * (0.35 * std::abs(t) + wave * std::sin(9 * s + 2 * t) * t * t);
      model.mesh.vertices_m.emplace_back(
          length_m * s * std::cos(0.5 * angle) - lift_m * std::sin(angle), half_m * t,
          length_m * s * std::sin(0.5 * angle) + lift_m * std::cos(angle));
    }
  }
  for (int i = 0; i < kAlong; ++i) {
    for (int j = 0; j < kAcross; ++j) {
      const auto a = static_cast<std::uint32_t>(i * (kAcross + 1) + j), b = a + kAcross + 1;
      // At base and tip a side of the cell is a point.
      if (i > 0) model.mesh.triangles.push_back({a, b, a + 1});
      if (i + 1 < kAlong) model.mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  return model;
}

/// Square of `half_m` with clods a few centimetres across.
ObjectModel soil(double half_m, Rng rng) {
  constexpr int kCells = 160;
  ObjectModel model;
  model.name = "soil";
  struct Wave {
    double kx, ky, phase, height_m;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 24; ++i) {
    const double wavelength_m = 0.04 * std::pow(10.0, uniform(rng));
    const double azimuth = uniform(rng, 0, 2 * kPi);
    const double k = 2 * kPi / wavelength_m;
    waves.push_back({k * std::cos(azimuth), k * std::sin(azimuth), uniform(rng, 0, 2 * kPi),
                     0.012 * wavelength_m});
  }
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j) {
      const double x = half_m * (2.0 * j / kCells - 1), y = half_m * (2.0 * i / kCells - 1);
      double z = 0;
      for (const Wave& w : waves) z += w.height_m * std::sin(w.kx * x + w.ky * y + w.phase);
      model.mesh.vertices_m.emplace_back(x, y, z);
    }
  }
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      const auto a = static_cast<std::uint32_t>(i * (kCells + 1) + j), b = a + kCells + 1;
      model.mesh.triangles.push_back({a, a + 1, b + 1});
      model.mesh.triangles.push_back({a, b + 1, b});
    }
  }
  return model;
}

Material leaf_material() {
  Material m;
  m.name = "leaf";
  m.kind = SurfaceKind::leaf;
  m.ior = 1;
  m.albedo = {0.09F, 0.20F, 0.035F};
  m.transmittance = {0.06F, 0.19F, 0.02F};
  m.infrared_albedo = 0.47F;
  m.infrared_transmittance = 0.45F;
  return m;
}

Material soil_material() {
  Material m;
  m.name = "soil";
  m.ior = 1;
  m.albedo = {0.17F, 0.115F, 0.07F};
  m.infrared_albedo = 0.3F;
  return m;
}

void add_plant(Scene& scene, const Eigen::Vector2d& at_m, Rng rng) {
  const double height_m = uniform(rng, 0.28, 0.42);
  double azimuth = uniform(rng, 0, 2 * kPi);
  for (int i = 0; i < kLeavesAPlant; ++i) {
    const double s = (i + 0.5) / kLeavesAPlant;
    azimuth += 2.399963 + 0.3 * normal(rng);  // the golden angle
    // Old leaves hang, young ones stand.
    const double pitch = -0.35 + 1.1 * s + 0.15 * normal(rng);
    const double roll = 0.25 * normal(rng);
    const double reach_m = 0.03 + 0.09 * (1 - s) * uniform(rng);
    Instance instance;
    instance.id = static_cast<int>(scene.instances.size()) + 1;
    instance.name = "leaf";
    instance.category = "leaf";
    instance.model = static_cast<int>(uniform_index(rng, kLeafModels));
    instance.material = 0;
    Pose& pose = instance.world_from_object;
    pose.rotation = Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()) *
                    Eigen::AngleAxisd(-pitch, Eigen::Vector3d::UnitY()) *
                    Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
    pose.translation_m = {at_m.x() + reach_m * std::cos(azimuth),
                          at_m.y() + reach_m * std::sin(azimuth), 0.04 + height_m * s};
    scene.instances.push_back(std::move(instance));
  }
}

}  // namespace

Scene leafy_scene() {
  const Rng rng(20260101);
  Scene scene;
  scene.name = "leafy";
  scene.materials = {leaf_material(), soil_material()};
  Rng shapes = rng.fork("shapes");
  for (int i = 0; i < kLeafModels; ++i) {
    const double length_m = uniform(shapes, 0.07, 0.15);
    scene.models.push_back(leaf(length_m, length_m * uniform(shapes, 0.4, 0.6),
                                uniform(shapes, 0.4, 1.3), uniform(shapes, 0.05, 0.2), i));
  }
  for (int i = 0; i < kPlants; ++i) {
    Rng plant = rng.fork("plant").fork(static_cast<std::uint64_t>(i));
    const double x = 0.3 * (i % kPlantsARow) - 1.35 + 0.03 * normal(plant);
    const double y = 0.45 * (i / kPlantsARow) - 1.125 + 0.03 * normal(plant);
    add_plant(scene, {x, y}, plant.fork("leaves"));
  }
  Instance ground;
  ground.id = static_cast<int>(scene.instances.size()) + 1;
  ground.name = ground.category = "soil";
  ground.model = static_cast<int>(scene.models.size());
  ground.material = 1;
  scene.models.push_back(soil(4, rng.fork("soil")));
  scene.instances.push_back(std::move(ground));

  ClearSky sky;
  sky.to_sun = Eigen::Vector3d(0.45, -0.5, 0.75).normalized();
  sky.turbidity = 3;
  sky.scale = 0.02;  // sunlit soil near 0.1
  scene.lights.emplace_back(sky);
  return scene;
}

TrueView leafy_view() {
  TrueView view;
  view.camera.width_px = 640;
  view.camera.height_px = 480;
  view.camera.fx_px = view.camera.fy_px = 620;
  view.camera.cx_px = 319.5;
  view.camera.cy_px = 239.5;
  view.camera_from_world = look_at({-1.9, -0.9, 1.5}, {0, 0.05, 0.1});
  view.camera_from_world_end = view.camera_from_world;
  return view;
}

}  // namespace cousin
