#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scenes/apples/apple_tree.h"
#include "sim/geometry/gradient_noise.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// A line with `count` times as many points, rounder than its corners.
CentreLine refined(const CentreLine& line, int count) {
  const LineWalk walk(line, Vector3d::UnitX());
  CentreLine fine;
  const int steps = count * static_cast<int>(line.points_m.size() - 1);
  for (int i = 0; i <= steps; ++i) {
    const LinePoint at = walk.at_share(static_cast<double>(i) / steps);
    fine.points_m.push_back(at.point_m);
    fine.radii_m.push_back(at.radius_m);
  }
  return fine;
}

/// A spur ends in a swollen bourse.
CentreLine with_bourse(CentreLine line, double radius_m) {
  const std::size_t last = line.radii_m.size() - 1;
  line.radii_m[last] = 0.75 * radius_m;
  if (last > 1) line.radii_m[last - 1] = radius_m;
  return line;
}

/// Bark stands out of the round tube by noise, drawn out along the axis.
void add_relief(OrganSurface& surface, const CentreLine& line, double relief_m, std::uint64_t key) {
  const LineWalk walk(line, Vector3d::UnitX());
  for (std::size_t i = 0; i < surface.mesh.vertices_m.size(); ++i) {
    Vector3d& p = surface.mesh.vertices_m[i];
    const LinePoint at = walk.at_share(surface.place[i].x());
    const Vector3d out = p - at.point_m;
    if (out.norm() < 1e-6) continue;
    const double rough = fractal_noise3({p.x() / 0.016, p.y() / 0.016, p.z() / 0.05}, 4, key);
    const double lumps = noise3(p / 0.09, key + 1);
    p += relief_m * (0.8 * rough + 0.9 * lumps) * out.normalized();
  }
}

std::string wood_name(const AppleTree& tree, std::size_t i, std::vector<int>& numbers) {
  const WoodAxis& axis = tree.wood[i];
  char name[48];
  if (axis.kind == WoodKind::trunk) return "trunk";
  const int own = numbers[i];
  if (axis.kind == WoodKind::branch) {
    std::snprintf(name, sizeof name, "branch %02d", own);
  } else {
    std::snprintf(name, sizeof name, "branch %02d %s %02d",
                  numbers[static_cast<std::size_t>(axis.parent)],
                  axis.kind == WoodKind::spur ? "spur" : "shoot", own);
  }
  return name;
}

/// Number of each axis among its parent's of its kind.
std::vector<int> number_axes(const AppleTree& tree) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < tree.wood.size(); ++i) {
    int own = 0;
    for (std::size_t k = 0; k < i; ++k) {
      own += tree.wood[k].kind == tree.wood[i].kind && tree.wood[k].parent == tree.wood[i].parent;
    }
    numbers.push_back(own);
  }
  return numbers;
}

}  // namespace

PlantModel tree_wood(const AppleTree& tree, const OrchardConfig& config, int detail, Rng rng) {
  Plant plant;
  plant.name = "apple wood";
  std::vector<int> numbers = number_axes(tree);
  const std::uint64_t key = rng();
  for (std::size_t i = 0; i < tree.wood.size(); ++i) {
    const WoodAxis& axis = tree.wood[i];
    Organ& organ =
        add_organ(plant, OrganKind::stem, wood_name(tree, i, numbers), axis.parent, numbers[i]);
    if (axis.is_pruned) continue;
    organ.line = axis.line;
    organ.look = axis.kind == WoodKind::shoot ? kAppleShootLook : kAppleBarkLook;
    switch (axis.kind) {
      case WoodKind::trunk: {
        const CentreLine line = refined(axis.line, detail ? 8 : 1);
        organ.surface = tube_surface(line, detail ? 32 : 8);
        if (detail) add_relief(organ.surface, line, config.wood.relief_m, key);
        break;
      }
      case WoodKind::branch: {
        const CentreLine line = refined(axis.line, detail ? 4 : 1);
        organ.surface = tube_surface(line, detail ? 14 : 5);
        if (detail) add_relief(organ.surface, line, 0.35 * config.wood.relief_m, key + 2);
        break;
      }
      case WoodKind::spur:
        organ.surface = tube_surface(with_bourse(axis.line, config.spur.bourse_m), detail ? 9 : 4);
        break;
      case WoodKind::shoot:
        organ.surface = tube_surface(axis.line, detail ? 8 : 4);
        break;
    }
  }
  return plant_model(plant);
}

}  // namespace cousin
