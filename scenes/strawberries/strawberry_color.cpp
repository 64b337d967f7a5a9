#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/strawberries/strawberry.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

Eigen::Vector3d blend(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double share) {
  return a + std::clamp(share, 0.0, 1.0) * (b - a);
}

}  // namespace

std::vector<Rgbf> color_strawberry(const StrawberryVariety& v, const StrawberryFlesh& flesh,
                                   double wanted, const Eigen::Vector3d& to_sun, Rng rng) {
  const std::uint64_t key = rng();
  const double tone = truncated_normal(rng, 1, 0.06, 2);
  const Eigen::Vector3d sun = to_sun.normalized();
  double size_m = 0;
  for (const Eigen::Vector3d& p : flesh.mesh.vertices_m) size_m = std::max(size_m, p.norm());
  // How early each place ripens: the tip first, and the side to the sun.
  std::vector<double> early;
  std::vector<double> fine;
  for (std::size_t i = 0; i < flesh.mesh.vertices_m.size(); ++i) {
    const Eigen::Vector3d p = flesh.mesh.vertices_m[i] / size_m;
    early.push_back(1 - flesh.along[i] + v.sun_side * 0.5 * (flesh.normals[i].dot(sun) - 1) +
                    v.colour_noise * (noise3(2.5 * p, key) + 0.5 * noise3(9 * p, key + 1)));
    fine.push_back(fractal_noise3(14 * p, 3, key + 2));
  }
  // Before a third is red the rest goes from green to white.
  const Eigen::Vector3d unripe =
      blend(color_vector(v.albedo_green), color_vector(v.albedo_white), 0.15 + wanted / 0.35);
  const Eigen::Vector3d blush = color_vector(v.albedo_blush);
  const Eigen::Vector3d red = color_vector(v.albedo_red);
  const auto color_of = [&](double ripe) {
    const Eigen::Vector3d pale = blend(unripe, blush, smoothstep(-0.6, 0.4, ripe));
    return blend(pale, red, smoothstep(0.0, 1.1, ripe));
  };
  // Red begins where R = kRedOverGreen G.
  double low = -0.6;
  double high = 1.1;
  for (int i = 0; i < 40; ++i) {
    const double ripe = 0.5 * (low + high);
    const Eigen::Vector3d rgb = color_of(ripe);
    (rgb[0] < kRedOverGreen * rgb[1] ? low : high) = ripe;
  }
  return color_to_share(
      flesh.mesh, early, v.colour_width, high, wanted, [&](std::size_t i, double ripe) {
        // Deeper where ripe longest.
        const double depth = tone * (1 - 0.22 * smoothstep(1.0, 4.0, ripe)) * (1 + 0.10 * fine[i]);
        const Eigen::Vector3d rgb = (depth * color_of(ripe)).cwiseMax(0.004).cwiseMin(0.95);
        return Rgbf{static_cast<float>(rgb[0]), static_cast<float>(rgb[1]),
                    static_cast<float>(rgb[2])};
      });
}

}  // namespace cousin
