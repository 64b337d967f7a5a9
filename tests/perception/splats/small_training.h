#pragma once

#include <cmath>
#include <cstring>
#include <vector>

#include "perception/splats/splat_render.h"
#include "perception/splats/train_splats.h"
#include "tests/perception/splats/random_splats.h"

namespace cousin {

/// What the photographs show.
inline SplatModel true_model() {
  SplatModel model;
  model.splats = random_splats(60, 11, 0.12);
  for (Splat& s : model.splats) s.sh_rest.fill(0);
  return model;
}

inline SplatViewLevel photograph(const SplatModel& model, const Camera& camera, const Pose& pose) {
  SplatViewLevel level;
  level.camera = camera;
  level.color = render_splats(model, camera, pose).color;
  return level;
}

/// Photographs from around.
inline std::vector<SplatView> views_of(const SplatModel& model, int count) {
  std::vector<SplatView> views;
  for (int i = 0; i < count; ++i) {
    SplatView view;
    view.camera_from_world =
        look_at({1.5 * std::cos(0.7 * i), 1.5 * std::sin(0.7 * i), 0.5 + 0.1 * i}, {0, 0, 0});
    view.full = photograph(model, pinhole(64, 48, 60), view.camera_from_world);
    views.push_back(std::move(view));
  }
  return views;
}

/// Grey, faint Gaussians to begin with.
inline SplatModel start_model(int count) {
  SplatModel model;
  model.splats = random_splats(count, 12, 0.1);
  for (Splat& s : model.splats) {
    s.sh_rest.fill(0);
    s.sh_dc.fill(0);
    s.opacity_logit = -2;
  }
  return model;
}

/// 160 steps to at most 300 Gaussians: a fraction of a second.
inline SplatTrainConfig quick_config(SplatGrowth growth) {
  SplatTrainConfig config;
  config.steps = 160;
  config.growth = growth;
  config.most_splats = 300;
  config.grow_every = 20;
  config.half_until = 0.3;
  config.report_every = 20;
  config.gradient_limit = 1e-5;
  return config;
}

inline bool same_bytes(const SplatModel& a, const SplatModel& b) {
  return a.splats.size() == b.splats.size() &&
         std::memcmp(a.splats.data(), b.splats.data(), a.splats.size() * sizeof(Splat)) == 0 &&
         a.views_seen == b.views_seen;
}

}  // namespace cousin
