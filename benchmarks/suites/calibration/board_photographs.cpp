#include "benchmarks/suites/calibration/board_photographs.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <variant>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/loop/simulate.h"
#include "scenes/boards/boards_scene.h"
#include "sim/render/radiance_pass.h"
#include "sim/sensors/rig_capture.h"

namespace cousin {
namespace {

/// The triangles of one part, with the vertices they use.
ObjectModel part_of(const ObjectModel& model, std::size_t part) {
  ObjectModel result;
  result.name = model.name + " " + model.part_names[part];
  std::vector<std::int64_t> place(model.mesh.vertices_m.size(), -1);
  for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
    if (model.triangle_part[t] != part) continue;
    std::array<std::uint32_t, 3> triangle = model.mesh.triangles[t];
    for (std::uint32_t& v : triangle) {
      std::int64_t& to = place[v];
      if (to < 0) {
        to = static_cast<std::int64_t>(result.mesh.vertices_m.size());
        result.mesh.vertices_m.push_back(model.mesh.vertices_m[v]);
        if (!model.vertex_normals.empty()) result.vertex_normals.push_back(model.vertex_normals[v]);
      }
      v = static_cast<std::uint32_t>(to);
    }
    result.mesh.triangles.push_back(triangle);
  }
  return result;
}

/// The scene as the light's table takes it: no grain and stains on what stands about, and an
/// instance for each part of a model, as one has one material there.
Scene plain(Scene scene) {
  for (Material& material : scene.materials) material.noise.reset();
  std::vector<Instance> instances;
  int id = 0;
  for (const Instance& whole : scene.instances) id = std::max(id, whole.id + 1);
  for (const Instance& whole : scene.instances) {
    if (whole.part_materials.empty()) {
      instances.push_back(whole);
      continue;
    }
    const ObjectModel model = scene.models.at(static_cast<std::size_t>(whole.model));
    for (std::size_t part = 0; part < model.part_names.size(); ++part) {
      Instance piece = whole;
      piece.id = part == 0 ? whole.id : id++;
      piece.model = static_cast<int>(scene.models.size());
      piece.material = whole.part_materials[part];
      piece.part_materials.clear();
      piece.is_specimen = false;
      scene.models.push_back(part_of(model, part));
      if (scene.models.back().mesh.triangles.empty())
        scene.models.pop_back();
      else
        instances.push_back(std::move(piece));
    }
  }
  scene.instances = std::move(instances);
  return scene;
}

const Instance& board_of(const Scene& scene) {
  const auto found =
      std::find_if(scene.instances.begin(), scene.instances.end(), [&](const Instance& instance) {
        return scene.models.at(static_cast<std::size_t>(instance.model)).name == "board";
      });
  if (found == scene.instances.end()) throw std::logic_error("the boards scene has no board");
  return *found;
}

}  // namespace

namespace {

RunConfig boards_run(const std::vector<std::string>& assignments) {
  RunConfig run = run_config(boards_row(), assignments);
  if (run.scene.get_if<BoardsSceneConfig>()->place == "hand")
    throw std::invalid_argument("place = hand: a moving board's light cannot be kept; render it");
  return run;
}

RadianceConfig radiance_config(int edge_samples) {
  RadianceConfig c;
  c.edge_samples = edge_samples;
  c.irradiance_samples = 64;
  c.max_bounces = 2;
  c.board_texel_m = 0.01;
  return c;
}

bool is_same(const Pose& a, const Pose& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation_m == b.translation_m;
}

/// Whether both see the same light.
bool is_same(const TrueView& a, const TrueView& b) {
  return a.camera == b.camera && is_same(a.camera_from_world, b.camera_from_world) &&
         is_same(a.camera_from_world_end, b.camera_from_world_end) &&
         a.exposure_s == b.exposure_s && a.readout_s == b.readout_s &&
         a.aperture_radius_m == b.aperture_radius_m && a.focus_m == b.focus_m;
}

}  // namespace

