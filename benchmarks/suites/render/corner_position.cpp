#include "benchmarks/suites/render/corner_position.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "sim/render/radiance_pass.h"
#include "sim/types/board.h"

namespace cousin {
namespace {

/// The point that all edges in a window pass through: least squares of gradient . (q - p) = 0,
/// the window's centre moving with the result.
Eigen::Vector2d saddle(const Image<Rgbf>& image, Eigen::Vector2d q) {
  constexpr double kSigma = 1.5;
  for (int step = 0; step < 30; ++step) {
    Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    const int cx = static_cast<int>(std::lround(q.x())), cy = static_cast<int>(std::lround(q.y()));
    for (int y = cy - 5; y <= cy + 5; ++y) {
      for (int x = cx - 5; x <= cx + 5; ++x) {
        const Eigen::Vector2d p(x, y);
        const Eigen::Vector2d g(0.5 * static_cast<double>(image(x + 1, y).g - image(x - 1, y).g),
                                0.5 * static_cast<double>(image(x, y + 1).g - image(x, y - 1).g));
        const double weight = std::exp(-0.5 * (p - q).squaredNorm() / (kSigma * kSigma));
        a += weight * g * g.transpose();
        b += weight * g * (g.dot(p));
      }
    }
    const Eigen::Vector2d next = a.ldlt().solve(b);
    if ((next - q).norm() < 1e-6) return next;
    q = next;
  }
  return q;
}

/// The printed square of paper, under an even sky.
Scene board_scene() {
  constexpr double kHalf_m = 0.05;
  Scene scene;
  ObjectModel paper;
  paper.name = "paper";
  paper.mesh.vertices_m = {{-kHalf_m, -kHalf_m, 0},
                           {kHalf_m, -kHalf_m, 0},
                           {kHalf_m, kHalf_m, 0},
                           {-kHalf_m, kHalf_m, 0}};
  paper.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  Material material;
  material.albedo = {0.8F, 0.8F, 0.8F};
  material.ior = 1;
  material.print = SeedBoard{};
  Instance instance;
  instance.id = 1;
  instance.name = paper.name;
  scene.models.push_back(std::move(paper));
  scene.materials.push_back(material);
  scene.instances.push_back(instance);
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  return scene;
}

/// A surface that no polynomial of radius is: waves of up to 0.02 in u.
SplineLens waves() {
  SplineLens spline{.order = 3, .columns = 14, .rows = 11, .fov_x_rad = 2.4, .delta_u = {}};
  for (int j = 0; j < spline.rows; ++j) {
    for (int i = 0; i < spline.columns; ++i) {
      spline.delta_u.push_back(0.02 * std::sin(0.9 * i + 0.4 * j));
      spline.delta_u.push_back(0.02 * std::cos(0.5 * i - 0.8 * j));
    }
  }
  return spline;
}

}  // namespace

Camera strong_lens(LensModel model, int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.model = model;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = focal_px;
  camera.fy_px = 1.01 * focal_px;
  camera.cx_px = 0.5 * (width_px - 1) + 3.3;
  camera.cy_px = 0.5 * (height_px - 1) - 2.7;
  switch (model) {
    case LensModel::pinhole:
      break;
    case LensModel::opencv5:
      camera.distortion = {-0.25, 0.08, 0.002, -0.0015, -0.01};
      break;
    case LensModel::opencv8:
      camera.distortion = {0.4, 0.1, 0.001, -0.001, 0.01, 0.6, 0.15, 0.02};
      break;
    case LensModel::opencv12:
      camera.distortion = {0.4,  0.1,  0.001, -0.001, 0.01,   0.6,
                           0.15, 0.02, 0.004, -0.002, -0.003, 0.001};
      break;
    case LensModel::kannala_brandt4:
      camera.distortion = {-0.03, 0.004, -0.002, 0.0003};
      break;
    case LensModel::splined_stereographic:
      camera.spline = waves();
      break;
  }
  return camera;
}

CornerPositions measure_corner_positions(LensModel model) {
  const Scene scene = board_scene();
  const RayScene rays(scene);
  // The lattice of the cache is coarse, as light is even here.
  const RadianceConfig config{
      .edge_samples = 144, .irradiance_samples = 16, .max_bounces = 0, .board_texel_m = 0.01};
  const IrradianceCache cache(rays, scene, config, Rng(1));
  TrueView view;
  view.camera = strong_lens(model, 240, 200, 230);
  view.camera_from_world =
      look_at({0.012, -0.02, 0.105}, {0.002, 0.003, 0}, Eigen::Vector3d::UnitY());
  Pose roll;
  roll.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitZ()));
  view.camera_from_world = roll * view.camera_from_world;
  view.camera_from_world_end = view.camera_from_world;
  const Image<Rgbf> image = render_radiance(rays, scene, cache, view, config, Rng(2));
  CornerPositions result;
  double square = 0;
  constexpr int kMargin = 10;  // the locator's window
  for (int row = 0; row < 14; ++row) {
    for (int column = 0; column < 14; ++column) {
      if (!corner_exists(SeedBoard{}, column, row)) continue;
      const auto p = project(view.camera,
                             view.camera_from_world * corner_in_world_m(SeedBoard{}, column, row));
      if (!p || p->x() < kMargin || p->y() < kMargin ||
          p->x() > view.camera.width_px - 1 - kMargin ||
          p->y() > view.camera.height_px - 1 - kMargin) {
        continue;
      }
      const Eigen::Vector2d error = saddle(image, *p) - *p;
      result.bias_px += error;
      square += error.squaredNorm();
      ++result.corners;
    }
  }
  if (result.corners == 0) {  // no number, rather than no error
    result.bias_px.setConstant(std::numeric_limits<double>::quiet_NaN());
    result.rms_px = std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  result.bias_px /= result.corners;
  result.rms_px = std::sqrt(square / (2 * result.corners));
  return result;
}

}  // namespace cousin
