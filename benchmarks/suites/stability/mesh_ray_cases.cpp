#include "benchmarks/suites/stability/mesh_ray_cases.h"

#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr int kImage_px = 64;

/// A grid of 2 * cells * cells triangles over [-half, half]^2 in z = 0.
Mesh sheet(double half_m, int cells) {
  Mesh mesh;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i)
      mesh.vertices_m.emplace_back(half_m * (2.0 * i / cells - 1), half_m * (2.0 * j / cells - 1),
                                   0);
  }
  const auto n = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t j = 0; j + 1 < n; ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i;
      mesh.triangles.push_back({a, a + 1, a + n});
      mesh.triangles.push_back({a + 1, a + n + 1, a + n});
    }
  }
  return mesh;
}

Instance instance_of(int id, int model, const Vector3d& at_m) {
  Instance instance;
  instance.id = id;
  instance.name = "object " + std::to_string(id);
  instance.model = model;
  instance.world_from_object.translation_m = at_m;
  return instance;
}

/// One object at `at_m`, and where it is shared a twin behind it.
Scene scene_of(Mesh mesh, bool is_shared, const Vector3d& at_m, double size_m) {
  Scene scene;
  scene.name = "stability";
  scene.materials.emplace_back();
  ObjectModel model;
  model.name = "object";
  model.mesh = std::move(mesh);
  scene.models.push_back(std::move(model));
  scene.instances.push_back(instance_of(0, 0, at_m));
  if (is_shared) scene.instances.push_back(instance_of(1, 0, at_m - Vector3d(0, 0, 60 * size_m)));
  return scene;
}

/// Looks down at a sheet of half-width `size_m` from twice that, at an angle; it fills the image.
TrueView view_of(const Vector3d& at_m, double size_m) {
  TrueView view;
  view.camera.width_px = view.camera.height_px = kImage_px;
  view.camera.fx_px = view.camera.fy_px = 100;
  view.camera.cx_px = view.camera.cy_px = 0.5 * (kImage_px - 1);
  view.camera_from_world = look_at(at_m + size_m * Vector3d(0.5, 0.3, 1.8),
                                   at_m + size_m * Vector3d(0.05, 0.02, 0), Vector3d::UnitY());
  view.camera_from_world_end = view.camera_from_world;
  return view;
}

struct DepthErrors {
  double missed = 0;
  double relative_rms = 0;
};

/// Depth of the plane z = at_m.z() against its closed form.
DepthErrors depth_errors(const Scene& scene, const TrueView& view, const Vector3d& at_m) {
  const RayScene rays(scene);
  const TruthImages truth = render_truth(rays, scene, view, {.depth = true});
  const Eigen::Matrix3d r = view.camera_from_world.rotation.toRotationMatrix();
  const double height_m = (centre_in_world_m(view.camera_from_world) - at_m).z();
  DepthErrors errors;
  double sum = 0;
  for (int y = 0; y < kImage_px; ++y) {
    for (int x = 0; x < kImage_px; ++x) {
      const Vector3d d = unproject(view.camera, {x, y}).value_or(Vector3d::UnitZ());
      const double expected = -height_m / (r.transpose() * d).z() * d.z();
      const double error = static_cast<double>(truth.depth_m(x, y)) / expected - 1;
      if (std::isnan(error)) {
        errors.missed += 1;
      } else {
        sum += error * error;
      }
    }
  }
  errors.relative_rms = std::sqrt(sum / (kImage_px * kImage_px));
  return errors;
}

void add_depth_rows(std::vector<StabilityRow>& rows, const std::string& name,
                    const DepthErrors& errors) {
  rows.push_back(make_row(name, "missed rays", "", 0, errors.missed));
  rows.push_back(make_row(name, "relative RMS of depth", "", 1e-6, errors.relative_rms));
}

std::string text_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Every third triangle folded to a line, every third doubled to a point; their place is covered by
/// whole ones.
Mesh with_degenerate_triangles(Mesh mesh) {
  const std::size_t count = mesh.triangles.size();
  for (std::size_t i = 0; i < count; i += 3) {
    const auto t = mesh.triangles[i];
    mesh.triangles.push_back({t[0], t[1], t[1]});
    mesh.triangles.push_back({t[2], t[2], t[2]});
    mesh.vertices_m.push_back(0.5 * (mesh.vertices_m[t[0]] + mesh.vertices_m[t[1]]));
    mesh.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(mesh.vertices_m.size() - 1)});
  }
  return mesh;
}

/// 1 if the error does not name what it must.
double unnamed_error(Scene scene, const std::function<void(Scene&)>& spoil, const char* name) {
  spoil(scene);
  try {
    const RayScene rays(scene);
  } catch (const std::invalid_argument& error) {
    return std::string(error.what()).find(name) != std::string::npos ? 0 : 1;
  }
  return 1;
}

