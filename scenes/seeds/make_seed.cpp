#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/seeds/seed_color.h"
#include "scenes/seeds/seed_parts.h"
#include "scenes/seeds/seed_shape.h"
#include "scenes/seeds/specimen.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/smooth_normals.h"

namespace cousin {
namespace {

/// Stretches the mesh so that its extents along the seed's own axes are the size drawn: what a
/// caliper laid along the seed reads. The minimum-volume box of a wedge may lie a few degrees off
/// those axes, so the box's traits differ a little.
void fit_extents(Mesh& mesh, const Eigen::Vector3d& size_m) {
  Eigen::AlignedBox3d extents;
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) extents.extend(vertex);
  const Eigen::Vector3d factor = size_m.cwiseQuotient(extents.sizes());
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex = vertex.cwiseProduct(factor);
}

std::uint32_t farthest(const std::vector<Eigen::Vector3d>& points,
                       const Eigen::Vector3d& direction) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].dot(direction) > points[best].dot(direction)) best = i;
  }
  return static_cast<std::uint32_t>(best);
}

std::vector<Keypoint> seed_keypoints(const SeedShape& shape, Species species) {
  const auto& points = shape.mesh.vertices_m;
  const auto at = [&](const Eigen::Vector3d& direction) {
    return points[farthest(points, direction)];
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  std::vector<Keypoint> keypoints = {{"tip", at(-x)}, {"crown", at(x)}};
  // The embryo lies on the face +z of maize and wheat near the tip; rice hides it under the husk.
  if (species != Species::rice) {
    const double along = species == Species::maize ? 0.36 : 0.10;
    std::size_t best = 0;
    double least = 1e9;
    for (std::size_t i = 0; i < shape.surface.size(); ++i) {
      const SeedSkinPoint& s = shape.surface[i];
      if (s.up <= 0) continue;
      const double off = std::hypot(s.along - along, 0.5 * s.across);
      if (off < least) {
        least = off;
        best = i;
      }
    }
    keypoints.push_back({"embryo", points[best]});
  }
  return keypoints;
}

}  // namespace

std::vector<TrueTrait> measure_traits(const Mesh& mesh, double mass_kg) {
  const MassProperties mass = mass_properties(mesh);
  const OrientedBox box = minimum_volume_box(mesh.vertices_m);
  return {{"length", "m", box.size_m.x()},  {"width", "m", box.size_m.y()},
          {"height", "m", box.size_m.z()},  {"area", "m2", mass.area_m2},
          {"volume", "m3", mass.volume_m3}, {"mass", "kg", mass_kg}};
}

SeedModel make_specimen(const std::string& name, const Mesh& mesh, double density_kg_m3) {
  const MeshCheck check = check_watertight(mesh);
  if (!check.ok)
    throw std::runtime_error("specimen " + name + " is not a closed mesh: " + check.problem);
  const MassProperties mass = mass_properties(mesh);
  SeedModel seed;
  seed.model.name = name;
  seed.model.mesh = mesh;
  for (Eigen::Vector3d& vertex : seed.model.mesh.vertices_m) vertex -= mass.centroid_m;
  seed.model.vertex_normals = smooth_normals(seed.model.mesh);
  seed.mass_kg = density_kg_m3 * mass.volume_m3;
  seed.traits = measure_traits(seed.model.mesh, seed.mass_kg);
  return seed;
}

SeedModel make_seed(const std::string& name, SizeSpread spread, Rng rng,
                    const SeedVariation& vary) {
  const CultivarConfig config = varied(cultivar(name), vary);
  Rng size_rng = rng.fork("size");
  const Eigen::Vector3d size_m = varied_size_m(draw_size_m(config, spread, size_rng), vary);
  SeedShape shape = make_seed_shape(config, size_m, rng.fork("shape"), vary.harmonics);
  fit_extents(shape.mesh, size_m);

  const MassProperties mass = mass_properties(shape.mesh);
  for (Eigen::Vector3d& vertex : shape.mesh.vertices_m) vertex -= mass.centroid_m;
  SeedModel seed;
  seed.model.name = name;
  seed.model.vertex_albedo = color_seed(config, shape, rng.fork("color"));
  seed.model.vertex_normals = smooth_normals(shape.mesh);
  seed.model.keypoints = seed_keypoints(shape, config.species);
  seed.model.part_names = seed_part_names(config.species);
  seed.model.triangle_part = seed_parts(shape, config.species);
  seed.model.mesh = std::move(shape.mesh);
  seed.mass_kg = config.density_kg_m3 * mass.volume_m3;
  seed.traits = measure_traits(seed.model.mesh, seed.mass_kg);
  return seed;
}

}  // namespace cousin
