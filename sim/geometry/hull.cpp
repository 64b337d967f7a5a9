#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <tuple>

#include "sim/geometry/hull_graph.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/point_set.h"
#include "sim/geometry/qhull_interop.h"

namespace cousin {
namespace geometry {
namespace {

/// Fills `beside`; false if an edge does not join exactly two triangles in opposite directions.
bool join_edges(Hull& hull) {
  struct HalfEdge {
    std::uint32_t from = 0, to = 0, triangle = 0, corner = 0;
  };
  std::vector<HalfEdge> edges;
  edges.reserve(3 * hull.triangles.size());
  for (std::uint32_t t = 0; t < hull.triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k)
      edges.push_back({hull.triangles[t][k], hull.triangles[t][(k + 1) % 3], t, k});
  }
  const auto order = [](const HalfEdge& e) {
    return std::tuple(std::min(e.from, e.to), std::max(e.from, e.to), e.from);
  };
  std::sort(edges.begin(), edges.end(),
            [&](const HalfEdge& a, const HalfEdge& b) { return order(a) < order(b); });
  hull.beside.resize(hull.triangles.size());
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    const HalfEdge& a = edges[i];
    if (i + 1 == edges.size()) return false;
    const HalfEdge& b = edges[i + 1];
    if (a.from != b.to || a.to != b.from) return false;
    if (i + 2 < edges.size() && edges[i + 2].from == a.from && edges[i + 2].to == a.to)
      return false;
    hull.beside[a.triangle][a.corner] = b.triangle;
    hull.beside[b.triangle][b.corner] = a.triangle;
  }
  return true;
}

std::optional<Hull> hull_by_qhull(std::span<const Eigen::Vector3d> points_m, const Flat& flat,
                                  const char* options) {
  // About the local origin and of unit size, so that far or tiny clouds lose no digits to Qhull's
  // tolerances.
  std::vector<double> coordinates;
  coordinates.reserve(3 * points_m.size());
  for (const Eigen::Vector3d& p : points_m) {
    const Eigen::Vector3d q = (p - flat.origin_m) / flat.extent_m;
    coordinates.insert(coordinates.end(), q.begin(), q.end());
  }
  Qhull run(std::move(coordinates), options);
  if (!run.ok()) return std::nullopt;

  qhT* qh = run.get();
  Hull hull;
  hull.origin_m = flat.origin_m;
  std::vector<std::int64_t> index_of(points_m.size(), -1);
  facetT* facet = nullptr;
  vertexT* vertex = nullptr;
  vertexT** vertexp = nullptr;
  FORALLfacets {
    std::array<std::uint32_t, 3> triangle{};
    std::size_t corner = 0;
    FOREACHvertex_(facet->vertices) {
      if (corner == 3) return std::nullopt;
      const auto id = static_cast<std::size_t>(qh_pointid(qh, vertex->point));
      if (index_of[id] < 0) {
        index_of[id] = static_cast<std::int64_t>(hull.vertices.size());
        hull.vertices.push_back(points_m[id] - flat.origin_m);
      }
      triangle[corner++] = static_cast<std::uint32_t>(index_of[id]);
    }
    if (corner != 3) return std::nullopt;
    // Qhull's top orientation is the same all over the hull; with it on, vertices run clockwise
    // seen from outside.
    if (facet->toporient ^ qh_ORIENTclock) std::swap(triangle[1], triangle[2]);
    hull.triangles.push_back(triangle);
    hull.normals.push_back(
        Eigen::Vector3d(facet->normal[0], facet->normal[1], facet->normal[2]).normalized());
  }
  if (!join_edges(hull)) return std::nullopt;
  return hull;
}

}  // namespace

Hull build_hull(std::span<const Eigen::Vector3d> points_m) {
  if (points_m.size() < 4) return {};
  const Flat flat = find_flat(points_m);
  if (flat.dimension < 3) return {};
  // Where triangulated merged facets do not close, slightly joggled input does.
  for (const char* options : {"qhull Qt Pp", "qhull QJ Pp"}) {
    if (std::optional<Hull> hull = hull_by_qhull(points_m, flat, options)) return std::move(*hull);
  }
  return {};  // flat within Qhull's own rounding
}

}  // namespace geometry

Mesh convex_hull(std::span<const Eigen::Vector3d> points_m) {
  geometry::check_points(points_m);
  geometry::Hull hull = geometry::build_hull(points_m);
  for (Eigen::Vector3d& v : hull.vertices) v += hull.origin_m;
  return {std::move(hull.vertices), std::move(hull.triangles)};
}

}  // namespace cousin
