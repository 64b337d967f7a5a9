#include "sim/plant/organ_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/types/pi.h"

namespace cousin {
namespace {

/// 1 on a lobe, 0 in a sinus, `count` lobes between 0 and 1.
double lobed(double along, int count, double round) {
  const double wave = 0.5 - 0.5 * std::cos(2 * kPi * count * along);
  return std::pow(wave, 1 / round);
}

void require(bool holds, const char* what, double value, const char* limit) {
  if (!holds)
    throw std::invalid_argument(std::string("blade: ") + what + " = " + std::to_string(value) +
                                " " + limit);
}

/// A ring of the tube: its middle, radius and axes.
struct Ring {
  Eigen::Vector3d middle_m;
  double radius_m;
  std::size_t frame;
  double along;
};

/// Rings of the tube and of its two round caps, from base to tip; caps stand a radius out.
std::vector<Ring> rings_of(const CentreLine& line, const std::vector<Eigen::Matrix3d>& frames) {
  constexpr double kCap[] = {0.35,
                             0.75};  // rings between pole and rim, as shares of a quarter turn
  std::vector<Ring> rings;
  const std::size_t last = line.points_m.size() - 1;
  const auto cap = [&](std::size_t i, double turn, double side) {
    const double angle = 0.5 * kPi * turn, radius = line.radii_m[i];
    rings.push_back({line.points_m[i] + side * 0.5 * radius * std::cos(angle) * frames[i].col(0),
                     radius * std::sin(angle), i, side < 0 ? 0.0 : 1.0});
  };
  for (const double turn : kCap) cap(0, turn, -1);
  const double whole_m = length_m(line);
  double along_m = 0;
  for (std::size_t i = 0; i <= last; ++i) {
    if (i > 0) along_m += (line.points_m[i] - line.points_m[i - 1]).norm();
    rings.push_back({line.points_m[i], line.radii_m[i], i, along_m / whole_m});
  }
  cap(last, kCap[1], 1);
  cap(last, kCap[0], 1);
  return rings;
}

}  // namespace

OrganSurface tube_surface(const CentreLine& line, int sides) {
  if (sides < 3 || line.points_m.size() < 2 || line.radii_m.size() != line.points_m.size()) {
    throw std::invalid_argument("tube: " + std::to_string(sides) + " sides and " +
                                std::to_string(line.points_m.size()) + " points with " +
                                std::to_string(line.radii_m.size()) +
                                " radii; it needs 3 sides, 2 points and as many radii");
  }
  const std::vector<Eigen::Matrix3d> frames = frames_along(line.points_m, Eigen::Vector3d::UnitX());
  const std::vector<Ring> rings = rings_of(line, frames);
  OrganSurface tube;
  const auto add = [&](const Eigen::Vector3d& point_m, double along, double turn) {
    tube.mesh.vertices_m.push_back(point_m);
    tube.place.emplace_back(along, turn);
  };
  const auto pole = [&](std::size_t i, double side) -> Eigen::Vector3d {
    return line.points_m[i] + side * 0.5 * line.radii_m[i] * frames[i].col(0);
  };
  add(pole(0, -1), 0, 0);
  for (const Ring& ring : rings) {
    for (int k = 0; k < sides; ++k) {
      const double turn = static_cast<double>(k) / sides, angle = 2 * kPi * turn;
      const Eigen::Matrix3d& axes = frames[ring.frame];
      add(ring.middle_m +
              ring.radius_m * (std::cos(angle) * axes.col(1) + std::sin(angle) * axes.col(2)),
          ring.along, turn);
    }
  }
  add(pole(line.points_m.size() - 1, 1), 1, 0);
  const auto n = static_cast<std::uint32_t>(sides);
  const auto at = [&](std::size_t ring, std::uint32_t k) {
    return 1 + static_cast<std::uint32_t>(ring) * n + k % n;
  };
  const auto top = static_cast<std::uint32_t>(tube.mesh.vertices_m.size() - 1);
  for (std::uint32_t k = 0; k < n; ++k) {
    tube.mesh.triangles.push_back({0, at(0, k + 1), at(0, k)});
    for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring) {
      tube.mesh.triangles.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)});
      tube.mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)});
    }
    tube.mesh.triangles.push_back({top, at(rings.size() - 1, k), at(rings.size() - 1, k + 1)});
  }
  return tube;
}

