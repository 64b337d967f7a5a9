#include "benchmarks/suites/render/leaf_cloud.h"

#include <malloc.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/render/ray_query.h"
#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

/// An open sheet of a leaf's outline, 60 to 100 mm long, bent along its length and width.
ObjectModel leaf_model(int cells, Rng rng) {
  const double length_m = uniform(rng, 0.06, 0.1), width_m = uniform(rng, 0.02, 0.04);
  const double droop = uniform(rng, 0.5, 2), fold = uniform(rng, 0, 4);
  ObjectModel model;
  model.name = "leaf";
  for (int j = 0; j <= cells; ++j) {
    const double along = static_cast<double>(j) / cells;
    const double half_m = 0.5 * width_m * std::sin(std::numbers::pi * (0.05 + 0.9 * along));
    for (int i = 0; i <= cells; ++i) {
      const double across_m = half_m * (2.0 * i / cells - 1);
      model.mesh.vertices_m.emplace_back(
          length_m * along, across_m,
          fold * across_m * across_m / width_m - droop * length_m * along * along / 4);
    }
  }
  const auto n = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t j = 0; j + 1 < n; ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i;
      model.mesh.triangles.push_back({a, a + n, a + 1});
      model.mesh.triangles.push_back({a + 1, a + n, a + n + 1});
    }
  }
  return model;
}

Eigen::Vector3d in_ball(Rng& rng) {
  for (;;) {
    const Eigen::Vector3d p(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
    if (p.squaredNorm() <= 1) return p;
  }
}

/// Times of one piece of work, run again and again.
struct Times {
  std::vector<double> wall_s, cpu_s;

  template <class Function>
  void add(const Function& function, bool is_measured) {
    const std::clock_t cpu = std::clock();
    const auto wall = std::chrono::steady_clock::now();
    function();
    if (!is_measured) return;
    wall_s.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count());
    cpu_s.push_back(static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
  }
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A number of /proc/self/status in MB, or NaN.
double status_mb(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    double kilobytes = 0;
    if (word == key && file >> kilobytes) return kilobytes / 1024;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The peak starts again from what the process has now. @returns whether the system does it.
bool reset_peak() {
  malloc_trim(0);
  std::ofstream file("/proc/self/clear_refs");
  file << "5" << std::flush;
  return file.good();
}

}  // namespace

Scene leaf_cloud(const LeafCloud& cloud, std::uint64_t seed) {
  if (cloud.leaves < 1 || cloud.models < 1 || cloud.cells < 1 || cloud.specimens > cloud.leaves) {
    throw std::invalid_argument("leaf cloud: " + std::to_string(cloud.leaves) + " leaves, " +
                                std::to_string(cloud.models) + " models, " +
                                std::to_string(cloud.cells) + " cells, " +
                                std::to_string(cloud.specimens) + " specimens do not make one");
  }
  const Rng rng(seed);
  Scene scene;
  scene.name = "leaf cloud";
  scene.materials.emplace_back();
  for (int i = 0; i < cloud.models; ++i)
    scene.models.push_back(
        leaf_model(cloud.cells, rng.fork("model").fork(static_cast<std::uint64_t>(i))));
  for (int i = 0; i < cloud.leaves; ++i) {
    Rng own = rng.fork("leaf").fork(static_cast<std::uint64_t>(i));
    Instance instance;
    instance.id = i;
    instance.name = "leaf " + std::to_string(i);
    instance.is_specimen = i < cloud.specimens;
    instance.model = i % cloud.models;
    instance.world_from_object.rotation =
        Eigen::AngleAxisd(uniform(own, 0, std::numbers::pi), in_ball(own).normalized());
    instance.world_from_object.translation_m = in_ball(own);
    scene.instances.push_back(instance);
  }
  return scene;
}

TrueView leaf_cloud_view() {
  TrueView view;
  view.camera.width_px = 640;
  view.camera.height_px = 480;
  view.camera.fx_px = view.camera.fy_px = 600;
  view.camera.cx_px = 319.5;
  view.camera.cy_px = 239.5;
  view.camera_from_world = look_at({0.2, -1.6, 0.3}, {0, 0, 0});
  view.camera_from_world_end = view.camera_from_world;
  return view;
}

LeafCloudSpeed measure_leaf_cloud(const LeafCloud& cloud, int repeats) {
  if (repeats < 1) throw std::invalid_argument("leaf cloud: repeats = " + std::to_string(repeats));
  const Scene scene = leaf_cloud(cloud, 1);
  const RayScene rays(scene);
  const TrueView view = leaf_cloud_view();
  const PreparedRays prepared = prepare_rays(rays, view);
  const TruthNeeds centres{.depth = true, .normal = true, .instance = true};
  TruthNeeds masks = centres, shares = centres;
  masks.visibility = true;
  shares.shares = true;
  std::int64_t hits = 0;
  Times raw, one, two, three;
  const auto truth = [&](const TruthNeeds& needs) {
    return [&] {
      hits +=
          render_truth(rays, scene, view, prepared, needs, {.share_samples = 4}).depth_m.width();
    };
  };
  for (int i = -1; i < repeats; ++i) {  // one unmeasured round
    raw.add([&] { hits += cast_packets(rays, prepared); }, i >= 0);
    one.add(truth(centres), i >= 0);
    two.add(truth(masks), i >= 0);
    three.add(truth(shares), i >= 0);
  }
  if (hits <= 0) throw std::logic_error("leaf cloud: nothing was cast");
  const auto medians = [](const Times& t) {
    return ImageSeconds{median(t.wall_s), median(t.cpu_s)};
  };
  LeafCloudSpeed speed;
  speed.triangles = std::int64_t{2} * cloud.cells * cloud.cells * cloud.leaves;
  speed.raw = medians(raw);
  speed.centres = medians(one);
  speed.masks = medians(two);
  speed.shares = medians(three);
  return speed;
}

double leaf_cloud_memory_mb(const LeafCloud& cloud) {
  if (!reset_peak()) return std::numeric_limits<double>::quiet_NaN();
  const double before_mb = status_mb("VmRSS:");
  const Scene scene = leaf_cloud(cloud, 1);
  const RayScene rays(scene);
  TrueView view = leaf_cloud_view();
  view.camera = resized(view.camera, 64, 48);
  const TruthImages truth = render_truth(rays, scene, view, {.depth = true, .instance = true});
  if (truth.depth_m.empty()) throw std::logic_error("leaf cloud: no image");
  return status_mb("VmHWM:") - before_mb;
}

}  // namespace cousin
