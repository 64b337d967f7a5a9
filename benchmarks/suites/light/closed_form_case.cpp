#include "benchmarks/suites/light/closed_form_case.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace cousin::closed_form {

ObjectModel sphere(int cells, bool smooth, bool inside_out) {
  ObjectModel model;
  model.name = "sphere";
  std::map<std::array<int, 3>, std::uint32_t> places;
  const auto vertex = [&](int axis, int sign, int i, int j) {
    std::array<int, 3> key{};
    key[static_cast<std::size_t>(axis)] = sign * cells;
    key[static_cast<std::size_t>((axis + 1) % 3)] = 2 * i - cells;
    key[static_cast<std::size_t>((axis + 2) % 3)] = 2 * j - cells;
    const auto [place, is_new] =
        places.try_emplace(key, static_cast<std::uint32_t>(model.mesh.vertices_m.size()));
    if (is_new) {
      // Even angles across a face.
      Eigen::Vector3d p;
      for (std::size_t k = 0; k < 3; ++k)
        p[static_cast<Eigen::Index>(k)] = std::tan(std::numbers::pi / 4 * key[k] / cells);
      model.mesh.vertices_m.push_back(p.normalized());
    }
    return place->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {-1, 1}) {
      for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
          std::array<std::uint32_t, 4> q = {vertex(axis, sign, i, j), vertex(axis, sign, i + 1, j),
                                            vertex(axis, sign, i + 1, j + 1),
                                            vertex(axis, sign, i, j + 1)};
          if ((sign < 0) != inside_out) std::swap(q[1], q[3]);
          model.mesh.triangles.push_back({q[0], q[1], q[2]});
          model.mesh.triangles.push_back({q[0], q[2], q[3]});
        }
      }
    }
  }
  if (smooth) {
    for (const auto& v : model.mesh.vertices_m)
      model.vertex_normals.emplace_back((inside_out ? Eigen::Vector3d(-v) : v).cast<float>());
  }
  return model;
}

ObjectModel square(double half_m) {
  ObjectModel model;
  model.name = "square";
  model.mesh.vertices_m = {
      {-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return model;
}

ObjectModel box(const Eigen::Vector3d& half_m) {
  ObjectModel model;
  model.name = "box";
  for (int k = 0; k < 8; ++k) {
    model.mesh.vertices_m.emplace_back((k & 1) ? half_m.x() : -half_m.x(),
                                       (k & 2) ? half_m.y() : -half_m.y(),
                                       (k & 4) ? half_m.z() : -half_m.z());
  }
  model.mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                          {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return model;
}

Material grey(float albedo, SurfaceKind kind, double ior, double roughness) {
  Material m;
  m.name = "grey";
  m.kind = kind;
  m.albedo = {albedo, albedo, albedo};
  m.ior = ior;
  m.roughness = roughness;
  return m;
}

Scene scene_of(ObjectModel model, Material material, std::vector<Light> lights) {
  Scene scene;
  scene.name = "closed form";
  scene.models.push_back(std::move(model));
  scene.materials.push_back(std::move(material));
  Instance instance;
  instance.id = 1;
  instance.name = "body";
  scene.instances.push_back(instance);
  scene.lights = std::move(lights);
  return scene;
}

TrueView view_from(const Eigen::Vector3d& eye_m, const Eigen::Vector3d& target_m, double focal_px) {
  TrueView view;
  view.camera.width_px = view.camera.height_px = kSide;
  view.camera.fx_px = view.camera.fy_px = focal_px;
  view.camera.cx_px = view.camera.cy_px = (kSide - 1) / 2.0;
  const Eigen::Vector3d d = target_m - eye_m;
  const bool upright = std::hypot(d.x(), d.y()) < 1e-9;
  view.camera_from_world = view.camera_from_world_end =
      look_at(eye_m, target_m, upright ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ());
  return view;
}

Sky even_sky(float radiance) {
  const Rgbf c{radiance, radiance, radiance};
  return {c, c, c};
}

}  // namespace cousin::closed_form
