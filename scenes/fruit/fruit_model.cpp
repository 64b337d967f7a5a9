#include "scenes/fruit/fruit_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "sim/geometry/measure.h"
#include "sim/physics/convex_parts.h"

namespace cousin {

FruitFamily fruit_family(const std::string& name) {
  if (name == "botanical") return FruitFamily::botanical;
  if (name == "harmonics") return FruitFamily::harmonics;
  throw std::invalid_argument("family \"" + name + "\" is not one of botanical, harmonics");
}

double trait(const FruitModel& fruit, const std::string& name) {
  for (const TrueTrait& t : fruit.traits) {
    if (t.name == name) return t.value;
  }
  throw std::invalid_argument("a fruit has no trait \"" + name + "\"");
}

int maturity_of(double red_share, double medium, double high) {
  return red_share < medium ? 0 : (red_share <= high ? 1 : 2);
}

void check_maturity(double medium, double high) {
  if (medium <= high) return;
  throw std::invalid_argument("maturity_medium " + std::to_string(medium) +
                              " is above maturity_high " + std::to_string(high));
}

void set_labels(Instance& fruit, const std::string& variety, int maturity) {
  fruit.category = kMaturities.at(static_cast<std::size_t>(maturity));
  fruit.labels = {{"maturity", fruit.category}, {"variety", variety}};
}

double mean_width_m(const std::vector<Eigen::Vector3d>& points_m) {
  constexpr int kDirections = 36;
  double sum = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = std::numbers::pi * i / kDirections;
    const Eigen::Vector3d across(std::cos(angle), std::sin(angle), 0);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const Eigen::Vector3d& p : points_m) {
      low = std::min(low, p.dot(across));
      high = std::max(high, p.dot(across));
    }
    sum += high - low;
  }
  return sum / kDirections;
}

namespace {

/// Share of a triangle's area on which a linear function with these values at its corners is >= 0.
double positive_share(std::array<double, 3> f) {
  std::sort(f.begin(), f.end());
  if (f[0] >= 0) return 1;
  if (f[2] < 0) return 0;
  // The corner on the one side is cut off with both edges in proportion.
  if (f[1] >= 0) return 1 - f[0] / (f[0] - f[1]) * f[0] / (f[0] - f[2]);
  return f[2] / (f[2] - f[1]) * f[2] / (f[2] - f[0]);
}

}  // namespace

double red_share(const Mesh& mesh, const std::vector<Rgbf>& vertex_albedo) {
  double red = 0;
  double whole = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    const double area = (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).norm();
    std::array<double, 3> f{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Rgbf& c = vertex_albedo.at(t[k]);
      f[k] = static_cast<double>(c.r) - kRedOverGreen * static_cast<double>(c.g);
    }
    red += area * positive_share(f);
    whole += area;
  }
  return whole > 0 ? red / whole : 0;
}

namespace {

/// The value below which `share` of the mesh's area lies, by vertices.
double area_quantile(const Mesh& mesh, const std::vector<double>& values, double share) {
  std::vector<double> area(values.size(), 0);
  double whole = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices_m[t[0]];
    const double third = (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).norm();
    for (const std::uint32_t k : t) area[k] += third;
    whole += 3 * third;
  }
  std::vector<std::uint32_t> order(values.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return values[a] < values[b]; });
  double sum = 0;
  for (const std::uint32_t k : order) {
    sum += area[k];
    if (sum >= share * whole) return values[k];
  }
  return values[order.back()];
}

}  // namespace

std::vector<Rgbf> color_to_share(const Mesh& mesh, const std::vector<double>& early, double width,
                                 double turning, double wanted,
                                 const std::function<Rgbf(std::size_t, double)>& color) {
  const auto colors_at = [&](double front) {
    std::vector<Rgbf> colors;
    colors.reserve(early.size());
    for (std::size_t i = 0; i < early.size(); ++i)
      colors.push_back(color(i, (early[i] - front) / width));
    return colors;
  };
  const auto [least, most] = std::minmax_element(early.begin(), early.end());
  if (wanted >= 1) return colors_at(*least - (turning + 1.2) * width);
  if (wanted <= 0) return colors_at(*most - (turning - 1.2) * width);
  // Colours run straight between vertices, not ripeness, and are cut to what a surface can have:
  // two corrections of the quantile's share.
  double aim = wanted;
  std::vector<Rgbf> colors;
  for (int i = 0; i < 3; ++i) {
    colors = colors_at(area_quantile(mesh, early, 1 - aim) - turning * width);
    aim = std::clamp(aim + wanted - red_share(mesh, colors), 0.0, 1.0);
  }
  return colors;
}

