#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>

#include "sim/render/radiance_pass.h"
#include "tests/render/test_scenes.h"

namespace cousin::test {
namespace {

/// The point that all edges in a window pass through: least squares of gradient . (q - p) = 0
/// [Foerstner & Guelch 1987], the window's centre moving with the result.
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

TEST(RadiancePass, CornersAppearWhereTheyProjectThroughEveryLens) {
  Scene scene;
  Material paper = matt(0.8F);
  paper.print = SeedBoard{};
  add(scene, box({-0.05, -0.05, -0.002}, {0.05, 0.05, 0}), paper);
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  const RayScene rays(scene);
  // The lattice of the cache is coarse, as light is even here.
  const RadianceConfig config{
      .edge_samples = 144, .irradiance_samples = 16, .max_bounces = 0, .board_texel_m = 0.01};
  const IrradianceCache cache(rays, scene, config, Rng(1));
  for (const LensModel model : {LensModel::pinhole, LensModel::opencv5, LensModel::opencv8,
                                LensModel::opencv12, LensModel::kannala_brandt4}) {
    TrueView view = view_from(lens(model, 240, 200, 230), {0.012, -0.02, 0.105}, {0.002, 0.003, 0},
                              Eigen::Vector3d::UnitY());
    // Rolled, so that edges cross the pixels at all phases.
    view.camera_from_world.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitZ())) *
        view.camera_from_world.rotation;
    view.camera_from_world.translation_m =
        Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitZ()) * view.camera_from_world.translation_m;
    view.camera_from_world_end = view.camera_from_world;
    const Image<Rgbf> image = render_radiance(rays, scene, cache, view, config, Rng(2));
    Eigen::Vector2d bias = Eigen::Vector2d::Zero();
    double square = 0;
    int count = 0;
    for (int row = 0; row < 14; ++row) {
      for (int column = 0; column < 14; ++column) {
        if (!corner_exists(SeedBoard{}, column, row)) continue;
        const auto p = project(
            view.camera, view.camera_from_world * corner_in_world_m(SeedBoard{}, column, row));
        if (!p || p->x() < 10 || p->y() < 10 || p->x() > 229 || p->y() > 189) continue;
        const Eigen::Vector2d error = saddle(image, *p) - *p;
        bias += error;
        square += error.squaredNorm();
        ++count;
      }
    }
    ASSERT_GT(count, 60) << to_string(model);
    bias /= count;
    std::printf("%s: %d corners, bias %.4f %.4f px, RMS %.4f px\n",
                std::string(to_string(model)).c_str(), count, bias.x(), bias.y(),
                std::sqrt(square / (2 * count)));
    // Edges one pixel wide alias in the locator by 0.035 px a corner, of either sign: 0.003 px in
    // the mean.
    EXPECT_LT(bias.norm(), 0.02) << to_string(model);
    EXPECT_LT(std::sqrt(square / (2 * count)), 0.05) << to_string(model);
  }
}

}  // namespace
}  // namespace cousin::test
