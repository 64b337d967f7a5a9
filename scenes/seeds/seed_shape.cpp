#include "scenes/seeds/seed_shape.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/harmonic_radii.h"

namespace cousin {
namespace {

/// What distinguishes this seed from its lot, besides its size.
struct Individual {
  double dent = 1, hollow = 1;  ///< factors on relief_m and groove_m
  Eigen::Vector2d bow_m{0, 0};  ///< of the long axis, along y and z
  double slant = 0;             ///< the crown leans: dx/dy
  double skew = 0;              ///< the width's maximum shifts sideways
  double taper = 0;             ///< change of height from -y to +y
  std::uint64_t key = 0;
};

Individual draw_individual(const CultivarConfig& c, Rng& rng) {
  Individual seed;
  seed.dent = truncated_normal(rng, 1, c.relief_spread, 2);
  seed.hollow = truncated_normal(rng, 1, c.groove_spread, 2);
  const bool rice = c.species == Species::rice;
  const double bow_y =
      truncated_normal(rng, rice ? -c.bend_m : 0, rice ? c.bend_m / 2 : c.bend_m, 2);
  seed.bow_m = {bow_y, truncated_normal(rng, 0, rice ? c.bend_m / 4 : c.bend_m / 2, 2)};
  seed.slant = truncated_normal(rng, 0, c.slant, 2);
  seed.skew = truncated_normal(rng, 0, c.skew, 2);
  seed.taper = truncated_normal(rng, 0, c.taper, 2);
  seed.key = rng();
  return seed;
}

/// Catmull-Rom spline through equally spaced knots over [0, 1].
double spline(const std::vector<double>& knots, double t) {
  const auto last = static_cast<int>(knots.size()) - 1;
  const double x = std::clamp(t, 0.0, 1.0) * last;
  const int i = std::min(static_cast<int>(x), last - 1);
  const double f = x - i;
  const auto k = [&](int j) { return knots[static_cast<std::size_t>(std::clamp(j, 0, last))]; };
  const double m0 = (k(i + 1) - k(i - 1)) / 2;
  const double m1 = (k(i + 2) - k(i)) / 2;
  const double f2 = f * f;
  const double f3 = f2 * f;
  return k(i) * (2 * f3 - 3 * f2 + 1) + m0 * (f3 - 2 * f2 + f) + k(i + 1) * (3 * f2 - 2 * f3) +
         m1 * (f3 - f2);
}

/// Closes an end: 0 at distance 0, 1 from `round` on, along a superellipse.
double cap(double distance, double round, double exponent) {
  if (distance >= round) return 1;
  const double t = 1 - std::max(distance, 0.0) / round;
  return std::pow(std::max(0.0, 1 - std::pow(t, exponent)), 1 / exponent);
}

/// The body without details. Inside where the superellipse of the section holds the point; p in
/// half-sizes.
bool inside_body(const CultivarConfig& c, const Eigen::Vector3d& p) {
  const double along = 0.5 * (p.x() + 1);
  if (along <= 0 || along >= 1) return false;
  const double close =
      cap(along, c.tip_round, c.tip_exponent) * cap(1 - along, c.crown_round, c.crown_exponent);
  const double half_width = close * spline(c.profile_width, along);
  const double half_height = close * spline(c.profile_height, along);
  const double y = std::abs(p.y()) / half_width;
  const double z = std::abs(p.z()) / half_height;
  if (y >= 1 || z >= 1) return false;
  return std::pow(y, c.section_exponent) + std::pow(z, c.section_exponent) < 1;
}

/// Surface point of the body in a direction from its middle, by bisection to 2^-40 of the
/// half-sizes.
Eigen::Vector3d body_point(const CultivarConfig& c, const Eigen::Vector3d& direction) {
  double low = 0;
  double high = 2;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (inside_body(c, middle * direction) ? low : high) = middle;
  }
  return 0.5 * (low + high) * direction;
}

double bump(double x, double width) { return std::exp(-(x / width) * (x / width)); }
double plateau(double x, double width) { return std::exp(-std::pow(x / width, 4)); }

// Places and widths of the details below, in shares of the half-sizes, are free: drawn after
// photographs of kernels. Their heights in metres are the cultivar's.

/// Dent of the crown and hollow over the embryo; p in half-sizes, displacement in metres.
Eigen::Vector3d maize_details(const CultivarConfig& c, const Individual& seed,
                              const Eigen::Vector3d& p, SeedSkinPoint& s) {
  const double crown = smoothstep(0.80, 0.98, s.along);
  s.relief = crown * bump(p.y(), 0.55) * bump(p.z() - 0.05, 0.36);
  const double dent_m = seed.dent * c.relief_m * s.relief;
  const double shield = plateau(s.along - 0.36, 0.25) * plateau(p.y(), 0.16 + 0.34 * s.along);
  const double face = smoothstep(0.25, 0.6, p.z());
  s.groove = face * shield;
  const double axis = 0.45 * bump(p.y(), 0.10) * plateau(s.along - 0.34, 0.19);
  const double hollow_m = seed.hollow * c.groove_m * face * (shield - axis);
  // The tip cap, the rest of the pedicel, is set off by a shallow neck.
  const double neck_m = c.neck_m * bump(s.along - 0.105, 0.03);
  const Eigen::Vector3d sideways = Eigen::Vector3d(0, p.y(), p.z()).normalized();
  return Eigen::Vector3d(-dent_m, 0, -hollow_m) - neck_m * sideways;
}

/// Crease along the belly, cheeks, embryo on the back of the tip end, blunt brush end.
Eigen::Vector3d wheat_details(const CultivarConfig& c, const Individual& seed,
                              const Eigen::Vector3d& p, SeedSkinPoint& s) {
  const double belly =
      smoothstep(0.05, 0.45, -p.z() / (0.2 + 0.8 * std::sqrt(std::max(0.0, 1 - p.x() * p.x()))));
  const double ends = smoothstep(-0.02, 0.16, s.along) * smoothstep(-0.02, 0.12, 1 - s.along);
  s.groove = belly * ends * bump(p.y(), 0.13);
  // A narrow furrow between cheeks that round off into it.
  const double crease_m =
      seed.hollow * c.groove_m * (0.65 * s.groove + 0.45 * belly * ends * bump(p.y(), 0.33));
  const double back = smoothstep(0.0, 0.4, p.z());
  const double radius = std::hypot((s.along - 0.10) / 0.13, p.y() / 0.46);
  const double embryo = back * std::exp(-std::pow(radius, 4));
  const double rim = back * bump(radius - 1.05, 0.22);
  s.relief = embryo;
  const Eigen::Vector3d outward = Eigen::Vector3d(p.x() * 0.5, p.y(), p.z()).normalized();
  const double embryo_m = seed.dent * c.relief_m * (0.45 * rim - 0.9 * embryo);
  // The back is narrower than the belly: a rounded triangle in section.
  const double narrow = -c.back_narrower * std::max(0.0, p.z()) * p.y() * 0.5 * c.width_m;
  return Eigen::Vector3d(0, narrow, crease_m) + embryo_m * outward;
}

/// Nerves and keels of the husk, the seam where lemma clasps palea, sterile lemmas at the base, the
/// apiculus.
Eigen::Vector3d rice_details(const CultivarConfig& c, const Individual& seed,
                             const Eigen::Vector3d& p, SeedSkinPoint& s) {
  const double angle =
      std::atan2(std::abs(p.z()), p.y());  // 0 at the keel of the lemma, pi at the palea's
  const double body = smoothstep(0.03, 0.2, s.along) * smoothstep(0.02, 0.22, 1 - s.along);
  const double seam_at = rice_seam_rad(s.along);
  constexpr std::array<double, 4> kNerves = {0.0, 0.82, 1.55, 2.72};
  double nerve = 0;
  for (const double at : kNerves) nerve = std::max(nerve, bump(angle - at, 0.13));
  s.groove = smoothstep(0.02, 0.12, s.along) * smoothstep(0.01, 0.10, 1 - s.along) *
             bump(angle - seam_at, 0.09);
  s.relief = body * nerve;
  // The lemma's edge stands over the palea beside the seam.
  const double edge = body * bump(angle - (seam_at - 0.22), 0.14);
  double out_m =
      seed.dent * c.relief_m * (s.relief + 0.6 * edge) - seed.hollow * c.groove_m * s.groove;
  // Tubercles stand in rows along the husk.
  out_m +=
      c.wrinkle_m * body * std::cos(26 * angle) * (0.6 + 0.4 * std::sin(150 * s.along + 4 * angle));
  const double scale =
      smoothstep(0.0, 0.05, s.along) * (1 - smoothstep(0.17, 0.24, s.along + 0.10 * p.y() * p.y()));
  out_m += c.neck_m * scale * smoothstep(0.1, 0.4, std::abs(p.z()) / (0.15 + s.along * 2.2));
  const Eigen::Vector3d outward = Eigen::Vector3d(0, p.y(), p.z()).normalized();
  const double beak = smoothstep(0.965, 1.0, s.along);
  const double stalk = smoothstep(0.965, 1.0, 1 - s.along);
  return out_m * outward +
         Eigen::Vector3d(c.beak_m[0] * beak - c.beak_m[2] * stalk, c.beak_m[1] * beak, 0);
}

/// Lopsidedness, bow, slant and taper; x in metres.
Eigen::Vector3d individualise(const CultivarConfig& c, const Individual& seed,
                              const Eigen::Vector3d& half_m, const Eigen::Vector3d& p,
                              Eigen::Vector3d x_m) {
  const double along = p.x();  // -1..1
  x_m.x() += seed.slant * x_m.y() * smoothstep(0.1, 1, along);
  x_m.y() += seed.skew * half_m.y() * (1 - along * along);
  x_m.z() *= 1 + seed.taper * p.y();
  x_m.y() += seed.bow_m.x() * (1 - along * along);
  x_m.z() += seed.bow_m.y() * (1 - along * along);
  const Eigen::Vector3d outward = p.normalized();
  const double feature_m = 0.45 * half_m.x();
  x_m += c.lump_m * noise3(x_m / feature_m, seed.key) * 1.4 * outward;
  if (c.species != Species::rice && c.wrinkle_m > 0) {
    const double where =
        c.species == Species::maize ? 0.35 + 0.65 * smoothstep(-0.2, 0.7, along) : 1;
    const Eigen::Vector3d folds(x_m.x() / 0.0026, x_m.y() / 0.0011, x_m.z() / 0.0011);
    x_m += c.wrinkle_m * where * fractal_noise3(folds, 2, seed.key ^ 0x5bd1e995U) * 1.4 * outward;
  }
  return x_m;
}

}  // namespace

