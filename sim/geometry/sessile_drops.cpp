#include "sim/geometry/sessile_drops.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr int kDarts = 50;

/// The mesh with what drawing places needs.
struct Host {
  const Mesh& mesh;
  std::vector<double> area_sums_m2;  ///< running, of triangles that face up enough

  Host(const Mesh& host, const Vector3d& up, double least_cosine) : mesh(host) {
    double sum = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const Vector3d normal = area_normal(i);
      const double area = normal.norm();
      if (normal.dot(up) >= least_cosine * area) sum += area;
      area_sums_m2.push_back(sum);
    }
  }

  const Vector3d& corner(std::size_t triangle, std::size_t k) const {
    return mesh.vertices_m[mesh.triangles[triangle][k]];
  }
  Vector3d area_normal(std::size_t i) const {
    return 0.5 * (corner(i, 1) - corner(i, 0)).cross(corner(i, 2) - corner(i, 0));
  }
};

/// Where a drop sits: z along the surface's normal.
struct Seat {
  Vector3d at_m;
  Eigen::Matrix3d axes;  ///< columns x, y, z
  double radius_m = 0;
};

std::optional<Seat> draw_seat(const Host& host, const SessileDropsConfig& config, Rng& rng) {
  if (host.area_sums_m2.empty() || !(host.area_sums_m2.back() > 0)) return {};
  const double at = uniform(rng) * host.area_sums_m2.back();
  const auto place = std::upper_bound(host.area_sums_m2.begin(), host.area_sums_m2.end(), at);
  const auto i = static_cast<std::size_t>(std::min(place, host.area_sums_m2.end() - 1) -
                                          host.area_sums_m2.begin());
  const double root = std::sqrt(uniform(rng)), share = uniform(rng);
  Seat seat;
  seat.at_m = (1 - root) * host.corner(i, 0) + root * (1 - share) * host.corner(i, 1) +
              root * share * host.corner(i, 2);
  const Vector3d z = host.area_normal(i).normalized();
  const Vector3d x = z.unitOrthogonal();
  seat.axes << x, z.cross(x), z;
  seat.radius_m = uniform(rng, config.radius_min_m, config.radius_max_m);
  return seat;
}

/// Height of the surface over the seat's plane at a point of it, by a line along its normal: the
/// crossing next to the plane. NaN where there is none within a radius, or it turns away.
class SurfaceAround {
 public:
  SurfaceAround(const Host& host, const Seat& seat) : host_(host), seat_(seat) {
    const double reach_m = 2 * seat.radius_m;
    for (std::size_t i = 0; i < host.mesh.triangles.size(); ++i) {
      Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
      for (std::size_t k = 0; k < 3; ++k) {
        low = low.cwiseMin(host.corner(i, k) - seat.at_m);
        high = high.cwiseMax(host.corner(i, k) - seat.at_m);
      }
      if (low.maxCoeff() <= reach_m && high.minCoeff() >= -reach_m) near_.push_back(i);
    }
  }

  double height_m(double x_m, double y_m) const {
    double best = std::numeric_limits<double>::quiet_NaN();
    for (const std::size_t i : near_) {
      std::array<Vector3d, 3> p;
      for (std::size_t k = 0; k < 3; ++k)
        p[k] = seat_.axes.transpose() * (host_.corner(i, k) - seat_.at_m);
      const Eigen::Vector2d a = p[0].head<2>(), b = p[1].head<2>(), c = p[2].head<2>();
      const auto cross = [](const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
        return u.x() * v.y() - u.y() * v.x();
      };
      const double area = cross(b - a, c - a);
      if (!(area > 0)) continue;  // turned away, or without area
      const Eigen::Vector2d q(x_m, y_m);
      const double u = cross(q - a, c - a) / area, v = cross(b - a, q - a) / area;
      if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9) continue;
      const double z = p[0].z() + u * (p[1].z() - p[0].z()) + v * (p[2].z() - p[0].z());
      if (std::abs(z) > seat_.radius_m || steep(p)) continue;
      if (!(std::abs(z) >= std::abs(best))) best = z;
    }
    return best;
  }

 private:
  static bool steep(const std::array<Vector3d, 3>& p) {
    const Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]);
    return n.z() < std::numbers::sqrt2 / 2 * n.norm();
  }

  const Host& host_;
  const Seat& seat_;
  std::vector<std::size_t> near_;
};

/// Heights of the surface under the rim, one a segment; nothing if the surface ends before it.
std::optional<std::vector<double>> rim_heights(const Host& host, const Seat& seat, int segments) {
  const SurfaceAround surface(host, seat);
  std::vector<double> heights;
  for (int k = 0; k < segments; ++k) {
    const double angle = 2 * std::numbers::pi * k / segments;
    const double z_m =
        surface.height_m(seat.radius_m * std::cos(angle), seat.radius_m * std::sin(angle));
    if (std::isnan(z_m)) return {};
    heights.push_back(z_m);
  }
  return heights;
}

/// Vertices ring by ring from the top to the rim, the rim again below the surface, and the middles.
class DropBuilder {
 public:
  DropBuilder(SessileDrops& drops, const Seat& seat, const SessileDropsConfig& config)
      : drops_(drops), seat_(seat), config_(config), first_(count()) {}

