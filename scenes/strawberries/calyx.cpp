#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/strawberries/strawberry.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

struct Blade {
  double azimuth_rad = 0;
  double length_m = 0, width_m = 0;
  double rise_begin_rad = 0, rise_end_rad = 0;  ///< over the level
  double lift_m = 0;                            ///< of its base over the flesh
  double twist_rad = 0;
};

/// Width over the widest at a share of the length: lanceolate with a drawn-out tip.
double blade_width(double t) {
  return std::pow(std::sin(kPi * std::pow(t, 0.72)), 0.8) * (1 - 0.25 * t) + 0.32 * (1 - t);
}

void add_blade(ObjectModel& model, const Blade& blade, const Eigen::Vector3d& base_m,
               const Eigen::Vector3d& tint, std::uint64_t key) {
  constexpr int kAlong = 14;
  constexpr int kAcross = 6;
  const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
  const Eigen::Vector3d out(std::cos(blade.azimuth_rad), std::sin(blade.azimuth_rad), 0);
  const Eigen::Vector3d side(-out.y(), out.x(), 0);
  Eigen::Vector3d at = base_m + blade.lift_m * Eigen::Vector3d::UnitZ();
  for (int i = 0; i <= kAlong; ++i) {
    const double t = static_cast<double>(i) / kAlong;
    const double rise = std::lerp(blade.rise_begin_rad, blade.rise_end_rad, t * t);
    const Eigen::Vector3d along = std::cos(rise) * out + std::sin(rise) * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up = -std::sin(rise) * out + std::cos(rise) * Eigen::Vector3d::UnitZ();
    const double half = 0.5 * blade.width_m * blade_width(t);
    const double turn = blade.twist_rad * t;
    const Eigen::Vector3d across = std::cos(turn) * side + std::sin(turn) * up;
    for (int k = 0; k <= kAcross; ++k) {
      const double u = 2.0 * k / kAcross - 1;
      // Folded along the midrib, a little wavy at the margins.
      const double wave =
          0.06 * blade.length_m * u * u * noise3(Eigen::Vector3d(4 * t, u, blade.azimuth_rad), key);
      model.mesh.vertices_m.emplace_back(at + half * u * across +
                                         (0.30 * half * std::abs(u) + wave) * up);
      const double vein = 1 + 0.25 * std::exp(-25 * u * u) +
                          0.12 * noise3(Eigen::Vector3d(9 * t, 3 * u, 2.0), key + 7);
      const Eigen::Vector3d rgb = (vein * tint).cwiseMin(0.9);
      model.vertex_albedo.push_back(
          {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])});
    }
    at += blade.length_m / kAlong * along;
  }
  constexpr std::uint32_t kRow = kAcross + 1;
  for (std::uint32_t i = 0; i < kAlong; ++i) {
    for (std::uint32_t k = 0; k < kAcross; ++k) {
      const std::uint32_t a = first + i * kRow + k;
      model.mesh.triangles.push_back({a, a + kRow, a + kRow + 1});
      model.mesh.triangles.push_back({a, a + kRow + 1, a + 1});
    }
  }
}

/// Moves sheets that dip into the flesh to `gap_m` above it.
void keep_off(Mesh& sheets, const StrawberryFlesh& flesh, double gap_m) {
  const auto& points = flesh.mesh.vertices_m;
  for (Eigen::Vector3d& p : sheets.vertices_m) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points.size(); i += 2) {
      if (flesh.along[i] < 0.5) continue;
      const double d = (points[i] - p).squaredNorm();
      if (d < least) {
        least = d;
        nearest = i;
      }
    }
    const double over = flesh.normals[nearest].dot(p - points[nearest]);
    if (over < gap_m) p += (gap_m - over) * flesh.normals[nearest];
  }
}

}  // namespace

ObjectModel make_calyx(const StrawberryVariety& v, const StrawberryFlesh& flesh,
                       const Eigen::Vector3d& base_m, double size, double red_share, Rng rng) {
  ObjectModel model;
  model.name = "calyx";
  const double turn = uniform(rng, 0, 2 * kPi);
  const Eigen::Vector3d green(v.albedo_sepal[0], v.albedo_sepal[1], v.albedo_sepal[2]);
  for (int i = 0; i < 2 * v.sepals; ++i) {
    Rng one = rng.fork("blade").fork(static_cast<std::uint64_t>(i));
    const bool bract = i % 2 == 1;  // narrower, between the sepals and under them
    Blade blade;
    blade.azimuth_rad = turn + kPi * i / v.sepals + 0.12 * normal(one);
    blade.length_m =
        size * v.sepal_length_m * (bract ? 0.82 : 1) * truncated_normal(one, 1, 0.12, 2);
    blade.width_m = size * v.sepal_width_m * (bract ? 0.66 : 1) * truncated_normal(one, 1, 0.12, 2);
    // They clasp the young fruit and turn back as it ripens.
    const double ripe = std::clamp(red_share, 0.0, 1.0);
    blade.rise_begin_rad = 0.12 + 0.10 * normal(one);
    blade.rise_end_rad =
        std::lerp(-0.7, v.sepal_rise_rad, ripe) + 0.28 * normal(one) - (bract ? 0.1 : 0);
    blade.lift_m = size * (bract ? 0.0004 : 0.0009);
    blade.twist_rad = 0.25 * normal(one);
    const Eigen::Vector3d tint =
        green * truncated_normal(one, bract ? 0.9 : 1, 0.10, 2) * (red_share > 0.9 ? 1 : 1.15);
    add_blade(model, blade, base_m, tint, one());
  }
  keep_off(model.mesh, flesh, 0.0003);
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

}  // namespace cousin