void validate(const BladeShape& shape) {
  require(shape.width_m > 0 && std::isfinite(shape.width_m), "width_m", shape.width_m,
          "must be positive and finite");
  require(shape.envelope_base >= 0 && shape.envelope_base <= 1, "envelope_base",
          shape.envelope_base, "is not in [0, 1]");
  require(shape.envelope_peak > 0 && shape.envelope_peak < 1, "envelope_peak", shape.envelope_peak,
          "is not in (0, 1)");
  require(shape.lobe_depth >= 0 && shape.lobe_depth < 1, "lobe_depth", shape.lobe_depth,
          "is not in [0, 1)");
  require(shape.teeth_depth >= 0 && shape.teeth_depth < 1, "teeth_depth", shape.teeth_depth,
          "is not in [0, 1)");
}

double row_share(const BladeShape& shape, double along) {
  double share = 0;
  if (along <= shape.envelope_peak) {
    share = shape.envelope_base +
            (1 - shape.envelope_base) * std::pow(along / shape.envelope_peak, shape.envelope_rise);
  } else {
    const double beyond = (along - shape.envelope_peak) / (1 - shape.envelope_peak);
    share = std::pow(std::max(0.0, 1 - std::pow(beyond, shape.envelope_fall)), shape.envelope_tip);
  }
  if (shape.lobes > 0)
    share *= 1 - shape.lobe_depth * (1 - lobed(along, shape.lobes, shape.lobe_round));
  if (shape.teeth > 0) share *= 1 - shape.teeth_depth * (1 - lobed(along, shape.teeth, 1));
  return std::clamp(share, 0.0, 1.0);
}

std::vector<double> side_veins(const BladeShape& shape) {
  std::vector<double> veins;
  for (int k = 0; k < shape.lobes; ++k) veins.push_back((k + 0.5) / shape.lobes);
  return veins;
}

OrganSurface blade_surface(const LineWalk& midrib, const BladeShape& shape, int rows, int columns) {
  validate(shape);
  if (rows < 2 || columns < 2 || columns % 2 != 0) {
    throw std::invalid_argument("blade: " + std::to_string(rows) + " rows and " +
                                std::to_string(columns) +
                                " columns; it needs 2 rows and an even number of columns");
  }
  OrganSurface blade;
  const double whole_m = midrib.length_m();
  for (int i = 0; i <= rows; ++i) {
    const double s = static_cast<double>(i) / rows;
    const double sweep = shape.sweep_base_rad + s * (shape.sweep_tip_rad - shape.sweep_base_rad);
    // No row reaches beyond the midrib's tip: the margin would fold back to it.
    const double reach_m = (1 - s) * whole_m / std::max(std::cos(sweep), 1e-12);
    const double half_m = std::min(0.5 * shape.width_m * row_share(shape, s), reach_m);
    for (int j = 0; j <= columns; ++j) {
      const double t = 2.0 * j / columns - 1, out = std::abs(t);
      const double x_m = s * whole_m + out * half_m * std::cos(sweep);
      const double y_m = t * half_m * std::sin(sweep);
      const LinePoint axis = midrib.at_m(x_m);
      const double fold = shape.fold_rad;
      double lift_m = std::abs(y_m) * std::sin(fold) + shape.camber * out * out * half_m;
      // The margin waves; each half has its own phase.
      lift_m += shape.wave_m * out * out * std::sin(kPi * s) *
                std::sin(2 * kPi * shape.wave_count * s + shape.wave_phase_rad + (t < 0 ? 2.1 : 0));
      if (shape.lobes > 0) {
        const double between = 0.5 + 0.5 * std::cos(2 * kPi * shape.lobes * s);
        lift_m += shape.quilt_m * between * 4 * out * (1 - out);
      }
      const double twist = shape.twist_rad * x_m / whole_m;
      const Eigen::Vector3d side =
          std::cos(twist) * axis.axes.col(1) + std::sin(twist) * axis.axes.col(2);
      const Eigen::Vector3d up =
          std::cos(twist) * axis.axes.col(2) - std::sin(twist) * axis.axes.col(1);
      blade.mesh.vertices_m.emplace_back(axis.point_m + y_m * std::cos(fold) * side + lift_m * up);
      blade.place.emplace_back(s, t);
    }
  }
  const auto n = static_cast<std::uint32_t>(columns + 1);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(rows); ++i) {
    for (std::uint32_t j = 0; j + 1 < n; ++j) {
      // Diagonals mirror each other about the midrib.
      const std::uint32_t a = i * n + j, b = a + 1, c = a + n, d = c + 1;
      if (2 * j + 1 < n) {
        blade.mesh.triangles.push_back({a, c, b});
        blade.mesh.triangles.push_back({b, c, d});
      } else {
        blade.mesh.triangles.push_back({a, c, d});
        blade.mesh.triangles.push_back({a, d, b});
      }
    }
  }
  return blade;
}

double surface_area_m2(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    sum += 0.5 * (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).norm();
  }
  return sum;
}

}  // namespace cousin
