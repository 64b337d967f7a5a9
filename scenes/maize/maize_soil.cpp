#include "scenes/maize/maize_soil.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/lattice.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

double height_m(const MaizeConfig::Field& c, double x_m, double y_m, std::uint64_t key) {
  const Vector3d p(x_m / c.clod_scale_m, y_m / c.clod_scale_m, 0.3);
  const double clods = fractal_noise3(p, 4, key);
  const double lumps = 0.5 - 1.6 * std::abs(noise3(2.7 * p, key + 1));
  return c.clod_m * (0.8 * clods + 0.5 * lumps - 0.2);
}

/// Cells grow with the distance from the middle.
ObjectModel soil_model(const MaizeConfig::Field& c, std::uint64_t key) {
  constexpr double kStretch = 5;
  const int n = std::clamp(
      static_cast<int>(2 * c.half_m / c.cell_m * kStretch / std::sinh(kStretch)), 40, 900);
  const auto place = [&](int i) {
    return c.half_m * std::sinh(kStretch * (2.0 * i / n - 1)) / std::sinh(kStretch);
  };
  ObjectModel model;
  model.name = "soil";
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i)
      model.mesh.vertices_m.emplace_back(place(i), place(j), height_m(c, place(i), place(j), key));
  }
  const auto cells = static_cast<std::uint32_t>(n);
  add_lattice_triangles(model.mesh, 0, cells, cells);
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

/// A straw that bends over the clods: it lies on the highest points below it, more or less.
CentreLine straw_line(const MaizeConfig::Field& c, const Vector3d& middle_m, double length_m,
                      double width_m, std::uint64_t key, Rng& rng) {
  constexpr int kSegments = 8;
  double turn = uniform(rng, 0, 2 * kPi);
  const double curl = truncated_normal(rng, 0, 0.5, 2) / kSegments;
  CentreLine line;
  Vector3d p = middle_m - 0.5 * length_m * Vector3d(std::cos(turn), std::sin(turn), 0);
  for (int i = 0; i <= kSegments; ++i) {
    line.points_m.push_back(p);
    line.radii_m.push_back(0.5 * width_m);
    turn += curl;
    p += length_m / kSegments * Vector3d(std::cos(turn), std::sin(turn), 0);
  }
  std::vector<double> ground_m;
  for (const Vector3d& q : line.points_m) ground_m.push_back(height_m(c, q.x(), q.y(), key));
  const double highest_m = *std::max_element(ground_m.begin(), ground_m.end());
  for (std::size_t i = 0; i < line.points_m.size(); ++i)
    line.points_m[i].z() = 0.45 * ground_m[i] + 0.55 * highest_m + 0.001;
  return line;
}

void append(ObjectModel& model, const OrganSurface& surface, const Rgbf& albedo) {
  const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
  const Mesh& mesh = surface.mesh;
  model.mesh.vertices_m.insert(model.mesh.vertices_m.end(), mesh.vertices_m.begin(),
                               mesh.vertices_m.end());
  model.vertex_albedo.insert(model.vertex_albedo.end(), mesh.vertices_m.size(), albedo);
  for (const auto& t : mesh.triangles)
    model.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

/// A strip of a dry leaf, or one time in six a bit of stalk.
OrganSurface straw(const MaizeConfig::Field& c, std::uint64_t key, Rng rng) {
  // Evenly over the radius: half of them lie in the inner half of the reach.
  const double r = c.residue_reach_m * uniform(rng), azimuth = uniform(rng, 0, 2 * kPi);
  const Vector3d middle_m(r * std::cos(azimuth), r * std::sin(azimuth), 0);
  const double length_m = c.residue_m[0] + (c.residue_m[1] - c.residue_m[0]) * uniform(rng) *
                                               uniform(rng);  // most are short
  const double width_m =
      std::min(0.5 * length_m, uniform(rng, c.residue_width_m[0], c.residue_width_m[1]));
  const bool is_stalk = uniform(rng) < 1.0 / 6;
  CentreLine line = straw_line(c, middle_m, length_m, width_m, key, rng);
  if (is_stalk) {
    for (Vector3d& p : line.points_m) p.z() += 0.3 * width_m;
    return tube_surface(line, 8);
  }
  BladeShape shape;
  shape.width_m = width_m;
  shape.envelope_base = 0.7;
  shape.camber = uniform(rng, -0.5, 0.5);
  shape.fold_rad = uniform(rng, -0.3, 0.6);
  shape.twist_rad = truncated_normal(rng, 0, 0.6, 2);
  return blade_surface(LineWalk(std::move(line), Vector3d::UnitZ()), shape, 8, 4);
}

}  // namespace