double rice_seam_rad(double along) { return 2.12 + 0.12 * std::sin(std::numbers::pi * along); }

SeedShape make_seed_shape(const CultivarConfig& config, const Eigen::Vector3d& size_m, Rng rng,
                          double harmonics) {
  // Free: bumps of a fifth of the radius, down to 60 degrees across, as on a shrivelled pea.
  constexpr int kDegrees = 6;
  constexpr double kStrength = 0.9;
  const Rng other_family = rng.fork("harmonics");
  const Individual seed = draw_individual(config, rng);
  const Eigen::Vector3d half_m = 0.5 * size_m;
  SeedShape shape;
  shape.mesh = cube_sphere(config.grid);
  auto& vertices_m = shape.mesh.vertices_m;
  shape.surface.resize(vertices_m.size());
  std::vector<double> radii;
  if (harmonics > 0) radii = harmonic_radii(vertices_m, kDegrees, kStrength, other_family);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices_m.size(), 256),
                    [&](const auto& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        const Eigen::Vector3d direction = vertices_m[i];
                        const Eigen::Vector3d p = body_point(config, direction);
                        SeedSkinPoint& s = shape.surface[i];
                        s.along = 0.5 * (p.x() + 1);
                        s.across = p.y();
                        s.up = p.z();
                        Eigen::Vector3d moved_m = p.cwiseProduct(half_m);
                        switch (config.species) {
                          case Species::maize:
                            moved_m += maize_details(config, seed, p, s);
                            break;
                          case Species::wheat:
                            moved_m += wheat_details(config, seed, p, s);
                            break;
                          case Species::rice:
                            moved_m += rice_details(config, seed, p, s);
                            break;
                        }
                        vertices_m[i] = individualise(config, seed, half_m, p, moved_m);
                        if (radii.empty()) continue;
                        const Eigen::Vector3d other_m = radii[i] * direction.cwiseProduct(half_m);
                        vertices_m[i] += harmonics * (other_m - vertices_m[i]);
                      }
                    });
  return shape;
}

}  // namespace cousin