Mesh tube(const std::vector<Eigen::Vector3d>& points_m, const std::vector<double>& radii_m,
          int sides) {
  if (points_m.size() < 2 || radii_m.size() != points_m.size() || sides < 3)
    throw std::invalid_argument("tube: needs at least 2 points, a radius for each, and 3 sides");
  Mesh mesh;
  const auto ring = static_cast<std::uint32_t>(sides);
  const auto last = static_cast<std::uint32_t>(points_m.size() - 1);
  Eigen::Vector3d across = (points_m[1] - points_m[0]).unitOrthogonal();
  for (std::size_t i = 0; i <= last; ++i) {
    const Eigen::Vector3d along =
        (points_m[std::min<std::size_t>(i + 1, last)] - points_m[i > 0 ? i - 1 : 0]).normalized();
    across = (across - across.dot(along) * along).normalized();  // carried along without twist
    const Eigen::Vector3d other = along.cross(across);
    for (int s = 0; s < sides; ++s) {
      const double angle = 2 * std::numbers::pi * s / sides;
      mesh.vertices_m.emplace_back(
          points_m[i] + radii_m[i] * (std::cos(angle) * across + std::sin(angle) * other));
    }
  }
  for (std::uint32_t i = 0; i < last; ++i) {
    for (std::uint32_t s = 0; s < ring; ++s) {
      const std::uint32_t a = i * ring + s;
      const std::uint32_t b = i * ring + (s + 1) % ring;
      mesh.triangles.push_back({a, b, b + ring});
      mesh.triangles.push_back({a, b + ring, a + ring});
    }
  }
  const auto first_middle = static_cast<std::uint32_t>(mesh.vertices_m.size());
  mesh.vertices_m.push_back(points_m.front());
  mesh.vertices_m.push_back(points_m.back());
  for (std::uint32_t s = 0; s < ring; ++s) {
    mesh.triangles.push_back({first_middle, (s + 1) % ring, s});
    mesh.triangles.push_back({first_middle + 1, last * ring + s, last * ring + (s + 1) % ring});
  }
  return mesh;
}

Mesh contact_hull(const Mesh& flesh) {
  std::vector<Eigen::Vector3d> some;
  for (std::size_t i = 0; i < flesh.vertices_m.size(); i += 5) some.push_back(flesh.vertices_m[i]);
  const ConvexParts parts =
      convex_parts(convex_hull(some), {.max_gap_m = 2e-5, .max_parts = 1, .follow_m = 2e-4});
  return parts.hulls.at(0);
}

double cut_normal(Rng& rng, double mean, double sigma) {
  // sqrt(1 - 2 * 2 phi(2) / (2 Phi(2) - 1)) of the spread is left.
  constexpr double kCutSigma = 0.87963;
  return truncated_normal(rng, mean, sigma / kCutSigma, 2);
}

void fit_shape(Mesh& mesh, double length_over_width, double volume_m3) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Eigen::Vector3d& p : mesh.vertices_m) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  const double stretch = length_over_width * mean_width_m(mesh.vertices_m) / (high - low);
  for (Eigen::Vector3d& p : mesh.vertices_m) p.z() *= stretch;
  const MassProperties mass = mass_properties(mesh);
  const double scale = std::cbrt(volume_m3 / mass.volume_m3);
  for (Eigen::Vector3d& p : mesh.vertices_m) p = scale * (p - mass.centroid_m);
}

std::vector<TrueTrait> fruit_traits(const Mesh& flesh, double red, double mass_kg) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Eigen::Vector3d& p : flesh.vertices_m) {
    low = std::min(low, p.z());
    high = std::max(high, p.z());
  }
  const MassProperties mass = mass_properties(flesh);
  return {{"length", "m", high - low},      {"diameter", "m", mean_width_m(flesh.vertices_m)},
          {"volume", "m3", mass.volume_m3}, {"area", "m2", mass.area_m2},
          {"red_share", "1", red},          {"mass", "kg", mass_kg}};
}

}  // namespace cousin
