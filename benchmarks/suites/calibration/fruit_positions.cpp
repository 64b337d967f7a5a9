#include "benchmarks/suites/calibration/fruit_positions.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "benchmarks/suites/calibration/calibration_causes.h"
#include "scenes/strawberries/strawberry.h"
#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/active_stereo.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNear_m = 0.3, kFar_m = 0.6, kWall_m = 0.9;
constexpr int kFruit = 1;

/// A fruit before a wall in a dim room; the world is the rig's frame.
Scene scene_of(const FruitModel& fruit, const Vector3d& fruit_m) {
  Scene scene;
  scene.name = "fruit before a wall";
  ObjectModel wall;
  wall.name = "wall";
  constexpr double kHalf_m = 3;
  wall.mesh.vertices_m = {{-kHalf_m, -kHalf_m, 0},
                          {kHalf_m, -kHalf_m, 0},
                          {kHalf_m, kHalf_m, 0},
                          {-kHalf_m, kHalf_m, 0}};
  wall.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  Material paint;
  paint.name = "wall";
  paint.ior = 1;
  scene.models = {fruit.flesh.model, wall};
  scene.materials = {fruit.flesh.material, paint};
  // It hangs from its stalk: +z is up, which is -y of the camera.
  Instance hanging;
  hanging.id = kFruit;
  hanging.name = "fruit";
  hanging.world_from_object = {
      Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX())), fruit_m};
  Instance behind;
  behind.id = kFruit + 1;
  behind.name = "wall";
  behind.model = behind.material = 1;
  behind.world_from_object = {
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX())), {0, 0, kWall_m}};
  scene.instances = {hanging, behind};
  const Rgbf room{0.006F, 0.006F, 0.006F};
  scene.lights.emplace_back(Sky{room, room, room});
  return scene;
}

/// The fruit in the colour image: the middle of its box, and its surface's nearest point.
struct Seen {
  Vector2d box_px;
  double depth_m = 0;  ///< under the middle of the box, along the colour camera's axis
  Vector3d nearest_m;  ///< in the colour camera
};
std::optional<Seen> see_fruit(const RayScene& rays, const Scene& scene, const TrueView& view) {
  const TruthImages truth = render_truth(rays, scene, view, {.depth = true, .instance = true});
  int low_x = view.camera.width_px, low_y = view.camera.height_px, high_x = -1, high_y = -1;
  int near_x = 0, near_y = 0;
  float nearest = std::numeric_limits<float>::infinity();
  for (int y = 0; y < truth.instance.height(); ++y) {
    for (int x = 0; x < truth.instance.width(); ++x) {
      if (truth.instance(x, y) != kFruit) continue;
      low_x = std::min(low_x, x);
      high_x = std::max(high_x, x);
      low_y = std::min(low_y, y);
      high_y = std::max(high_y, y);
      if (truth.depth_m(x, y) < nearest) {
        nearest = truth.depth_m(x, y);
        near_x = x;
        near_y = y;
      }
    }
  }
  if (high_x < low_x) return std::nullopt;
  Seen seen;
  const int u = (low_x + high_x) / 2, v = (low_y + high_y) / 2;
  seen.box_px = {u, v};
  seen.depth_m = static_cast<double>(truth.depth_m(u, v));
  const auto ray = unproject(view.camera, Vector2d(near_x, near_y));
  if (!ray || truth.instance(u, v) != kFruit) return std::nullopt;
  seen.nearest_m = static_cast<double>(nearest) / ray->z() * *ray;
  return seen;
}

/// Depth in metres at a pixel; the mean of those of a 5 x 5 window that are within three
/// centimetres of its median where the pixel has none [paper, 2.6].
std::optional<double> depth_at(const Image<std::uint16_t>& depth, const Vector2d& pixel,
                               double unit_m) {
  const int u = static_cast<int>(pixel.x()), v = static_cast<int>(pixel.y());
  if (depth(u, v) != 0) return unit_m * depth(u, v);
  std::vector<double> found;
  for (int y = v - 2; y <= v + 2; ++y) {
    for (int x = u - 2; x <= u + 2; ++x) {
      if (depth.contains(x, y) && depth(x, y) != 0) found.push_back(unit_m * depth(x, y));
    }
  }
  if (found.empty()) return std::nullopt;
  std::sort(found.begin(), found.end());
  const double median = found[found.size() / 2];
  std::erase_if(found, [&](double z) { return std::abs(z - median) > 0.03; });
  double sum = 0;
  for (const double z : found) sum += z;
  return sum / static_cast<double>(found.size());
}

/// Depth as the device's format has it, of metres.
Image<std::uint16_t> as_codes(const Image<float>& depth_m, double unit_m) {
  Image<std::uint16_t> codes(depth_m.width(), depth_m.height());
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const double code = static_cast<double>(depth_m(x, y)) / unit_m;
      codes(x, y) = code > 0 && code < 65535 ? static_cast<std::uint16_t>(std::lround(code)) : 0;
    }
  }
  return codes;
}

/// What this unit reports of true depth without noise: the disparity that its imagers have, taken
/// for that of its nominal ones.
Image<float> unit_depth(const Image<float>& true_m, const ActiveStereoConfig& config,
                        const ActiveStereoUnit& unit) {
  Image<float> result(true_m.width(), true_m.height());
  const double nominal = depth_camera(config).fx_px * config.baseline_m;
  const Camera& c = unit.imager;
  for (int y = 0; y < true_m.height(); ++y) {
    for (int x = 0; x < true_m.width(); ++x) {
      const auto z = static_cast<double>(true_m(x, y));
      const Vector3d at(z * (x - c.cx_px) / c.fx_px, z * (y - c.cy_px) / c.fy_px, z);
      const Vector3d right = unit.right_from_rig * at;
      const double disparity = x - (c.fx_px * right.x() / right.z() + c.cx_px);
      result(x, y) = static_cast<float>(disparity > 0 ? nominal / disparity
                                                      : std::numeric_limits<double>::quiet_NaN());
    }
  }
  return result;
}

