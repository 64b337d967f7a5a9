#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scenes/apples/apple.h"
#include "sim/geometry/gradient_noise.h"

namespace cousin {
namespace {

Eigen::Vector3d to_vector(const std::vector<double>& rgb) { return {rgb[0], rgb[1], rgb[2]}; }

Eigen::Vector3d blend(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double share) {
  return a + std::clamp(share, 0.0, 1.0) * (b - a);
}

/// Streaks that run from stalk to calyx: narrow about the axis, long along it.
double stripe(const Eigen::Vector3d& d, int count, std::uint64_t key) {
  const double azimuth = std::atan2(d.y(), d.x());
  const double ring = count / (2 * std::numbers::pi);
  return noise3({ring * std::cos(azimuth), ring * std::sin(azimuth), 1.1 * d.z()}, key);
}

/// Share of a lenticel's colour at each vertex. They lie uniformly by area but for the calyx's
/// half, where they are smaller and half as many again.
std::vector<double> lenticels(const AppleCultivar& c, const AppleFlesh& flesh, Rng rng) {
  struct Spot {
    Eigen::Vector3d direction;
    double radius = 0;  ///< on the unit sphere
  };
  double size_m = 0;
  for (const Eigen::Vector3d& p : flesh.mesh.vertices_m) size_m = std::max(size_m, p.norm());
  std::vector<Spot> spots;
  while (static_cast<int>(spots.size()) < c.lenticels) {
    const double z = uniform(rng, -1, 1);
    if (uniform(rng) > (z < -0.2 ? 1.0 : 0.67)) continue;
    const double azimuth = uniform(rng, 0, 2 * std::numbers::pi);
    const double r = std::sqrt(1 - z * z);
    const double small = z < -0.2 ? 0.75 : 1;
    spots.push_back({{r * std::cos(azimuth), r * std::sin(azimuth), z},
                     small * truncated_normal(rng, 1, 0.3, 2) * c.lenticel_radius_m / size_m});
  }
  std::sort(spots.begin(), spots.end(),
            [](const Spot& a, const Spot& b) { return a.direction.z() < b.direction.z(); });
  std::vector<double> shares;
  for (const Eigen::Vector3d& d : flesh.directions) {
    constexpr double kReach = 0.05;
    double share = 0;
    auto spot = std::lower_bound(spots.begin(), spots.end(), d.z() - kReach,
                                 [](const Spot& s, double z) { return s.direction.z() < z; });
    for (; spot != spots.end() && spot->direction.z() < d.z() + kReach; ++spot) {
      const double off = (spot->direction - d).norm() / spot->radius;
      share = std::max(share, std::exp(-off * off));
    }
    shares.push_back(share);
  }
  return shares;
}

}  // namespace

std::vector<Rgbf> color_apple(const AppleCultivar& c, const AppleFlesh& flesh, double wanted,
                              const Eigen::Vector3d& to_sun, Rng rng) {
  const std::uint64_t key = rng();
  const double tone = truncated_normal(rng, 1, 0.06, 2);
  const Eigen::Vector3d sun = to_sun.normalized();
  const std::vector<double> spots = lenticels(c, flesh, rng.fork("lenticels"));
  std::vector<double> early;
  std::vector<double> russet;
  for (std::size_t i = 0; i < flesh.directions.size(); ++i) {
    const Eigen::Vector3d& d = flesh.directions[i];
    const double streaks = stripe(d, c.stripes, key) + 0.7 * stripe(d, 3 * c.stripes, key + 1);
    // Streaks fade into the stalk's dent; the sunny side and the shoulders redden first.
    early.push_back(0.6 * flesh.normals[i].dot(sun) + 0.25 * d.z() + c.stripe_contrast * streaks +
                    0.35 * noise3(1.7 * d, key + 2));
    const double from_stalk = std::acos(std::clamp(d.z(), -1.0, 1.0));
    russet.push_back(1 - smoothstep(0.12, 0.40, from_stalk + 0.10 * stripe(d, 40, key + 3)));
  }
  const Eigen::Vector3d ground = to_vector(c.albedo_ground);
  const Eigen::Vector3d blush = to_vector(c.albedo_blush);
  const Eigen::Vector3d red = to_vector(c.albedo_red);
  const auto skin = [&](double ripe) {
    return blend(blend(ground, blush, smoothstep(-0.5, 0.5, ripe)), red,
                 smoothstep(0.2, 1.5, ripe));
  };
  double low = -0.5;
  double high = 1.5;
  for (int i = 0; i < 40; ++i) {
    const double ripe = 0.5 * (low + high);
    const Eigen::Vector3d rgb = skin(ripe);
    (rgb[0] < kRedOverGreen * rgb[1] ? low : high) = ripe;
  }
  return color_to_share(
      flesh.mesh, early, c.colour_width, high, wanted, [&](std::size_t i, double ripe) {
        Eigen::Vector3d rgb = blend(skin(ripe), to_vector(c.albedo_lenticel), 0.75 * spots[i]);
        rgb = tone * blend(rgb, to_vector(c.albedo_russet), 0.8 * russet[i]);
        rgb = rgb.cwiseMax(0.004).cwiseMin(0.95);
        return Rgbf{static_cast<float>(rgb[0]), static_cast<float>(rgb[1]),
                    static_cast<float>(rgb[2])};
      });
}

}  // namespace cousin
