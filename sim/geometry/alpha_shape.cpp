#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "sim/geometry/measure.h"
#include "sim/geometry/point_set.h"
#include "sim/geometry/qhull_interop.h"

namespace cousin {
namespace {

using Points = std::vector<Eigen::Vector3d>;
using Face = std::array<std::uint32_t, 3>;

struct Tetrahedron {
  std::array<std::uint32_t, 4> corners{};  ///< the last lies on the inner side of (0, 1, 2)
  unsigned cell =
      0;  ///< cospherical points make one Delaunay cell of several tetrahedra, all with its sphere
};

double six_volumes(const Points& p, const Tetrahedron& t) {
  const auto& [a, b, c, d] = t.corners;
  return (p[b] - p[a]).dot((p[c] - p[a]).cross(p[d] - p[a]));
}

/// The tetrahedron of a lower facet of the lifted hull; false if a corner is Qhull's point at
/// infinity.
bool read_facet(qhT* qh, facetT* facet, std::size_t count, Tetrahedron& out) {
  if (facet->upperdelaunay || !facet->simplicial) return false;
  std::size_t corner = 0;
  vertexT* vertex = nullptr;
  vertexT** vertexp = nullptr;
  FOREACHvertex_(facet->vertices) {
    const int id = qh_pointid(qh, vertex->point);
    if (id < 0 || static_cast<std::size_t>(id) >= count || corner == 4) return false;
    out.corners[corner++] = static_cast<std::uint32_t>(id);
  }
  // Of all facets alike, so that even the faces of flat tetrahedra are oriented like their
  // neighbours'.
  if (facet->toporient ^ qh_ORIENTclock) std::swap(out.corners[2], out.corners[3]);
  out.cell = facet->tricoplanar && facet->f.triowner ? facet->f.triowner->id : facet->id;
  return corner == 4;
}

/// Delaunay tetrahedra of points of unit extent about the origin; none if Qhull finds them flat.
/// Qbb scales the lifted coordinate; Qz adds a point at infinity, so that cospherical points have a
/// triangulation; where that fails, slightly joggled points have one.
std::vector<Tetrahedron> delaunay(const Points& points) {
  for (const char* options : {"qhull d Qbb Qz Qt Q12 Pp", "qhull d Qbb QJ Pp"}) {
    std::vector<double> coordinates;
    coordinates.reserve(3 * points.size());
    for (const Eigen::Vector3d& p : points)
      coordinates.insert(coordinates.end(), p.begin(), p.end());
    geometry::Qhull run(std::move(coordinates), options);
    if (!run.ok()) continue;
    qhT* qh = run.get();
    std::vector<Tetrahedron> result;
    facetT* facet = nullptr;
    FORALLfacets {
      Tetrahedron t;
      if (read_facet(qh, facet, points.size(), t)) result.push_back(t);
    }
    // Which of the two orientations Qhull's flag means is the same for all: positive volumes.
    double sum = 0;
    for (const Tetrahedron& t : result) sum += six_volumes(points, t);
    if (sum < 0) {
      for (Tetrahedron& t : result) std::swap(t.corners[2], t.corners[3]);
    }
    return result;
  }
  return {};
}

/// Radius of the sphere through four points; infinite for flat ones.
double circumradius(const Points& p, const Tetrahedron& t) {
  const Eigen::Vector3d& o = p[t.corners[0]];
  const Eigen::Vector3d a = p[t.corners[1]] - o, b = p[t.corners[2]] - o, c = p[t.corners[3]] - o;
  const Eigen::Vector3d numerator =
      a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b);
  const double radius = numerator.norm() / (2 * std::abs(a.dot(b.cross(c))));
  return std::isfinite(radius) ? radius : std::numeric_limits<double>::infinity();
}

/// One radius a tetrahedron. Of a cell's tetrahedra the largest gives the sphere: the others may be
/// flat (four of a grid's corners in a square), and to drop those would leave cracks inside.
std::vector<double> circumradii(const Points& points, const std::vector<Tetrahedron>& tetrahedra) {
  std::unordered_map<unsigned, std::size_t> largest;
  for (std::size_t i = 0; i < tetrahedra.size(); ++i) {
    const auto [place, fresh] = largest.try_emplace(tetrahedra[i].cell, i);
    const double now = std::abs(six_volumes(points, tetrahedra[place->second]));
    if (!fresh && std::abs(six_volumes(points, tetrahedra[i])) > now) place->second = i;
  }
  std::vector<double> radii;
  radii.reserve(tetrahedra.size());
  for (const Tetrahedron& t : tetrahedra)
    radii.push_back(circumradius(points, tetrahedra[largest[t.cell]]));
  return radii;
}

/// Faces that belong to one of the kept tetrahedra only, counter-clockwise from outside, in a fixed
/// order.
std::vector<Face> boundary_faces(const std::vector<Tetrahedron>& kept) {
  struct Side {
    Face key, face;
  };
  std::vector<Side> sides;
  sides.reserve(4 * kept.size());
  constexpr std::array<std::array<std::size_t, 3>, 4> kFaces = {
      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  for (const Tetrahedron& t : kept) {
    for (const auto& f : kFaces) {
      const Face face = {t.corners[f[0]], t.corners[f[1]], t.corners[f[2]]};
      Face key = face;
      std::sort(key.begin(), key.end());
      sides.push_back({key, face});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.key < b.key; });
  std::vector<Face> boundary;
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].key == sides[begin].key) ++end;
    if ((end - begin) % 2 == 1) boundary.push_back(sides[begin].face);
  }
  return boundary;
}

