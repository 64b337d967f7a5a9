#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/strawberries/strawberry.h"
#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

constexpr double kGoldenAngle_rad = kPi * (3 - 2.23606797749979);

/// The outline from tip to calyx at even shares of its arc length; length about 1.
class Outline {
 public:
  Outline(const StrawberryVariety& v, double shape_index) {
    constexpr int kSteps = 2000;
    double widest = 0;
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i <= kSteps; ++i) {
      const double s = 0.5 - 0.5 * std::cos(kPi * i / kSteps);
      const double r = std::pow(s, v.taper) * std::pow(1 - std::pow(s, v.shoulder), v.closing);
      widest = std::max(widest, r);
      points.emplace_back(r, s);
    }
    for (Eigen::Vector2d& p : points) {
      p.x() *= 0.5 / shape_index / widest;
      // The shoulders roll in to where the stalk enters.
      const double in = p.x() / (v.hollow_radius / shape_index);
      if (p.y() > 0.5) p.y() -= v.hollow * std::exp(-in * in);
    }
    double arc = 0;
    std::vector<double> arcs = {0};
    for (std::size_t i = 1; i < points.size(); ++i)
      arcs.push_back(arc += (points[i] - points[i - 1]).norm());
    std::size_t k = 0;
    for (int i = 0; i <= kSteps; ++i) {
      const double at = arc * i / kSteps;
      while (k + 2 < arcs.size() && arcs[k + 1] < at) ++k;
      const double f = std::clamp((at - arcs[k]) / (arcs[k + 1] - arcs[k]), 0.0, 1.0);
      even_.push_back(points[k] + f * (points[k + 1] - points[k]));
    }
  }
  /// Radius and height at a share of the arc length.
  Eigen::Vector2d at(double share) const {
    const double x = std::clamp(share, 0.0, 1.0) * static_cast<double>(even_.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(x), even_.size() - 2);
    return even_[k] + (x - static_cast<double>(k)) * (even_[k + 1] - even_[k]);
  }

 private:
  std::vector<Eigen::Vector2d> even_;
};

/// A fruit of revolution with the individual's oval, lobes, lumps and bow.
void shape_botanical(std::vector<Eigen::Vector3d>& directions, const StrawberryVariety& v,
                     double shape_index, Rng rng) {
  const Outline outline(v, shape_index);
  const double oval = v.oval * normal(rng);
  const double oval_at = uniform(rng, 0, kPi);
  const double lobes = v.lobes * normal(rng);
  const double lobes_at = uniform(rng, 0, kPi);
  const double bend = v.bend * truncated_normal(rng, 0, 1);
  const double bend_at = uniform(rng, 0, 2 * kPi);
  const std::uint64_t key = rng();
  for (Eigen::Vector3d& p : directions) {
    const double share = std::acos(std::clamp(-p.z(), -1.0, 1.0)) / kPi;
    const double azimuth = std::atan2(p.y(), p.x());
    const Eigen::Vector2d at = outline.at(share);
    // Lobes, as of fasciated fruits, spread with the distance from the tip.
    const double section =
        1 + oval * std::cos(2 * (azimuth - oval_at)) +
        lobes * at.y() * std::cos(3 * (azimuth - lobes_at)) +
        2 * v.lumps * noise3(v.lump_frequency * p + Eigen::Vector3d(0, 0, 9), key);
    const double radius = 0.5 / shape_index;
    const double bow = bend * radius * 4 * (at.y() - at.y() * at.y());
    p = {section * at.x() * std::cos(azimuth) + bow * std::cos(bend_at),
         section * at.x() * std::sin(azimuth) + bow * std::sin(bend_at), at.y()};
  }
}