/// Pixels whose winner of two coincident sheets changes with threads or from run to run.
double coincidence_changes(bool is_shared) {
  Scene scene = scene_of(sheet(1, 8), is_shared, Vector3d::Zero(), 1);
  if (!is_shared) scene.models.push_back(scene.models[0]);
  scene.instances.push_back(instance_of(7, is_shared ? 0 : 1, Vector3d::Zero()));
  const TrueView view = view_of(Vector3d::Zero(), 1);
  Image<std::int32_t> first;
  double changes = 0;
  for (const std::size_t threads : {1U, 2U, 7U, 1U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const RayScene rays(scene);
    const Image<std::int32_t> ids = render_truth(rays, scene, view, {.instance = true}).instance;
    if (first.empty()) first = ids;
    for (std::size_t i = 0; i < ids.size(); ++i)
      changes += ids.data()[i] != first.data()[i] || ids.data()[i] < 0 ? 1 : 0;
  }
  return changes;
}

/// The camera between the sides of a leaf of 0.2 mm: what it sees is the inner side, 0.05 mm away.
StabilityRow inside_leaf(bool is_shared, const std::string& prefix) {
  constexpr double kThick_m = 2e-4, kBelow_m = 5e-5;
  Mesh leaf = sheet(0.05, 4);
  const auto count = static_cast<std::uint32_t>(leaf.vertices_m.size());
  for (std::uint32_t i = 0; i < count; ++i)
    leaf.vertices_m.emplace_back(leaf.vertices_m[i] - Vector3d(0, 0, kThick_m));
  const std::size_t triangles = leaf.triangles.size();
  for (std::size_t i = 0; i < triangles; ++i) {
    const auto t = leaf.triangles[i];
    leaf.triangles.push_back({t[0] + count, t[2] + count, t[1] + count});
  }
  const Scene scene = scene_of(std::move(leaf), is_shared, Vector3d::Zero(), 0.05);
  TrueView view = view_of(Vector3d::Zero(), 0.05);
  view.camera_from_world =
      look_at({0.001, 0.002, -kThick_m + kBelow_m}, {0.001, 0.002, -kThick_m}, Vector3d::UnitY());
  view.camera_from_world_end = view.camera_from_world;
  const RayScene rays(scene);
  const TruthImages truth = render_truth(rays, scene, view, {.depth = true});
  double worst = 0;
  for (const float depth_m : truth.depth_m) {
    const double error = std::abs(static_cast<double>(depth_m) / kBelow_m - 1);
    worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(worst, error);
  }
  return make_row(prefix + "camera inside a leaf of 0.2 mm", "largest relative error of depth", "",
                  1e-6, worst);
}

/// The camera's centre on a leaf: rays meet it at no distance, and must go on to the floor.
void add_on_leaf_rows(std::vector<StabilityRow>& rows, bool is_shared, const std::string& prefix) {
  Scene scene = scene_of(sheet(1, 8), is_shared, Vector3d::Zero(), 1);
  ObjectModel floor;
  floor.name = "floor";
  floor.mesh = sheet(20, 1);
  scene.models.push_back(floor);
  const Vector3d floor_m(0, 0, -2);
  scene.instances.push_back(instance_of(9, 1, floor_m));
  TrueView view = view_of(Vector3d::Zero(), 1);
  view.camera_from_world = look_at({0.1, 0.07, 0}, {0.1, 0.27, -1}, Vector3d::UnitY());
  view.camera_from_world_end = view.camera_from_world;
  add_depth_rows(rows, prefix + "camera on a leaf", depth_errors(scene, view, floor_m));
}

}  // namespace

std::vector<StabilityRow> mesh_ray_cases() {
  std::vector<StabilityRow> rows;
  for (const bool is_shared : {false, true}) {
    const std::string prefix = is_shared ? "instanced, " : "";
    const Scene plain = scene_of(sheet(1, 8), is_shared, Vector3d::Zero(), 1);
    const Vector3d origin = Vector3d::Zero();
    add_depth_rows(
        rows, prefix + "triangles without area among whole ones",
        depth_errors(scene_of(with_degenerate_triangles(sheet(1, 8)), is_shared, origin, 1),
                     view_of(origin, 1), origin));
    rows.push_back(
        make_row(prefix + "a vertex that is not a number", "error names no object", "", 0,
                 unnamed_error(
                     plain, [](Scene& s) { s.models[0].mesh.vertices_m[3].z() = std::nan(""); },
                     "\"object\": vertex 3")));
    rows.push_back(make_row(prefix + "a pose that is not finite", "error names no object", "", 0,
                            unnamed_error(
                                plain,
                                [](Scene& s) {
                                  s.instances[0].world_from_object.translation_m.x() =
                                      std::numeric_limits<double>::infinity();
                                },
                                "\"object 0\"")));
    rows.push_back(make_row(prefix + "coincident sheets", "pixels that change with threads", "", 0,
                            coincidence_changes(is_shared)));
    rows.push_back(inside_leaf(is_shared, prefix));
    add_on_leaf_rows(rows, is_shared, prefix);
    for (const double scale_m : {1e-4, 1e-2, 1.0, 1e2, 1e4}) {
      for (const double offset_m : {0.0, 1e3, 1e5}) {
        const Vector3d at_m = offset_m * Vector3d(1, -0.7, 0.3);
        add_depth_rows(
            rows, prefix + "depth, scale " + text_of(scale_m) + " m at " + text_of(offset_m) + " m",
            depth_errors(scene_of(sheet(2 * scale_m, 8), is_shared, at_m, scale_m),
                         view_of(at_m, scale_m), at_m));
      }
    }
  }
  return rows;
}

}  // namespace cousin
