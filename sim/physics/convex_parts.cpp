#include "sim/physics/convex_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/measure.h"

namespace cousin {
namespace {

using Triangle = std::array<Eigen::Vector3d, 3>;

struct Plane {
  Eigen::Vector3d normal;
  double offset_m = 0;  ///< normal . x
};

/// The part of the mesh's surface in a cell of cutting planes, and its hull.
struct Piece {
  std::vector<Triangle> surface;
  std::vector<Eigen::Vector3d>
      inner;  ///< corners of the cell that lie inside the solid, where walls meet
  std::vector<Plane> walls;
  Mesh hull;
  double hull_volume_m3 = 0;
};

/// Distinct corners of a surface, and `inner`.
std::vector<Eigen::Vector3d> corners(const std::vector<Triangle>& surface,
                                     const std::vector<Eigen::Vector3d>& inner) {
  std::vector<Eigen::Vector3d> points = inner;
  points.reserve(inner.size() + 3 * surface.size());
  for (const Triangle& t : surface) points.insert(points.end(), t.begin(), t.end());
  const auto less = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(points.begin(), points.end(), less);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// The surface on the side normal . x <= offset, cut exactly at the plane.
std::vector<Triangle> clip(const std::vector<Triangle>& surface, const Plane& plane) {
  std::vector<Triangle> kept;
  for (const Triangle& t : surface) {
    std::array<Eigen::Vector3d, 4> polygon;
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d& a = t[i];
      const Eigen::Vector3d& b = t[(i + 1) % 3];
      const double da = plane.normal.dot(a) - plane.offset_m;
      const double db = plane.normal.dot(b) - plane.offset_m;
      if (da <= 0) polygon[count++] = a;
      if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
        // From the lower end always, so that both neighbours of an edge get the same point.
        polygon[count++] =
            da < db ? a + (b - a) * (da / (da - db)) : b + (a - b) * (db / (db - da));
      }
    }
    for (std::size_t i = 2; i < count; ++i)
      kept.push_back({polygon[0], polygon[i - 1], polygon[i]});
  }
  return kept;
}

void measure(Piece& piece) {
  piece.hull = convex_hull(corners(piece.surface, piece.inner));
  piece.hull_volume_m3 = piece.hull.triangles.empty() ? 0 : mass_properties(piece.hull).volume_m3;
}

/// The side of the piece with normal . x <= offset, not yet measured. Cut curves lie in the
/// surface, so the hull covers the cut faces but for corners where walls meet inside the solid:
/// those are where edges of the hull on a wall cross the plane.
Piece below(const Piece& piece, const Plane& plane, const std::vector<Triangle>& surface) {
  Piece side;
  side.surface = clip(surface, plane);
  side.walls = piece.walls;
  side.walls.push_back(plane);
  const auto height = [&](const Eigen::Vector3d& p) {
    return plane.normal.dot(p) - plane.offset_m;
  };
  for (const Eigen::Vector3d& p : piece.inner) {
    if (height(p) <= 0) side.inner.push_back(p);
  }
  constexpr double kOnWall_m = 1e-9;
  for (const auto& t : piece.hull.triangles) {
    for (std::size_t i = 0; i < 3 && !piece.walls.empty(); ++i) {
      if (t[i] > t[(i + 1) % 3]) continue;  // the neighbour has this edge the other way round
      const Eigen::Vector3d& a = piece.hull.vertices_m[t[i]];
      const Eigen::Vector3d& b = piece.hull.vertices_m[t[(i + 1) % 3]];
      if ((height(a) < 0) == (height(b) < 0)) continue;
      const Eigen::Vector3d p = a + (b - a) * (height(a) / (height(a) - height(b)));
      const bool on_wall =
          std::any_of(piece.walls.begin(), piece.walls.end(), [&](const Plane& wall) {
            return std::abs(wall.normal.dot(p) - wall.offset_m) < kOnWall_m;
          });
      if (on_wall) side.inner.push_back(p);
    }
  }
  return side;
}

Plane flipped(const Plane& plane) { return {-plane.normal, -plane.offset_m}; }

Eigen::Vector3d middle(const std::vector<Triangle>& surface) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0;
  for (const Triangle& t : surface) {
    const double a = (t[1] - t[0]).cross(t[2] - t[0]).norm();
    sum += a * (t[0] + t[1] + t[2]) / 3;
    area += a;
  }
  return sum / area;
}

/// The plane across one of the axes that takes most off a piece's hull, judged on every eighth
/// triangle: the choice of a cut needs no more, and hulls are what costs time.
struct Choice {
  Plane plane;
  double gain_m3 = 0;
};

Choice choose_cut(const Piece& piece, const Eigen::Matrix3d& axes) {
  Piece rough = piece;
  rough.surface.clear();
  for (std::size_t i = 0; i < piece.surface.size(); i += 8)
    rough.surface.push_back(piece.surface[i]);
  measure(rough);
  const Eigen::Vector3d at = middle(piece.surface);
  Choice best;
  for (int axis = 0; axis < 3; ++axis) {
    const Plane plane{axes.col(axis), axes.col(axis).dot(at)};
    Piece one = below(rough, plane, rough.surface);
    Piece other = below(rough, flipped(plane), rough.surface);
    if (one.surface.size() < 16 || other.surface.size() < 16) continue;
    measure(one);
    measure(other);
    const double gain = rough.hull_volume_m3 - one.hull_volume_m3 - other.hull_volume_m3;
    if (gain > best.gain_m3) best = {plane, gain};
  }
  return best;
}