/// Where achenes sit: a spiral of the golden angle over equal shares of the area, denser to the
/// tip, none under the calyx.
std::vector<std::uint32_t> place_achenes(const std::vector<Eigen::Vector3d>& directions,
                                         const std::vector<Eigen::Vector3d>& points_m,
                                         const std::vector<double>& along, int count, Rng rng) {
  // Area over the polar angle of the directions, from the mesh.
  constexpr std::size_t kBins = 60;
  std::vector<double> weight(kBins, 0);
  double width = 0;
  for (const Eigen::Vector3d& p : points_m) width = std::max(width, p.head<2>().norm());
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const double share = std::acos(std::clamp(-directions[i].z(), -1.0, 1.0)) / kPi;
    const double r = points_m[i].head<2>().norm();
    const bool under_calyx = along[i] > 0.8 && r < 0.42 * width;
    const double sine = std::sqrt(1 - std::pow(directions[i].z(), 2)) + 1e-3;
    if (!under_calyx) {
      weight[std::min(kBins - 1, static_cast<std::size_t>(share * kBins))] +=
          r / (sine * width) * (1.35 - 0.5 * along[i]);
    }
  }
  double sum = 0;
  for (double& w : weight) w = sum += w;
  std::vector<std::uint32_t> sites;
  for (int i = 0; i < count; ++i) {
    const double target = sum * (i + 0.5) / count;
    const auto bin = static_cast<std::size_t>(
        std::lower_bound(weight.begin(), weight.end(), target) - weight.begin());
    const double before = bin > 0 ? weight[bin - 1] : 0;
    const double share =
        (static_cast<double>(bin) + (target - before) / (weight[bin] - before)) / kBins;
    const double polar = kPi * share + 0.02 * normal(rng);
    const double azimuth = i * kGoldenAngle_rad + 0.05 * normal(rng) / (0.2 + std::sin(polar));
    const Eigen::Vector3d direction(std::sin(polar) * std::cos(azimuth),
                                    std::sin(polar) * std::sin(azimuth), -std::cos(polar));
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < directions.size(); ++k) {
      if (directions[k].dot(direction) > directions[nearest].dot(direction)) nearest = k;
    }
    sites.push_back(static_cast<std::uint32_t>(nearest));
  }
  return sites;
}

std::vector<Eigen::Vector3d> normals_of(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> normals;
  for (const Eigen::Vector3f& n : smooth_normals(mesh)) normals.emplace_back(n.cast<double>());
  return normals;
}

/// Presses a dimple under every achene, by its nearest one.
void press_dimples(Mesh& mesh, const std::vector<std::uint32_t>& achenes, double depth_m,
                   double radius_m) {
  std::vector<Eigen::Vector3d> centres;
  for (const std::uint32_t a : achenes) centres.push_back(mesh.vertices_m[a]);
  const std::vector<Eigen::Vector3d> normals = normals_of(mesh);
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& c : centres)
      nearest = std::min(nearest, (c - mesh.vertices_m[i]).squaredNorm());
    mesh.vertices_m[i] -= depth_m * std::exp(-nearest / (radius_m * radius_m)) * normals[i];
  }
}

}  // namespace

StrawberryFlesh make_strawberry_flesh(const StrawberryVariety& v, FruitFamily family,
                                      double shape_index, double volume_m3, int grid, Rng rng) {
  StrawberryFlesh flesh;
  flesh.mesh = cube_sphere(grid);
  const std::vector<Eigen::Vector3d> directions = flesh.mesh.vertices_m;
  if (family == FruitFamily::botanical) {
    shape_botanical(flesh.mesh.vertices_m, v, shape_index, rng.fork("outline"));
  } else {
    const std::vector<double> radii =
        harmonic_radii(directions, 8, v.harmonics, rng.fork("harmonics"));
    for (std::size_t i = 0; i < radii.size(); ++i) flesh.mesh.vertices_m[i] *= radii[i];
  }
  fit_shape(flesh.mesh, shape_index, volume_m3);
  double low = 0;
  double high = 0;
  for (const Eigen::Vector3d& p : flesh.mesh.vertices_m) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  for (const Eigen::Vector3d& p : flesh.mesh.vertices_m) {
    flesh.along.push_back((p.z() - low) / (high - low));
    flesh.azimuth_rad.push_back(std::atan2(p.y(), p.x()));
  }
  // As many achenes on small fruits as on large ones: they are the pistils of the flower.
  flesh.achenes =
      place_achenes(directions, flesh.mesh.vertices_m, flesh.along, v.achenes, rng.fork("achenes"));
  // Dimples shrink with the fruit.
  const double size = std::cbrt(volume_m3 * v.density_kg_m3 / v.mass_kg);
  press_dimples(flesh.mesh, flesh.achenes, size * v.dimple_depth_m, size * v.dimple_radius_m);
  fit_shape(flesh.mesh, shape_index, volume_m3);
  flesh.normals = normals_of(flesh.mesh);
  return flesh;
}

}  // namespace cousin