/// Thirty photographs of the paper's board, calibrated as it does.
Camera calibrated_lens(const Camera& truth, const Rng& rng) {
  CalibrationConfig solve;
  solve.solver = CalibrationSolver::opencv;
  const CalibrationResult found =
      calibrate(make_corner_views({truth}, {Pose{}}, strawberry_views(), rng).input, solve);
  if (found.cameras.empty())
    throw std::runtime_error("positions: no calibration of a run: " + found.reason);
  return found.cameras.front();
}

Vector3d on_ray(const Camera& lens, const Vector2d& pixel, double z_m) {
  const auto ray = unproject(lens, pixel);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return ray ? Vector3d(z_m / ray->z() * *ray) : Vector3d(kNone, kNone, kNone);
}

Vector3d by_pinhole(const Camera& lens, const Vector2d& pixel, double z_m) {
  return {z_m * (pixel.x() - lens.cx_px) / lens.fx_px, z_m * (pixel.y() - lens.cy_px) / lens.fy_px,
          z_m};
}

/// What all points of a run share.
struct PositionUnit {
  ActiveStereoConfig config;
  ActiveStereoUnit unit;
  Camera calibrated;
};

FruitPosition measure_one(const PositionUnit& of, const PositionsConfig& config, int point,
                          const Rng& rng) {
  const ActiveStereoUnit& unit = of.unit;
  Rng place = rng.fork("place");
  FruitPosition result;
  result.true_lens = unit.color;
  result.calibrated_lens = of.calibrated;
  const StrawberryConfig fruit;
  for (int attempt = 0; attempt < 100; ++attempt) {
    const double z_m =
        kNear_m + (kFar_m - kNear_m) * (point + uniform(place)) / std::max(1, config.points);
    // Where both imagers and the colour camera see it whole.
    const double x_m = z_m * uniform(place, -0.35, 0.35), y_m = z_m * uniform(place, -0.35, 0.35);
    const FruitModel model =
        make_strawberry(fruit, rng.fork("fruit").fork(static_cast<std::uint64_t>(attempt)));
    const Scene scene = scene_of(model, {x_m, y_m, z_m + 0.015});
    const RayScene rays(scene);
    TrueView view;
    view.camera = unit.color;
    view.camera_from_world = view.camera_from_world_end = unit.color_from_rig;
    const std::optional<Seen> seen = see_fruit(rays, scene, view);
    if (!seen) continue;
    const InfraredPair pair =
        render_infrared_pair(rays, scene, Pose{}, of.config, unit, rng.fork("infrared"));
    const StereoDepth depth = sense_depth(pair, of.config, unit, rng.fork("exposure"));
    const double unit_m = of.config.depth_unit_m;
    const auto aligned = [&](const Image<std::uint16_t>& codes) {
      return depth_at(register_to_color(codes, of.config, unit), seen->box_px, unit_m);
    };
    const auto z_aligned = aligned(as_codes(pair.depth_m, unit_m));
    const auto z_unit = aligned(as_codes(unit_depth(pair.depth_m, of.config, unit), unit_m));
    const auto z_measured = aligned(depth.depth);
    if (!z_aligned || !z_unit) continue;
    const double z = z_measured.value_or(std::numeric_limits<double>::quiet_NaN());
    Rng tape = rng.fork("tape");
    Vector3d off = Vector3d::Zero();
    for (int k = 0; k < config.readings; ++k) {
      for (int i = 0; i < 3; ++i) off(i) += config.tape_m * normal(tape) / config.readings;
    }
    result.has_depth = z_measured.has_value();
    result.box_px = seen->box_px;
    result.step_m = {seen->nearest_m + off,
                     seen->nearest_m,
                     on_ray(unit.color, seen->box_px, seen->depth_m),
                     on_ray(unit.color, seen->box_px, *z_aligned),
                     on_ray(unit.color, seen->box_px, *z_unit),
                     on_ray(unit.color, seen->box_px, z),
                     on_ray(of.calibrated, seen->box_px, z),
                     by_pinhole(of.calibrated, seen->box_px, z)};
    return result;
  }
  throw std::runtime_error("positions: no fruit is seen in a hundred places");
}

}  // namespace

Camera strawberry_paper_lens() {
  Camera camera{LensModel::opencv5, 640, 480, 391.365, 393.260, 309.722, 266.262, {}, {}};
  camera.distortion = {-0.034, 0.0344, 0.015, -0.006, -0.008};
  return camera;
}

std::vector<FruitPosition> measure_positions(const PositionsConfig& config, std::uint64_t seed,
                                             int run) {
  const Rng rng = Rng(seed).fork("fruit positions").fork(static_cast<std::uint64_t>(run));
  PositionUnit of;
  of.config = active_stereo_preset("d457");
  of.unit = make_active_stereo(of.config, rng.fork("unit"));
  const Eigen::AngleAxisd off(config.out_of_yaw_px / of.unit.imager.fx_px, Vector3d::UnitY());
  of.unit.right_from_rig = Pose{Eigen::Quaterniond(off), Vector3d::Zero()} * of.unit.right_from_rig;
  of.calibrated = calibrated_lens(of.unit.color, rng.fork("calibration"));
  std::vector<FruitPosition> positions(static_cast<std::size_t>(config.points));
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
    positions[i] = measure_one(of, config, static_cast<int>(i), rng.fork("point").fork(i));
  });
  return positions;
}

}  // namespace cousin
