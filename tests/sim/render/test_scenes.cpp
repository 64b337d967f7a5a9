#include "tests/sim/render/test_scenes.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace cousin::test {

ObjectModel ellipsoid(const Eigen::Vector3d& semi_axes_m, int cells) {
  ObjectModel model;
  model.name = "ellipsoid";
  std::map<std::array<int, 3>, std::uint32_t> index;
  const auto vertex = [&](const std::array<int, 3>& p) {
    const auto [it, is_new] =
        index.try_emplace(p, static_cast<std::uint32_t>(model.mesh.vertices_m.size()));
    if (is_new) {
      // Tangent spacing keeps triangles of like size.
      Eigen::Vector3d d;
      for (int k = 0; k < 3; ++k)
        d[k] = std::tan(0.25 * M_PI * (2.0 * p[static_cast<std::size_t>(k)] / cells - 1));
      d.normalize();
      model.mesh.vertices_m.emplace_back(d.cwiseProduct(semi_axes_m));
      model.vertex_normals.emplace_back(d.cwiseQuotient(semi_axes_m).normalized().cast<float>());
    }
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells; ++j) {
          const auto corner = [&](int a, int b) {
            std::array<int, 3> p{};
            p[static_cast<std::size_t>(axis)] = side * cells;
            p[static_cast<std::size_t>((axis + 1) % 3)] = i + a;
            p[static_cast<std::size_t>((axis + 2) % 3)] = j + b;
            return vertex(p);
          };
          std::array<std::uint32_t, 4> q = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          if (side == 0) std::swap(q[1], q[3]);
          model.mesh.triangles.push_back({q[0], q[1], q[2]});
          model.mesh.triangles.push_back({q[0], q[2], q[3]});
        }
      }
    }
  }
  return model;
}

ObjectModel box(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m) {
  ObjectModel model;
  model.name = "box";
  for (int k = 0; k < 8; ++k) {
    model.mesh.vertices_m.emplace_back((k & 1) ? high_m.x() : low_m.x(),
                                       (k & 2) ? high_m.y() : low_m.y(),
                                       (k & 4) ? high_m.z() : low_m.z());
  }
  model.mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                          {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
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

ObjectModel inside_out(ObjectModel model) {
  for (auto& t : model.mesh.triangles) std::swap(t[1], t[2]);
  for (auto& n : model.vertex_normals) n = -n;
  return model;
}

int add(Scene& scene, ObjectModel model, const Material& material, const Pose& world_from_object,
        bool is_specimen) {
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size()) + 1;
  instance.name = model.name;
  instance.is_specimen = is_specimen;
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  instance.world_from_object = world_from_object;
  scene.models.push_back(std::move(model));
  scene.materials.push_back(material);
  scene.instances.push_back(instance);
  return instance.id;
}

Material matt(float albedo) {
  Material material;
  material.albedo = {albedo, albedo, albedo};
  material.ior = 1;
  return material;
}

TrueView view_from(const Camera& camera, const Eigen::Vector3d& eye_m,
                   const Eigen::Vector3d& target_m, const Eigen::Vector3d& up) {
  TrueView view;
  view.camera = camera;
  view.camera_from_world = look_at(eye_m, target_m, up);
  view.camera_from_world_end = view.camera_from_world;
  return view;
}

Scene table_top(int seeds, int cells) {
  Scene scene;
  scene.name = "table_top";
  Material paper;
  paper.albedo = {0.8F, 0.8F, 0.8F};
  paper.print = SeedBoard{};
  add(scene, box({-0.05, -0.05, -0.002}, {0.05, 0.05, 0}), paper);
  Material green;
  green.albedo = {0.05F, 0.35F, 0.08F};
  green.roughness = 0.8;
  Pose below;
  below.translation_m.z() = -0.004;
  add(scene, square(0.6), green, below);
  for (int i = 0; i < seeds; ++i) {
    Material husk;
    husk.albedo = {0.55F, 0.38F + 0.02F * static_cast<float>(i % 5), 0.12F};
    husk.roughness = 0.4;
    Pose pose;
    pose.rotation = Eigen::AngleAxisd(0.7 * i, Eigen::Vector3d::UnitZ());
    pose.translation_m = Eigen::Vector3d(0.014 * (i % 4) - 0.02, 0.016 * (i / 4) - 0.02, 0.0022);
    add(scene, ellipsoid({0.0055, 0.004, 0.0022}, cells), husk, pose, true);
  }
  scene.lights.emplace_back(Sky{{0.35F, 0.4F, 0.5F}, {0.3F, 0.3F, 0.3F}, {0.2F, 0.2F, 0.2F}});
  scene.lights.emplace_back(
      Lamp{{0.5, 0.3, 0.8}, {-0.05, 0.08, 0}, {0.08, 0.05, 0.08}, {30, 29, 26}});
  scene.lights.emplace_back(Lamp{{-0.6, 0.1, 0.7}, {0, -0.1, 0}, {-0.07, 0, -0.07}, {18, 19, 20}});
  for (auto& light : scene.lights) {  // lamps shine at the board
    auto* lamp = std::get_if<Lamp>(&light);
    if (lamp && lamp->axis_u_m.cross(lamp->axis_v_m).dot(lamp->centre_in_world_m) > 0)
      lamp->axis_u_m *= -1;
  }
  return scene;
}

}  // namespace cousin::test
