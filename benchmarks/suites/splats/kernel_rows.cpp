#include "benchmarks/suites/splats/kernel_rows.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "benchmarks/suites/splats/core_time.h"
#include "perception/splats/splat_frame.h"
#include "perception/splats/splat_trainer.h"
#include "sim/types/rng.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr int kSplats = 26000, kWidth = 400, kHeight = 300, kSteps = 40;
constexpr double kForwardLimit_s = 3e-9, kBackwardLimit_s = 6e-9, kStepLimit_s = 0.03;
constexpr std::array<float, 3> kBlack{};

/// Gaussians in a cube of 2 m; about 30 blend in a pixel of its image, as in photographs.
SplatModel cube_of_splats(std::uint64_t seed) {
  Rng rng = Rng(seed).fork("cube of splats");
  SplatModel model;
  model.splats.resize(kSplats);
  for (Splat& s : model.splats) {
    for (int k = 0; k < 3; ++k) {
      s.centre_m[k] = static_cast<float>(uniform(rng, -1, 1));
      s.log_scale[k] = static_cast<float>(std::log(0.0165) + 0.5 * normal(rng));
      s.sh_dc[static_cast<std::size_t>(k)] = static_cast<float>(normal(rng));
    }
    for (int k = 0; k < 4; ++k) s.rotation_wxyz[k] = static_cast<float>(normal(rng));
    s.opacity_logit = static_cast<float>(1.5 * normal(rng));
    for (float& c : s.sh_rest) c = static_cast<float>(0.1 * normal(rng));
  }
  return model;
}

Camera camera_400() {
  Camera camera;
  camera.width_px = kWidth;
  camera.height_px = kHeight;
  camera.fx_px = camera.fy_px = 400;
  camera.cx_px = 199.5;
  camera.cy_px = 149.5;
  return camera;
}

/// Pixels times Gaussians whose alpha is at least 1/255 and that a pixel takes.
std::int64_t blended_pairs(const SplatFrame& frame) {
  const TileLists& lists = frame.lists;
  std::int64_t pairs = 0;
  for (int y = 0; y < frame.camera.height_px; ++y) {
    for (int x = 0; x < frame.camera.width_px; ++x) {
      const auto tile =
          static_cast<std::size_t>(y / SplatTile::side * lists.tiles_across + x / SplatTile::side);
      float left = 1;
      for (std::uint32_t e = lists.tile_begin[tile]; e < lists.tile_begin[tile + 1]; ++e) {
        const ProjectedSplat& s = frame.projected[lists.tile_splat[e]];
        const float dx = static_cast<float>(x) - s.x_px, dy = static_cast<float>(y) - s.y_px;
        const float t = dx - s.tilt * dy;
        const float log2 = s.log2_opacity + s.across * t * t + s.down * dy * dy;
        if (log2 < SplatLimits::smallest_log2_alpha) continue;
        left *= 1 - std::min(SplatLimits::largest_alpha, std::exp2(log2));
        if (left < SplatLimits::least_transmittance) break;
        ++pairs;
      }
    }
  }
  return pairs;
}

ScoreRow row_of(const std::string& case_name, const std::string& method, const std::string& metric,
                double value, const std::string& unit, std::int64_t n) {
  ScoreRow row;
  row.suite = "splats";
  row.scene = "cube of splats";
  row.case_name = case_name;
  row.method = method;
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  return row;
}

