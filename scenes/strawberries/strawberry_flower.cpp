#include <Eigen/Geometry>
#include <cmath>

#include "scenes/strawberries/strawberry_leaf.h"
#include "sim/geometry/cube_sphere.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// A sheet that leaves the head's axis at a turn about it, rising by an angle over its plane.
OrganSurface sheet(const Vector3d& start_m, const Eigen::Matrix3d& axes, double turn_rad,
                   double rise_rad, double length_m, double curl_rad, const BladeShape& shape) {
  const Vector3d out = std::cos(turn_rad) * axes.col(0) + std::sin(turn_rad) * axes.col(1);
  const Vector3d heading = std::cos(rise_rad) * out + std::sin(rise_rad) * axes.col(2);
  const Vector3d normal = std::cos(rise_rad) * axes.col(2) - std::sin(rise_rad) * out;
  AxisGrowth growth;
  growth.start_m = start_m;
  growth.heading = heading;
  growth.length_m = length_m;
  growth.radius_base_m = growth.radius_tip_m = 1e-4;
  growth.segments = 8;
  growth.curls.push_back({normal.cross(heading), curl_rad, 0});
  return blade_surface(LineWalk(grow_axis(growth), normal), shape, 10, 6);
}

void add_ball(FlowerOrgans& flower, const Vector3d& at_m, const Eigen::Matrix3d& axes,
              const Vector3d& half_m, int grid, const Rgbf& albedo) {
  OrganSurface ball;
  ball.mesh = cube_sphere(grid);
  for (Vector3d& p : ball.mesh.vertices_m) {
    ball.place.emplace_back(0.5 + 0.5 * p.z(), 0);
    p = at_m + axes * p.cwiseProduct(half_m);
  }
  add_surface(flower.middle, ball);
  flower.middle_albedo.resize(flower.middle.mesh.vertices_m.size(), albedo);
}

}  // namespace

FlowerOrgans make_strawberry_flower(const StrawberryPlantConfig& config, const Vector3d& at_m,
                                    const Vector3d& facing, Rng rng) {
  const auto& f = config.flower;
  Eigen::Matrix3d axes;
  axes.col(2) = facing.normalized();
  axes.col(0) = axes.col(2).unitOrthogonal();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  const double first_rad = uniform(rng, 0, 2 * kPi);
  const double size = truncated_normal(rng, 1, 0.08, 2);
  BladeShape petal;
  petal.width_m = 1.05 * size * f.petal_m;
  petal.envelope_base = 0.22;
  petal.envelope_peak = 0.55;
  petal.envelope_rise = 0.7;
  petal.envelope_fall = 2.4;
  petal.envelope_tip = 0.5;
  petal.camber = 0.18;
  petal.wave_m = 0.0004;
  BladeShape sepal;
  sepal.width_m = 0.42 * size * f.sepal_m;
  sepal.envelope_base = 0.7;
  sepal.envelope_peak = 0.35;
  sepal.envelope_fall = 1.6;
  FlowerOrgans flower;
  for (int i = 0; i < 5; ++i) {
    const double turn = first_rad + 2 * kPi * i / 5 + 0.06 * normal(rng);
    petal.wave_phase_rad = uniform(rng, 0, 2 * kPi);
    // Neighbours overlap: each second one lies higher.
    const Vector3d base = at_m + (0.0006 + 0.0004 * (i % 3)) * axes.col(2);
    add_surface(flower.petals,
                sheet(base, axes, turn, 0.22 + 0.10 * normal(rng), size * f.petal_m, 0.35, petal));
    add_surface(flower.sepals, sheet(at_m, axes, turn + kPi / 5, 0.10 + 0.12 * normal(rng),
                                     size * f.sepal_m, 0.15, sepal));
  }
  const auto shade = [](const std::vector<double>& color, const std::vector<double>& base) {
    return to_rgb(color_vector(color).cwiseQuotient(color_vector(base)).cwiseMin(1.0));
  };
  add_ball(flower, at_m + 0.0015 * axes.col(2), axes, size * f.receptacle_m * Vector3d(1, 1, 0.75),
           5, shade(f.albedo_receptacle, f.albedo_receptacle));
  for (int i = 0; i < f.anthers; ++i) {
    const double turn = 2 * kPi * (i + 0.3 * uniform(rng)) / f.anthers;
    const double out_m = size * f.receptacle_m * uniform(rng, 1.05, 1.45);
    add_ball(flower,
             at_m + out_m * (std::cos(turn) * axes.col(0) + std::sin(turn) * axes.col(1)) +
                 uniform(rng, 0.0018, 0.0034) * axes.col(2),
             axes, Vector3d(0.0006, 0.0006, 0.0009), 2,
             shade(f.albedo_anther, f.albedo_receptacle));
  }
  return flower;
}

}  // namespace cousin