/// For each face of a convex hull, the point farthest outside it, where that is more than
/// `limit_m`.
std::vector<std::uint32_t> farthest_outside(const std::vector<Eigen::Vector3d>& points,
                                            const Mesh& hull, double limit_m) {
  std::vector<std::uint32_t> found;
  for (const auto& t : hull.triangles) {
    const Eigen::Vector3d& a = hull.vertices_m[t[0]];
    const Eigen::Vector3d normal = (hull.vertices_m[t[1]] - a).cross(hull.vertices_m[t[2]] - a);
    if (normal.norm() < 1e-15) continue;  // m^2: a needle has no side
    const Eigen::Vector3d n = normal.normalized();
    const auto by_height = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
      return n.dot(p) < n.dot(q);
    };
    const auto top = std::max_element(points.begin(), points.end(), by_height);
    if (n.dot(*top - a) > limit_m)
      found.push_back(static_cast<std::uint32_t>(top - points.begin()));
  }
  return found;
}

/// Keeps, of a hull's corners, those farthest in some directions, then those that still stand out,
/// face by face.
Mesh thin(const Mesh& hull, double follow_m) {
  constexpr std::size_t kFew = 100;
  constexpr int kDirections = 150;
  const auto& points = hull.vertices_m;
  if (points.size() <= kFew) return hull;
  std::vector<std::uint32_t> kept;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2.0 * i + 1) / kDirections;  // Fibonacci sphere
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    const Eigen::Vector3d d(r * std::cos(angle), r * std::sin(angle), z);
    const auto by_extent = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
      return d.dot(p) < d.dot(q);
    };
    kept.push_back(static_cast<std::uint32_t>(
        std::max_element(points.begin(), points.end(), by_extent) - points.begin()));
  }
  for (;;) {
    std::sort(kept.begin(), kept.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    std::vector<Eigen::Vector3d> corners_m;
    for (const std::uint32_t k : kept) corners_m.push_back(points[k]);
    Mesh thinned = convex_hull(corners_m);
    if (thinned.triangles.empty()) return hull;
    const std::vector<std::uint32_t> more = farthest_outside(points, thinned, follow_m);
    const bool done = std::all_of(more.begin(), more.end(), [&](std::uint32_t k) {
      return std::binary_search(kept.begin(), kept.end(), k);  // outside by rounding only
    });
    if (done) return thinned;
    kept.insert(kept.end(), more.begin(), more.end());
  }
}

}  // namespace

ConvexParts convex_parts(const Mesh& mesh, const ConvexPartsConfig& config) {
  const MassProperties solid = mass_properties(mesh);
  Piece whole;
  for (const auto& t : mesh.triangles) {
    whole.surface.push_back({mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]});
  }
  measure(whole);
  if (!(solid.volume_m3 > 0) || whole.hull.triangles.empty()) {
    throw std::invalid_argument("convex_parts: the mesh encloses no volume");
  }
  const double allowed_m3 = solid.volume_m3 + config.max_gap_m * solid.area_m2;
  double hulls_m3 = whole.hull_volume_m3;
  std::vector<Piece> pieces = {std::move(whole)};
  std::vector<Choice> choices;
  Eigen::Matrix3d axes;
  while (hulls_m3 > allowed_m3 && static_cast<int>(pieces.size()) < config.max_parts) {
    if (choices.empty()) axes = minimum_volume_box(pieces[0].hull.vertices_m).axes;
    for (std::size_t i = choices.size(); i < pieces.size(); ++i)
      choices.push_back(choose_cut(pieces[i], axes));
    const auto better = [](const Choice& a, const Choice& b) { return a.gain_m3 < b.gain_m3; };
    const auto chosen = std::max_element(choices.begin(), choices.end(), better);
    if (chosen->gain_m3 <= 1e-4 * solid.volume_m3) break;
    const auto i = static_cast<std::size_t>(chosen - choices.begin());
    const Plane plane = chosen->plane;
    Piece one = below(pieces[i], plane, pieces[i].surface);
    Piece other = below(pieces[i], flipped(plane), pieces[i].surface);
    measure(one);
    measure(other);
    hulls_m3 += one.hull_volume_m3 + other.hull_volume_m3 - pieces[i].hull_volume_m3;
    pieces[i] = std::move(one);
    choices[i] = choose_cut(pieces[i], axes);
    pieces.push_back(std::move(other));
  }
  ConvexParts parts;
  parts.gap_m = (hulls_m3 - solid.volume_m3) / solid.area_m2;
  parts.excess = hulls_m3 / solid.volume_m3 - 1;
  for (const Piece& piece : pieces) parts.hulls.push_back(thin(piece.hull, config.follow_m));
  return parts;
}

}  // namespace cousin