void add_soil(Scene& scene, const MaizeConfig::Field& field, Rng rng) {
  Material soil;
  soil.name = "soil";
  soil.albedo = to_rgb(color_vector(field.albedo));
  soil.noise = NoiseTexture{to_rgb(color_vector(field.other_albedo)), 0.7 * field.clod_scale_m, 9};
  soil.ior = 1;
  soil.roughness = 1;
  soil.infrared_albedo = 0.3F;
  Instance instance;
  instance.id = 0;
  instance.name = instance.category = "soil";
  scene.models.push_back(soil_model(field, rng()));
  scene.materials.push_back(std::move(soil));
  scene.instances.push_back(std::move(instance));
}

void add_clods(Scene& scene, const MaizeConfig::Field& field, Rng rng) {
  if (field.clods == 0) return;
  Rng same = rng;
  const std::uint64_t key = same();
  const Mesh ball = cube_sphere(4);
  ObjectModel model;
  model.name = "clods";
  for (int i = 0; i < field.clods; ++i) {
    Rng own = rng.fork("clod").fork(static_cast<std::uint64_t>(i));
    const double r = field.residue_reach_m * uniform(own), azimuth = uniform(own, 0, 2 * kPi);
    const double small = uniform(own);  // most are
    const double radius_m =
        std::lerp(field.clod_radius_m[0], field.clod_radius_m[1], small * small * small);
    Vector3d at(r * std::cos(azimuth), r * std::sin(azimuth), 0);
    at.z() = height_m(field, at.x(), at.y(), key) + 0.25 * radius_m;
    const Vector3d stretch(uniform(own, 0.7, 1.3), uniform(own, 0.7, 1.3), uniform(own, 0.5, 0.9));
    const Vector3d place(own() % 997, own() % 997, 0.5);
    const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
    for (const Vector3d& p : ball.vertices_m) {
      const double bumps =
          1 + 0.6 * noise3(1.6 * p + place, key) + 0.25 * noise3(4.5 * p + place, key);
      model.mesh.vertices_m.emplace_back(at + radius_m * bumps * stretch.cwiseProduct(p));
    }
    for (const auto& t : ball.triangles)
      model.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  model.vertex_normals = smooth_normals(model.mesh);
  Instance instance;
  for (const Instance& other : scene.instances) instance.id = std::max(instance.id, other.id + 1);
  instance.name = instance.category = "clods";
  instance.model = static_cast<int>(scene.models.size());
  instance.material = scene.instances.front().material;
  scene.models.push_back(std::move(model));
  scene.instances.push_back(std::move(instance));
}

void add_residues(Scene& scene, const MaizeConfig::Field& field, Rng rng) {
  if (field.residues == 0) return;
  Rng same = rng;
  const std::uint64_t key = same();
  ObjectModel model;
  model.name = "crop residues";
  const Vector3d fresh = color_vector(field.residue_albedo),
                 old = color_vector(field.residue_old_albedo);
  for (int i = 0; i < field.residues; ++i) {
    const Rng own = rng.fork("straw").fork(static_cast<std::uint64_t>(i));
    Rng colours = own.fork("colour");
    const double age = uniform(colours), light = uniform(colours, 0.75, 1.15);
    append(model, straw(field, key, own), to_rgb(light * ((1 - age) * fresh + age * old)));
  }
  model.vertex_normals = smooth_normals(model.mesh);
  Material material;
  material.name = "straw";
  material.albedo = {1, 1, 1};  // the vertices carry the colour
  material.ior = 1.3;
  material.roughness = 0.7;
  material.infrared_albedo = 0.45F;
  Instance instance;
  for (const Instance& other : scene.instances) instance.id = std::max(instance.id, other.id + 1);
  instance.name = instance.category = "crop residues";
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  scene.models.push_back(std::move(model));
  scene.materials.push_back(std::move(material));
  scene.instances.push_back(std::move(instance));
}

}  // namespace cousin
