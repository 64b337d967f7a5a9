#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "benchmarks/suites/stability/path_scenes.h"
#include "sim/dataset/environment_io.h"
#include "sim/process/scratch_folder.h"
#include "sim/render/path_tracer.h"
#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"

namespace cousin {

using Eigen::Vector3d;

namespace path_scenes {

namespace {
constexpr int kSide_px = 24;
}

ObjectModel square(double half_m) {
  ObjectModel model;
  model.name = "square";
  model.mesh.vertices_m = {
      {-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return model;
}

ObjectModel box(const Vector3d& half_m, bool inside_out) {
  ObjectModel model;
  model.name = "box";
  for (int k = 0; k < 8; ++k) {
    model.mesh.vertices_m.emplace_back((k & 1) ? half_m.x() : -half_m.x(),
                                       (k & 2) ? half_m.y() : -half_m.y(),
                                       (k & 4) ? half_m.z() : -half_m.z());
  }
  model.mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                          {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  if (inside_out) {
    for (auto& t : model.mesh.triangles) std::swap(t[1], t[2]);
  }
  return model;
}

Material matt(float albedo) {
  Material m;
  m.name = "matt";
  m.albedo = {albedo, albedo, albedo};
  m.ior = 1;
  return m;
}

Material leaf_of(float albedo, float transmittance) {
  Material m = matt(albedo);
  m.name = "leaf";
  m.kind = SurfaceKind::leaf;
  m.transmittance = {transmittance, transmittance, transmittance};
  return m;
}

void add(Scene& scene, ObjectModel model, Material material, const Vector3d& at_m) {
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = model.name + " " + std::to_string(instance.id);
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  instance.world_from_object.translation_m = at_m;
  scene.instances.push_back(std::move(instance));
  scene.models.push_back(std::move(model));
  scene.materials.push_back(std::move(material));
}

Sky even_sky(float radiance) {
  const Rgbf c{radiance, radiance, radiance};
  return {c, c, c};
}

TrueView view_from(const Vector3d& eye_m, const Vector3d& target_m, double focal_px) {
  TrueView view;
  view.camera.width_px = view.camera.height_px = kSide_px;
  view.camera.fx_px = view.camera.fy_px = focal_px;
  view.camera.cx_px = view.camera.cy_px = 0.5 * (kSide_px - 1);
  const Vector3d d = target_m - eye_m;
  const bool upright = std::hypot(d.x(), d.y()) < 1e-6 * d.norm();
  view.camera_from_world = view.camera_from_world_end =
      look_at(eye_m, target_m, upright ? Vector3d::UnitY() : Vector3d::UnitZ());
  return view;
}

}  // namespace path_scenes

namespace {

using namespace path_scenes;

/// 1 if the call throws an error that names what it must.
template <class Error>
double named(const std::function<void()>& call, const std::string& name) {
  try {
    call();
  } catch (const Error& error) {
    return std::string(error.what()).find(name) != std::string::npos ? 1 : 0;
  }
  return 0;
}

/// A scene with an error, and what its message must hold.
struct SpoiledScene {
  const char* name;
  std::function<void(Scene&)> spoil;
  const char* must_name;
};

std::vector<SpoiledScene> spoiled_lights() {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const auto lamp = [](const Vector3d& u, const Vector3d& v, float radiance) {
    return [=](Scene& s) {
      s.lights.emplace_back(Lamp{{0, 0, 1}, u, v, {radiance, radiance, radiance}});
    };
  };
  const Vector3d x(0.1, 0, 0), y(0, 0.1, 0), zero = Vector3d::Zero();
  return {
      {"lamp without area", lamp(x, zero, 1), "light 1 (lamp): area"},
      {"lamp whose axes are parallel", lamp(x, 2 * x, 1), "light 1 (lamp): area"},
      {"lamp of infinite power", lamp(x, y, infinity), "light 1 (lamp): radiance = inf"},
      {"lamp of power that is no number", lamp(x, y, nan), "light 1 (lamp): radiance = nan"},
      {"lamp of negative power", lamp(x, y, -1), "light 1 (lamp): radiance = -1"},
      {"sun without direction",
       [](Scene& s) {
         s.lights.emplace_back(Sun{Vector3d(0, 0, 0), 0.005, {1, 1, 1}});
       },
       "light 1 (sun): to_sun"},
      {"sun of no width",
       [](Scene& s) {
         s.lights.emplace_back(Sun{Vector3d::UnitZ(), 0, {1, 1, 1}});
       },
       "light 1 (sun): angular_radius_rad = 0"},
      {"environment without pixels", [](Scene& s) { s.lights.emplace_back(Environment{}); },
       "light 1 (environment)"},
      {"environment with a texel that is no number",
       [=](Scene& s) {
         s.lights.emplace_back(Environment{Image<Rgbf>(4, 2, {1, nan, 1})});
       },
       "light 1 (environment): radiance = nan"},
  };
}

std::vector<SpoiledScene> spoiled_surfaces() {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  return {
      {"albedo above 1", [](Scene& s) { s.materials[0].albedo.g = 1.5F; },
       "\"matt\": albedo = 1.5"},
      {"flesh of a mean free path that is no number",
       [=](Scene& s) { s.materials[0].mean_free_path_m.g = nan; },
       "\"matt\": mean_free_path_m = nan"},
      {"flesh of an open sheet",
       [](Scene& s) {
         s.materials[0].mean_free_path_m = {0.01F, 0.01F, 0.01F};
       },
       "instance \"square 0\" has a mean_free_path_m and is not closed"},
      {"water of no index", [](Scene& s) { s.materials[0].kind = SurfaceKind::clear; },
       "\"matt\": ior = 1"},
      {"roughness of 0", [](Scene& s) { s.materials[0].roughness = 0; }, "\"matt\": roughness = 0"},
      {"triangle of a vertex that is not there",
       [](Scene& s) { s.models[0].mesh.triangles[1][2] = 9; }, "\"square\": triangle 1"},
      {"instance of a model that is not there", [](Scene& s) { s.instances[0].model = 3; },
       "instance \"square 0\": no such model"},
      {"two instances of one id",
       [](Scene& s) {
         s.instances.push_back(s.instances[0]);
         s.instances[1].name = "twin";
       },
       "instance \"twin\": its id"},
      {"pose with a zero rotation",
       [](Scene& s) { s.instances[0].world_from_object.rotation.coeffs().setZero(); },
       "instance \"square 0\": its pose's rotation"},
  };
}

void add_refusal_rows(const std::vector<SpoiledScene>& cases, std::vector<StabilityRow>& rows) {
  for (const SpoiledScene& c : cases) {
    Scene scene;
    scene.name = "spoiled";
    add(scene, square(1), matt(0.5F), {0, 0, 0});
    scene.lights.emplace_back(even_sky(1));
    c.spoil(scene);
    rows.push_back(make_row(c.name, "error names it", "", 1,
                            named<std::invalid_argument>(
                                [&] {
                                  const RayScene rays(scene);
                                  PathTracer(rays, scene)
                                      .render(view_from({0, 0, 1}, {0, 0, 0}), {.pixel_samples = 1},
                                              Rng(1));
                                },
                                c.must_name),
                            false));
  }
}

void add_view_rows(std::vector<StabilityRow>& rows) {
  Scene scene;
  scene.name = "views";
  add(scene, square(1), matt(0.5F), {0, 0, 0});
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  const auto refused = [&](const char* name, const std::function<void(TrueView&)>& spoil,
                           const char* must_name) {
    TrueView view = view_from({0, 0, 1}, {0, 0, 0});
    view.frame = 7;
    spoil(view);
    const double light = named<std::invalid_argument>(
        [&] { tracer.render(view, {.pixel_samples = 1}, Rng(1)); }, must_name);
    const double truth = named<std::invalid_argument>(
        [&] { render_truth(rays, scene, view, {.depth = true}); }, must_name);
    rows.push_back(make_row(name, "error names it", "", 1, std::min(light, truth), false));
  };
  refused(
      "camera without columns", [](TrueView& v) { v.camera.width_px = 0; }, "frame 7");
  refused(
      "camera of negative height", [](TrueView& v) { v.camera.height_px = -4; }, "frame 7");
  refused(
      "camera nowhere", [](TrueView& v) { v.camera_from_world.translation_m.x() = std::nan(""); },
      "frame 7");
  refused(
      "negative exposure", [](TrueView& v) { v.exposure_s = -1; }, "exposure_s = -1");
  refused(
      "focus behind the lens", [](TrueView& v) { v.focus_m = -1; }, "focus_m = -1");
  refused(
      "lens that folds",
      [](TrueView& v) {
        v.camera.model = LensModel::opencv5;
        v.camera.distortion = {-0.9};
        v.camera.fx_px = v.camera.fy_px = 12;
      },
      "frame 7");
}

void add_file_rows(std::vector<StabilityRow>& rows) {
  const ScratchFolder folder("cousin-stability");
  const std::filesystem::path file = folder.path() / "sky.exr";
  const auto row = [&](const char* name) {
    rows.push_back(make_row(name, "error names the file", "", 1,
                            named<std::runtime_error>([&] { read_environment(file); }, "sky.exr"),
                            false));
  };
  row("environment file that is not there");
  const auto write = [&](const std::string& bytes) {
    std::ofstream out(file, std::ios::binary);
    out << bytes;
  };
  write("");
  row("empty EXR");
  write("This is no picture.");
  row("EXR of other bytes");
  write(std::string("\x76\x2f\x31\x01\x02\x00\x00\x00", 8) + std::string(64, '\xff'));
  row("EXR with a damaged header");
}

}  // namespace

void add_path_refusals(std::vector<StabilityRow>& rows) {
  add_refusal_rows(spoiled_lights(), rows);
  add_refusal_rows(spoiled_surfaces(), rows);
  add_view_rows(rows);
  add_file_rows(rows);
}

}  // namespace cousin