  void build(const std::vector<double>& rim_m) {
    const int rings = std::max(config_.segments / 2, 2);
    const double angle = config_.contact_angle_rad;
    const double ball_m = seat_.radius_m / std::sin(angle);
    add_vertex({0, 0, ball_m * (1 - std::cos(angle))}, Vector3d::UnitZ());
    for (int ring = 1; ring <= rings; ++ring) {
      const double share = static_cast<double>(ring) / rings, polar = share * angle;
      const double r_m = ball_m * std::sin(polar);
      const double z_m = ball_m * (std::cos(polar) - std::cos(angle));
      add_ring(r_m, std::sin(polar), std::cos(polar),
               // The cap bends with the surface: fully at the rim, not at all at the top.
               [&](std::size_t k) { return z_m + share * share * rim_m[k]; });
    }
    add_ring(seat_.radius_m, 0, -1, [&](std::size_t k) { return rim_m[k] - config_.sink_m; });
    add_vertex({0, 0, -config_.sink_m}, -Vector3d::UnitZ());
    connect(rings);
  }

 private:
  std::uint32_t count() const { return static_cast<std::uint32_t>(drops_.mesh.vertices_m.size()); }

  void add_vertex(const Vector3d& in_seat_m, const Vector3d& normal) {
    drops_.mesh.vertices_m.emplace_back(seat_.at_m + seat_.axes * in_seat_m);
    drops_.vertex_normals.emplace_back((seat_.axes * normal).cast<float>());
  }

  template <class Height>
  void add_ring(double r_m, double outward, double upward, const Height& height_m) {
    for (int k = 0; k < config_.segments; ++k) {
      const double a = 2 * std::numbers::pi * k / config_.segments;
      add_vertex({r_m * std::cos(a), r_m * std::sin(a), height_m(static_cast<std::size_t>(k))},
                 {outward * std::cos(a), outward * std::sin(a), upward});
    }
  }

  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    drops_.mesh.triangles.push_back({first_ + a, first_ + b, first_ + c});
    drops_.triangle_part.push_back(static_cast<std::uint16_t>(drops_.part_names.size()));
  }

  void connect(int rings) {
    const auto n = static_cast<std::uint32_t>(config_.segments);
    const auto all = static_cast<std::uint32_t>(rings + 1);  // and the sunk one
    const std::uint32_t bottom = 1 + all * n;
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t next = (k + 1) % n;
      add_triangle(0, 1 + k, 1 + next);
      for (std::uint32_t ring = 0; ring + 1 < all; ++ring) {
        const std::uint32_t here = 1 + ring * n, below = here + n;
        add_triangle(here + k, below + k, below + next);
        add_triangle(here + k, below + next, here + next);
      }
      add_triangle(bottom, bottom - n + next, bottom - n + k);
    }
  }

  SessileDrops& drops_;
  const Seat& seat_;
  const SessileDropsConfig& config_;
  std::uint32_t first_;
};

/// Radius of the widest circle of a drop.
double widest_m(const Seat& seat, const SessileDropsConfig& config) {
  const double angle = config.contact_angle_rad;
  return angle > std::numbers::pi / 2 ? seat.radius_m / std::sin(angle) : seat.radius_m;
}

void check_mesh(const Mesh& mesh) {
  for (const Vector3d& v : mesh.vertices_m) {
    if (!v.allFinite()) throw std::invalid_argument("sessile drops: a vertex is not finite");
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) {
      if (v >= mesh.vertices_m.size()) {
        throw std::invalid_argument("sessile drops: a triangle's index " + std::to_string(v) +
                                    " is beyond the " + std::to_string(mesh.vertices_m.size()) +
                                    " vertices");
      }
    }
  }
}

}  // namespace

void validate(const SessileDropsConfig& c) {
  const auto check = [](const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    std::ostringstream text;
    text << "sessile drops: " << name << " = " << value << " is not in [" << low << ", " << high
         << "]";
    throw std::invalid_argument(text.str());
  };
  check("count", c.count, 0, 10000);
  check("radius_max_m", c.radius_max_m, 1e-6, 1);
  check("radius_min_m", c.radius_min_m, 1e-6, c.radius_max_m);
  check("contact_angle_rad", c.contact_angle_rad, 0.05, 2.8);
  check("steepest_rad", c.steepest_rad, 0, std::numbers::pi);
  check("up's length", c.up.norm(), 1e-6, 1e6);
  check("sink_m", c.sink_m, 1e-7, 1);
  check("segments", c.segments, 6, 512);
}

SessileDrops sessile_drops(const Mesh& mesh, const SessileDropsConfig& config, const Rng& rng) {
  validate(config);
  check_mesh(mesh);
  const Host host(mesh, config.up.normalized(), std::cos(config.steepest_rad));
  SessileDrops drops;
  std::vector<Seat> seats;
  for (int i = 0; i < config.count; ++i) {
    Rng stream = rng.fork(static_cast<std::uint64_t>(i));
    for (int dart = 0; dart < kDarts; ++dart) {
      const std::optional<Seat> seat = draw_seat(host, config, stream);
      if (!seat) break;
      const bool is_free = std::all_of(seats.begin(), seats.end(), [&](const Seat& other) {
        return (seat->at_m - other.at_m).norm() >
               1.05 * (widest_m(*seat, config) + widest_m(other, config));
      });
      if (!is_free) continue;
      const auto rim_m = rim_heights(host, *seat, config.segments);
      if (!rim_m) continue;
      DropBuilder(drops, *seat, config).build(*rim_m);
      drops.part_names.push_back("drop " + std::to_string(drops.part_names.size()));
      seats.push_back(*seat);
      break;
    }
  }
  return drops;
}

}  // namespace cousin
