#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/seeds/noise.h"
#include "scenes/strawberries/strawberry.h"

namespace cousin {
namespace {

Eigen::Vector3d to_vector(const std::vector<double>& rgb) { return {rgb[0], rgb[1], rgb[2]}; }

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
      blend(to_vector(v.albedo_green), to_vector(v.albedo_white), 0.15 + wanted / 0.35);
  const auto color = [&](double front) {
    std::vector<Rgbf> colors;
    colors.reserve(early.size());
    for (std::size_t i = 0; i < early.size(); ++i) {
      const double ripe = (early[i] - front) / v.colour_width;
      Eigen::Vector3d rgb = blend(unripe, to_vector(v.albedo_blush), smoothstep(-0.6, 0.4, ripe));
      rgb = blend(rgb, to_vector(v.albedo_red), smoothstep(0.0, 1.1, ripe));
      // Deeper where ripe longest.
      rgb *= tone * (1 - 0.22 * smoothstep(1.0, 4.0, ripe)) * (1 + 0.10 * fine[i]);
      rgb = rgb.cwiseMax(0.004).cwiseMin(0.95);
      colors.push_back(
          {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])});
    }
    return colors;
  };
  const auto [least, most] = std::minmax_element(early.begin(), early.end());
  double low = *least - 3 * v.colour_width;  // all red
  double high = *most + 3 * v.colour_width;  // none
  if (wanted >= 1) return color(*least - 1.5 * v.colour_width);
  if (wanted <= 0) return color(high);
  for (int i = 0; i < 22; ++i) {
    const double front = 0.5 * (low + high);
    (red_share(flesh.mesh, color(front)) > wanted ? low : high) = front;
  }
  return color(high);
}

}  // namespace cousin