/// About the flat's origin, of unit extent, each position once, in an order that the input's does
/// not change.
Points local_points(std::span<const Eigen::Vector3d> points_m, const geometry::Flat& flat) {
  Points points;
  points.reserve(points_m.size());
  for (const Eigen::Vector3d& p : points_m) points.push_back((p - flat.origin_m) / flat.extent_m);
  std::sort(points.begin(), points.end(), [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

}  // namespace

AlphaShape alpha_shape(std::span<const Eigen::Vector3d> points_m, double alpha_m) {
  if (!(alpha_m > 0)) {
    throw std::invalid_argument("alpha_shape: alpha_m = " + std::to_string(alpha_m) +
                                ": must be positive");
  }
  AlphaShape shape;
  if (points_m.empty()) return shape;
  geometry::check_points(points_m);
  const geometry::Flat flat = geometry::find_flat(points_m);
  if (flat.dimension < 3) return shape;

  const Points points = local_points(points_m, flat);
  std::vector<Tetrahedron> kept = delaunay(points);
  const std::vector<double> radii = circumradii(points, kept);
  std::size_t count = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (radii[i] * flat.extent_m < alpha_m) kept[count++] = kept[i];
  }
  kept.resize(count);
  shape.tetrahedra = static_cast<int>(count);

  const double area_scale = flat.extent_m * flat.extent_m;
  for (const Tetrahedron& t : kept)
    shape.volume_m3 += std::abs(six_volumes(points, t)) / 6 * area_scale * flat.extent_m;
  std::vector<std::int64_t> index_of(points.size(), -1);
  for (const Face& face : boundary_faces(kept)) {
    Face triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::int64_t& index = index_of[face[k]];
      if (index < 0) {
        index = static_cast<std::int64_t>(shape.boundary.vertices_m.size());
        shape.boundary.vertices_m.push_back(flat.origin_m + flat.extent_m * points[face[k]]);
      }
      triangle[k] = static_cast<std::uint32_t>(index);
    }
    shape.boundary.triangles.push_back(triangle);
    const Eigen::Vector3d& a = points[face[0]];
    shape.area_m2 += 0.5 * area_scale * (points[face[1]] - a).cross(points[face[2]] - a).norm();
  }
  return shape;
}

}  // namespace cousin