void pair_rows(std::vector<ScoreRow>& rows, const SplatKernels& kernels, const SplatModel& model,
               const Pose& pose) {
  const SplatPlanes planes = to_planes(model.splats);
  SplatFrame frame;
  draw_splats(kernels, planes, 3, splat_camera(camera_400(), pose, model.origin_in_world_m, 0.01),
              kBlack, SplatDepths::none, frame);
  ColorPlanes ones;
  for (Image<float>& channel : ones.channel) channel = Image<float>(kWidth, kHeight, 1.0F);
  blend_gradients(kernels, ones, kBlack, frame);  // sizes the partials

  BlendGradientTask task;
  task.blend = blend_task(frame, kBlack);
  for (std::size_t k = 0; k < 3; ++k) task.color_gradient[k] = ones.channel[k].data();
  task.partials = frame.partials.data();
  const int tiles = frame.lists.tiles_across * frame.lists.tiles_down;
  const std::int64_t pairs = blended_pairs(frame);
  const double forward = best_core_seconds([&] {
    for (int tile = 0; tile < tiles; ++tile) kernels.blend(task.blend, tile);
  });
  const double backward = best_core_seconds([&] {
    for (int tile = 0; tile < tiles; ++tile) kernels.blend_gradient(task, tile);
  });
  const std::string name = kernels.name;
  const bool held = &kernels == &best_splat_kernels();
  const auto add = [&](const char* metric, double value, double limit) {
    const std::string unlimited = std::string("seconds.") + metric;
    ScoreRow row = row_of("26,000 Gaussians, 400 x 300", name, unlimited, value, "s/pair", pairs);
    if (held) {
      row.metric +=
          " (at most " + std::to_string(static_cast<int>(std::lround(limit * 1e9))) + " ns)";
      row = limited(row, at_most(limit));
    }
    rows.push_back(row);
  };
  add("forward", forward / static_cast<double>(pairs), kForwardLimit_s);
  add("backward", backward / static_cast<double>(pairs), kBackwardLimit_s);
  if (held) {
    rows.push_back(row_of("26,000 Gaussians, 400 x 300", name, "pairs a pixel",
                          static_cast<double>(pairs) / (kWidth * kHeight), "1", kWidth * kHeight));
  }
}

void step_row(std::vector<ScoreRow>& rows, const SplatModel& model, const Pose& pose) {
  // The photograph is the cube with other colours: every parameter has a gradient.
  SplatModel other = model;
  for (Splat& s : other.splats) std::swap(s.sh_dc[0], s.sh_dc[2]);
  std::vector<SplatView> views(1);
  views[0].camera_from_world = pose;
  SplatViewLevel level;
  level.camera = camera_400();
  level.color = render_splats(other, level.camera, pose).color;
  views[0].full = std::move(level);
  SplatTrainConfig config;
  config.steps = 1000;
  config.sh_degree_every = 1;
  config.growth = SplatGrowth::fixed;
  config.quarter_until = config.half_until = 0;
  SplatTrainer trainer(views, config, start_training(model));
  std::vector<double> seconds;
  const StageClock clock("steps");
  for (int i = 0; i < kSteps; ++i) {
    const auto before = std::chrono::steady_clock::now();
    trainer.step();
    seconds.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count());
  }
  const StageTiming timing = clock.finish();
  std::nth_element(seconds.begin(), seconds.begin() + kSteps / 2, seconds.end());
  const double median = seconds[kSteps / 2];
  ScoreRow row = row_of("26,000 Gaussians, 400 x 300", best_splat_kernels().name,
                        "seconds.step (at most 0.03 s)", median, "s", kSteps);
  row.wall_s = timing.wall_s / kSteps;
  row.cpu_s = timing.cpu_s / kSteps;
  rows.push_back(limited(row, at_most(kStepLimit_s)));
}

}  // namespace

std::vector<ScoreRow> splat_kernel_rows(std::uint64_t seed) {
  const SplatModel model = cube_of_splats(seed);
  const Pose pose = look_at({2.6, 0.9, 1.6}, {0, 0, 0});
  std::vector<ScoreRow> rows;
  pair_rows(rows, best_splat_kernels(), model, pose);
  if (&best_splat_kernels() != &portable_splat_kernels()) {
    pair_rows(rows, portable_splat_kernels(), model, pose);
  }
  step_row(rows, model, pose);
  for (ScoreRow& row : rows) row.seed = seed;
  return rows;
}

}  // namespace cousin