struct BoardPhotographs::Impl {
  RunConfig config;
  Scene scene;
  RayScene rays;
  std::vector<RigCapture> rigs;  ///< one a sensor
  RadianceConfig radiance;
  IrradianceCache light;
  Streams streams;
  std::vector<Eigen::Vector3d> points_in_world_m;

  Impl(const RunConfig& run, Scene built, std::uint64_t seed,
       const BoardPhotographsConfig& photographs)
      : config(run),
        scene(plain(built)),
        rays(scene),
        radiance(radiance_config(photographs.edge_samples)),
        light(rays, scene, radiance, Rng(seed).fork("light")) {
    streams.color = true;
    const Instance& board = board_of(built);
    for (const Keypoint& keypoint :
         built.models.at(static_cast<std::size_t>(board.model)).keypoints)
      points_in_world_m.push_back(board.world_from_object * keypoint.in_object_m);
  }

  void add_rig(const RunConfig& run, std::uint64_t seed) {
    rigs.emplace_back(run.rig, run.capture, rays, scene, Rng(seed).fork("photographs"));
    const std::vector<SensorViews>&first = rigs.front().views(), &own = rigs.back().views();
    bool fits = first.size() == own.size();
    for (std::size_t c = 0; fits && c < first.size(); ++c) {
      fits = std::equal(first[c].views.begin(), first[c].views.end(), own[c].views.begin(),
                        own[c].views.end(),
                        [](const TrueView& a, const TrueView& b) { return is_same(a, b); });
    }
    if (!fits) {
      throw std::invalid_argument("board photographs: sensor " + std::to_string(rigs.size() - 1) +
                                  " sees other light than the first: lens, places and shutter "
                                  "must be the same");
    }
  }
};

BoardPhotographs::BoardPhotographs(const std::vector<std::string>& assignments, std::uint64_t seed,
                                   const BoardPhotographsConfig& config) {
  if (config.sensors.empty()) throw std::invalid_argument("board photographs: no sensor");
  const RunConfig run = boards_run(assignments);
  impl_ = std::make_unique<Impl>(run, built_scene(run, seed, 0), seed, config);
  for (const std::vector<std::string>& sensor : config.sensors) {
    std::vector<std::string> all = assignments;
    all.insert(all.end(), sensor.begin(), sensor.end());
    impl_->add_rig(boards_run(all), seed);
  }
}
BoardPhotographs::~BoardPhotographs() = default;
BoardPhotographs::BoardPhotographs(BoardPhotographs&&) noexcept = default;

const CalibrationTarget& BoardPhotographs::target() const {
  return impl_->config.scene.get_if<BoardsSceneConfig>()->target;
}

int BoardPhotographs::size() const {
  return static_cast<int>(impl_->rigs.front().views().front().views.size());
}

Frame BoardPhotographs::take(int view) const { return take_each(view, 1).front(); }

std::vector<Frame> BoardPhotographs::take_each(int view, std::size_t sensors) const {
  const Impl& impl = *impl_;
  std::vector<Image<Rgbf>> seen;  // by each camera of the first sensor
  std::vector<Frame> frames;
  for (std::size_t s = 0; s < std::min(sensors, impl.rigs.size()); ++s) {
    std::size_t camera = 0;
    const auto radiance = [&](const TrueView& of, const Rng& rng) {
      if (s == 0)
        seen.push_back(render_radiance(impl.rays, impl.scene, impl.light, of, impl.radiance, rng));
      return seen.at(camera++);
    };
    frames.push_back(impl.rigs[s].take(view, impl.streams, radiance).frame);
  }
  return frames;
}

const std::vector<SensorViews>& BoardPhotographs::truth() const {
  return impl_->rigs.front().views();
}

const std::vector<Eigen::Vector3d>& BoardPhotographs::points_in_world_m() const {
  return impl_->points_in_world_m;
}

}  // namespace cousin
