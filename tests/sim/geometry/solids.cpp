#include "tests/sim/geometry/solids.h"

#include <map>
#include <utility>

namespace cousin {

using Eigen::Vector3d;

Mesh box_mesh(const Vector3d& size_m) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    mesh.vertices_m.push_back(0.5 * size_m.cwiseProduct(sign));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

Mesh ellipsoid_mesh(const Vector3d& semi_axes_m, int levels) {
  Mesh mesh;
  mesh.vertices_m = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, fresh] = middles.try_emplace(
          std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices_m.size()));
      if (fresh) mesh.vertices_m.push_back((mesh.vertices_m[a] + mesh.vertices_m[b]).normalized());
      return place->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vector3d& v : mesh.vertices_m) v = v.cwiseProduct(semi_axes_m);
  return mesh;
}

Mesh tetrahedron_mesh() {
  return {{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
          {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

Eigen::Matrix3d random_rotation(Rng& rng) {
  Eigen::Quaterniond q;
  for (double& c : q.coeffs()) c = normal(rng);
  return q.normalized().toRotationMatrix();
}

std::vector<Vector3d> moved(std::vector<Vector3d> points, const Eigen::Matrix3d& rotation,
                            const Vector3d& translation) {
  for (Vector3d& p : points) p = rotation * p + translation;
  return points;
}

Mesh moved(Mesh mesh, const Eigen::Matrix3d& rotation, const Vector3d& translation) {
  mesh.vertices_m = moved(std::move(mesh.vertices_m), rotation, translation);
  return mesh;
}

std::vector<Vector3d> shuffled(std::vector<Vector3d> points, Rng rng) {
  for (std::size_t i = points.size(); i > 1; --i)
    std::swap(points[i - 1], points[uniform_index(rng, i)]);
  return points;
}

std::vector<Vector3d> random_points(int count, const Vector3d& scale, Rng rng) {
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    Vector3d p;
    for (double& c : p) c = normal(rng);
    points.push_back(p.cwiseProduct(scale));
  }
  return points;
}

std::vector<FlatCase> flat_cases() {
  const Vector3d u = Vector3d(1, 2, -1).normalized(), v = u.unitOrthogonal();
  std::vector<Vector3d> plane, line, square;
  Rng rng(17);
  for (int i = 0; i < 40; ++i) {
    const double a = normal(rng), b = normal(rng);
    plane.push_back(a * u + b * v);
    line.push_back(a * u + Vector3d(3, 2, 1));
    square.emplace_back(i % 5, i / 5, 0);
  }
  return {{"one point", {Vector3d(1, 2, 3)}},
          {"the same point often", std::vector<Vector3d>(20, Vector3d(1, 2, 3))},
          {"two points", {Vector3d(0, 0, 0), Vector3d(1, 1, 0)}},
          {"three points", {Vector3d(0, 0, 0), Vector3d(1, 1, 0), Vector3d(0, 1, 1)}},
          {"a line", line},
          {"a tilted plane", plane},
          {"a grid in a plane", square},
          {"a plane a kilometre away",
           moved(plane, Eigen::Matrix3d::Identity(), Vector3d(1000, -500, 200))}};
}

}  // namespace cousin
