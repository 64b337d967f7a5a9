#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "scenes/apples/apple.h"
#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/smooth_normals.h"

namespace cousin {
namespace {

struct Wave {
  Eigen::Vector3d direction;
  double frequency = 0, strength = 0, phase_rad = 0;
};

/// A direction uniform by area.
Eigen::Vector3d any_direction(Rng& rng) {
  const double z = uniform(rng, -1, 1);
  const double azimuth = uniform(rng, 0, 2 * std::numbers::pi);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

/// The paper's deformed sphere: radius over the undeformed one's, for a direction.
class DeformedSphere {
 public:
  DeformedSphere(const AppleCultivar& c, Rng rng) : c_(c) {
    Rng waves = rng.fork("waves");
    for (int i = 0; i < c.waves; ++i) {
      const double frequency = c.wave_frequency * (1 + c.wave_step * i);
      waves_.push_back(
          {any_direction(waves), frequency,
           c.wave_strength * truncated_normal(waves, 0, 1, 2) * c.wave_frequency / frequency,
           uniform(waves, 0, 2 * std::numbers::pi)});
    }
    Rng one = rng.fork("sides");
    const double azimuth = uniform(one, 0, 2 * std::numbers::pi);
    lopsided_ =
        c.lopsided * normal(one) *
        Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), c.lopsided_along * normal(one));
    stalk_dent_ = c.stalk_dent * truncated_normal(one, 1, c.dent_spread, 2);
    calyx_dent_ = c.calyx_dent * truncated_normal(one, 1, c.dent_spread, 2);
    lobes_ = c.calyx_lobes * truncated_normal(one, 1, c.lobes_spread, 2);
    lobes_at_rad_ = uniform(one, 0, 2 * std::numbers::pi);
    key_ = one();
  }

  double radius(const Eigen::Vector3d& d) const {
    double sum = 1 + c_.conic * d.z() + lopsided_.dot(d);
    for (const Wave& wave : waves_)
      sum += wave.strength * std::sin(wave.frequency * wave.direction.dot(d) + wave.phase_rad);
    sum += c_.roughness_share * noise3(c_.roughness_frequency * d, key_);
    const double from_stalk = std::acos(std::clamp(d.z(), -1.0, 1.0));
    const double from_calyx = std::numbers::pi - from_stalk;
    const double azimuth = std::atan2(d.y(), d.x());
    const auto bell = [](double x) { return std::exp(-x * x); };
    sum *= 1 - stalk_dent_ * bell(from_stalk / c_.stalk_dent_rad);
    sum *= 1 - calyx_dent_ * bell(from_calyx / c_.calyx_dent_rad);
    // Knobs stand about the calyx's dent, and fade up the flanks.
    sum += lobes_ * bell((from_calyx - c_.lobes_at * c_.calyx_dent_rad) / c_.lobes_rad) *
           std::cos(5 * (azimuth - lobes_at_rad_));
    return sum;
  }

 private:
  const AppleCultivar& c_;
  std::vector<Wave> waves_;
  Eigen::Vector3d lopsided_;
  double stalk_dent_ = 0, calyx_dent_ = 0, lobes_ = 0, lobes_at_rad_ = 0;
  std::uint64_t key_ = 0;
};

}  // namespace

AppleFlesh make_apple_flesh(const AppleCultivar& c, FruitFamily family, double shape_index,
                            double volume_m3, Rng rng) {
  AppleFlesh flesh;
  flesh.mesh = cube_sphere(c.grid);
  flesh.directions = flesh.mesh.vertices_m;
  if (family == FruitFamily::botanical) {
    const DeformedSphere sphere(c, rng.fork("sphere"));
    for (Eigen::Vector3d& p : flesh.mesh.vertices_m) p *= sphere.radius(p);
  } else {
    const std::vector<double> radii =
        harmonic_radii(flesh.directions, 8, c.harmonics, rng.fork("harmonics"));
    for (std::size_t i = 0; i < radii.size(); ++i) flesh.mesh.vertices_m[i] *= radii[i];
  }
  fit_shape(flesh.mesh, shape_index, volume_m3);
  for (const Eigen::Vector3f& n : smooth_normals(flesh.mesh))
    flesh.normals.emplace_back(n.cast<double>());
  return flesh;
}

}  // namespace cousin
