#include "benchmarks/suites/stability/ray_cases.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "sim/render/ray_query.h"
#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

std::string text_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

Vector3d random_direction(Rng& rng) {
  const double z = uniform(rng, -1, 1);
  const double phi = uniform(rng, 0, 2 * std::numbers::pi);
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Closed ellipsoid of latitude bands; poles are fans of narrow triangles.
Mesh ellipsoid(const Vector3d& semi_axes_m, int bands) {
  Mesh mesh;
  const int columns = 2 * bands;
  mesh.vertices_m.emplace_back(0, 0, semi_axes_m.z());
  for (int i = 1; i < bands; ++i) {
    const double theta = std::numbers::pi * i / bands;
    for (int j = 0; j < columns; ++j) {
      const double phi = 2 * std::numbers::pi * j / columns;
      mesh.vertices_m.emplace_back(Vector3d(std::sin(theta) * std::cos(phi),
                                            std::sin(theta) * std::sin(phi), std::cos(theta))
                                       .cwiseProduct(semi_axes_m));
    }
  }
  mesh.vertices_m.emplace_back(0, 0, -semi_axes_m.z());
  const auto last = static_cast<std::uint32_t>(mesh.vertices_m.size() - 1);
  const auto at = [&](int i, int j) {
    return static_cast<std::uint32_t>(1 + (i - 1) * columns + j % columns);
  };
  for (int j = 0; j < columns; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    mesh.triangles.push_back({last, at(bands - 1, j + 1), at(bands - 1, j)});
    for (int i = 1; i + 1 < bands; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

Mesh box(const Vector3d& half_m) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k) {
    mesh.vertices_m.emplace_back((k & 1) ? half_m.x() : -half_m.x(),
                                 (k & 2) ? half_m.y() : -half_m.y(),
                                 (k & 4) ? half_m.z() : -half_m.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// How RayScene keeps a case's meshes: in the world, or, as each has a twin, as models that
/// instances share.
enum class Placing { world, shared };

/// Prefix of a case's name.
std::string text_of(Placing placing) { return placing == Placing::shared ? "instanced, " : ""; }

/// One object a mesh. `size_m`: twins are put, turned, 60 of it below.
Scene scene_of(std::vector<Mesh> meshes, Placing placing, double size_m) {
  Scene scene;
  scene.name = "stability";
  scene.materials.emplace_back();
  for (Mesh& mesh : meshes) {
    Instance instance;
    instance.id = static_cast<int>(scene.instances.size());
    instance.name = "object " + std::to_string(instance.id);
    instance.model = instance.id;
    scene.instances.push_back(instance);
    ObjectModel model;
    model.name = instance.name;
    model.mesh = std::move(mesh);
    scene.models.push_back(std::move(model));
  }
  constexpr int kTwin = 1000;
  const std::size_t objects = scene.instances.size();
  for (std::size_t i = 0; placing == Placing::shared && i < objects; ++i) {
    Instance twin = scene.instances[i];
    twin.id += kTwin;
    twin.name += "'s twin";
    twin.world_from_object.rotation = Eigen::AngleAxisd(1, Vector3d::UnitZ());
    // It turns about its own first corner, so that it stays below wherever the object lies.
    const Mesh& own = scene.models[i].mesh;
    const Vector3d corner = own.vertices_m.empty() ? Vector3d::Zero() : own.vertices_m[0];
    twin.world_from_object.translation_m =
        corner - twin.world_from_object.rotation * corner - Vector3d(0, 0, 60 * size_m);
    scene.instances.push_back(twin);
  }
  return scene;
}

Mesh moved(Mesh mesh, const Vector3d& by) {
  for (auto& v : mesh.vertices_m) v += by;
  return mesh;
}

struct OffsetRates {
  double false_occlusion = 0;
  double leak = 0;
  double missed = 0;
};

/// A convex ball that must not shadow its own lit side, and a plate of 1/500 of its width that must
/// stop a ray which enters it. `apart_m` moves them from the scene's centre.
OffsetRates offset_rates(Placing placing, double scale_m, double offset_m, double apart_m,
                         int count, Rng rng) {
  const Vector3d shift(offset_m, -0.7 * offset_m, 0.3 * offset_m);
  const Vector3d ball_m = shift + Vector3d(apart_m, 0, 0),
                 plate_m = shift - Vector3d(apart_m, 0, 0);
  // Fine triangles for the ball, two big ones a side for the plate.
  const Scene scene = scene_of({moved(ellipsoid(Vector3d::Constant(scale_m), 24), ball_m),
                                moved(box(scale_m * Vector3d(1, 1, 0.002)), plate_m)},
                               placing, scale_m);
  const RayScene rays(scene);
  OffsetRates rates;
  for (int i = 0; i < count; ++i) {
    const Vector3d from = random_direction(rng);
    const Vector3d aim = 0.9 * scale_m * uniform(rng) * random_direction(rng);
    const Vector3d d = (aim - 2 * scale_m * from).normalized();
    const RayAnswer on_ball = cast_ray(rays, ball_m + 2 * scale_m * from, d);
    if (!on_ball.hit || on_ball.instance != 0) {
      rates.missed += 1;
    } else {
      Vector3d out = random_direction(rng);
      if (out.dot(on_ball.normal) < 0) out = -out;
      // From the plate's side of the scene the plate may rightly be met; the ball may not.
      const RayAnswer next = cast_from(rays, on_ball, out);
      rates.false_occlusion += next.hit && next.instance == 0 ? 1 : 0;
    }
    const Vector3d over(uniform(rng, -0.9, 0.9) * scale_m, uniform(rng, -0.9, 0.9) * scale_m,
                        0.5 * scale_m);
    const RayAnswer on_plate = cast_ray(rays, plate_m + over, -Vector3d::UnitZ());
    if (!on_plate.hit || on_plate.instance != 1) {
      rates.missed += apart_m > 0 ? 1 : 0;  // where they overlap the ball covers the plate
      continue;
    }
    Vector3d in = random_direction(rng);
    if (in.z() > 0) in = -in;
    const RayAnswer inside = cast_from(rays, on_plate, in);
    rates.leak += inside.hit && inside.instance == 1 && inside.is_back ? 0 : 1;
  }
  rates.false_occlusion /= count;
  rates.leak /= count;
  rates.missed /= count;
  return rates;
}

void add_offset_cases(std::vector<StabilityRow>& rows, Placing placing, int count, const Rng& rng) {
  const auto add = [&](const std::string& name, const OffsetRates& rates) {
    rows.push_back(make_row(name, "false occlusion rate", "", 0, rates.false_occlusion));
    rows.push_back(make_row(name, "light leak rate", "", 0, rates.leak));
    rows.push_back(make_row(name, "missed rate", "", 0, rates.missed));
  };
  std::uint64_t index = 0;
  for (const double scale_m : {1e-4, 1e-2, 1.0, 1e2, 1e4}) {
    for (const double offset_m : {0.0, 1.0, 1e3, 1e5}) {
      add(text_of(placing) + "ray offset, scale " + text_of(scale_m) + " m at " +
              text_of(offset_m) + " m",
          offset_rates(placing, scale_m, offset_m, 2 * scale_m, count, rng.fork(index++)));
    }
  }
  add(text_of(placing) + "ray offset, 100 sizes from the scene's centre",
      offset_rates(placing, 1, 0, 100, count, rng.fork(index++)));
}

/// A large plane seen at an angle, through a lens so long that all its pixels have that angle.
StabilityRow grazing_case(Placing placing, double incidence_deg) {
  Mesh plane;
  constexpr double kHalf = 2e5;
  plane.vertices_m = {
      {-kHalf, -kHalf, 0}, {kHalf, -kHalf, 0}, {kHalf, kHalf, 0}, {-kHalf, kHalf, 0}};
  plane.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Scene scene = scene_of({std::move(plane)}, placing, 1);
  const RayScene rays(scene);
  TrueView view;
  view.camera.width_px = view.camera.height_px = 64;
  view.camera.fx_px = view.camera.fy_px = 1e6;
  view.camera.cx_px = view.camera.cy_px = 31.5;
  const double angle = incidence_deg * std::numbers::pi / 180;
  const Vector3d eye(-std::sin(angle), 0.123, std::cos(angle));
  view.camera_from_world = look_at(eye, Vector3d(0, 0.123, 0), Vector3d::UnitY());
  view.camera_from_world_end = view.camera_from_world;
  const TruthImages truth = render_truth(rays, scene, view, {.depth = true});
  const Eigen::Matrix3d r = view.camera_from_world.rotation.toRotationMatrix();
  const Vector3d centre = centre_in_world_m(view.camera_from_world);
  double sum = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const Vector3d d = unproject(view.camera, {x, y}).value_or(Vector3d::UnitZ());
      const double expected = -centre.z() / (r.transpose() * d).z() * d.z();
      const double error = static_cast<double>(truth.depth_m(x, y)) / expected - 1;
      sum += error * error;
    }
  }
  return make_row(text_of(placing) + "grazing plane, " + text_of(incidence_deg) + " deg",
                  "relative RMS of depth", "", 1e-6, std::sqrt(sum / (64 * 64)));
}

/// A tilted square of needles: strips of 1 / aspect of its side, seen by 200 x 200 rays.
void add_needle_case(std::vector<StabilityRow>& rows, Placing placing, double aspect) {
  constexpr int kNeedles = 2000;
  Mesh mesh;  // a band of needles in the middle, two wide strips beside it
  std::vector<double> edges = {-1.0};
  const double width = 1 / aspect;
  for (int i = 0; i <= kNeedles; ++i) edges.push_back((i - 0.5 * kNeedles) * width);
  edges.push_back(1.0);
  if (edges[1] < -1) {  // needles fill the square
    edges.clear();
    for (int i = 0; i <= kNeedles; ++i) edges.push_back(-1 + 2.0 * i / kNeedles);
  }
  const auto height = [](double x, double y) { return 0.3 * x - 0.2 * y; };
  for (const double x : edges) {
    mesh.vertices_m.emplace_back(x, -1, height(x, -1));
    mesh.vertices_m.emplace_back(x, 1, height(x, 1));
  }
  for (std::uint32_t i = 0; i + 1 < edges.size(); ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    mesh.triangles.push_back({2 * i + 2, 2 * i + 3, 2 * i + 1});
  }
  const Scene scene = scene_of({std::move(mesh)}, placing, 1);
  const RayScene rays(scene);
  TrueView view;
  view.camera.width_px = view.camera.height_px = 200;
  view.camera.fx_px = view.camera.fy_px = 200 * 3;
  view.camera.cx_px = view.camera.cy_px = 99.5;
  view.camera_from_world = look_at({0.2, 0.1, 3}, {0, 0, 0}, Vector3d::UnitY());
  view.camera_from_world_end = view.camera_from_world;
  const TruthImages truth = render_truth(rays, scene, view, {.depth = true});
  const Eigen::Matrix3d r = view.camera_from_world.rotation.toRotationMatrix();
  const Vector3d eye = centre_in_world_m(view.camera_from_world);
  double sum = 0, missed = 0;
  int seen = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const Vector3d d = unproject(view.camera, {x, y}).value_or(Vector3d::UnitZ());
      const Vector3d w = r.transpose() * d;
      const double t = (height(eye.x(), eye.y()) - eye.z()) / (w.z() - height(w.x(), w.y()));
      const Vector3d p = eye + t * w;
      if (std::max(std::abs(p.x()), std::abs(p.y())) > 0.999) continue;
      ++seen;
      if (std::isnan(truth.depth_m(x, y))) {
        missed += 1;
        continue;
      }
      const double error = static_cast<double>(truth.depth_m(x, y)) / (t * d.z()) - 1;
      sum += error * error;
    }
  }
  const std::string name = text_of(placing) + "needle triangles, aspect " + text_of(aspect);
  rows.push_back(make_row(name, "missed rays", "", 0, missed));
  rows.push_back(
      make_row(name, "relative RMS of depth", "", 1e-6, std::sqrt(sum / std::max(seen, 1))));
}

/// Where it is shared the rays start in the twin, which is turned and far from the object's origin.
StabilityRow watertight_row(Placing placing, const std::string& name, const Mesh& mesh,
                            std::int64_t count, const Rng& rng) {
  const Scene scene = scene_of({mesh}, placing, 1e-3);
  const RayScene rays(scene);
  Vector3d centroid = Vector3d::Zero();
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3d &a = mesh.vertices_m[t[0]], &b = mesh.vertices_m[t[1]],
                   &c = mesh.vertices_m[t[2]];
    const double v = a.dot(b.cross(c));
    volume += v;
    centroid += v * (a + b + c) / 4;
  }
  centroid /= volume;
  centroid = scene.instances.back().world_from_object * centroid;
  // Each batch walks: from the centroid to a surface, back to a point between, then a ray from
  // there.
  constexpr std::int64_t kBatch = 4096;
  const std::int64_t batches = (count + kBatch - 1) / kBatch;
  const std::int64_t escapes = tbb::parallel_reduce(
      tbb::blocked_range<std::int64_t>(0, batches), std::int64_t{0},
      [&](const tbb::blocked_range<std::int64_t>& range, std::int64_t sum) {
        for (std::int64_t batch = range.begin(); batch < range.end(); ++batch) {
          Rng own = rng.fork(static_cast<std::uint64_t>(batch));
          const std::int64_t end = std::min(count, (batch + 1) * kBatch);
          Vector3d origin = centroid;
          for (std::int64_t i = batch * kBatch; i < end; ++i) {
            const Vector3d d = random_direction(own);
            const RayAnswer answer = cast_ray(rays, origin, d);
            if (!answer.hit || !answer.is_back) {
              ++sum;
              origin = centroid;
            } else {
              const bool restart = i % 4 == 3;
              origin = restart ? centroid
                               : Vector3d(origin + uniform(own, 0.1, 0.9) * answer.distance_m * d);
            }
          }
        }
        return sum;
      },
      std::plus<>());
  return make_row(
      text_of(placing) + "watertight, " + name + ", " + std::to_string(count) + " rays from inside",
      "escapes", "", 0, static_cast<double>(escapes));
}

}  // namespace

StabilityRow watertight_case(const std::string& name, const Mesh& mesh, std::int64_t count,
                             Rng rng) {
  return watertight_row(Placing::world, name, mesh, count, rng);
}

std::vector<StabilityRow> ray_cases(const RayCasesConfig& config, Rng rng) {
  std::vector<StabilityRow> rows;
  for (const Placing placing : {Placing::world, Placing::shared}) {
    add_offset_cases(rows, placing, config.offset_rays, rng.fork("offset"));
    rows.push_back(watertight_row(placing, "seed of 6 mm", ellipsoid({0.003, 0.0016, 0.0014}, 120),
                                  config.watertight_rays, rng.fork("watertight")));
    for (const double angle : {0.0, 45.0, 80.0, 89.0, 89.9, 89.99})
      rows.push_back(grazing_case(placing, angle));
    for (const double aspect : {1e3, 1e5, 1e7}) add_needle_case(rows, placing, aspect);
  }
  return rows;
}

}  // namespace cousin
