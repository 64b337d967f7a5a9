#include "benchmarks/suites/seedlings/field_shape.h"

#include <string>
#include <utility>

#include "benchmarks/loop/score_views.h"
#include "perception/splats/splat_geometry.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

/// Of a centre that counts: as of the Seeds paper's way (SeedsSplatConfig::least_opacity).
constexpr double kLeastOpacity = 0.05;

SceneTruth truth_of(const SeedlingsSample& sample, std::uint64_t seed, const FieldViews& views) {
  SceneTruth truth;
  truth.scene = build_scene(sample_config(sample).scene, {.seed = seed, .index = sample.number});
  for (const SampleView* view : views.train) {
    TrueView still;
    still.frame = view->photograph.frame;
    still.camera = view->photograph.full.camera;
    still.camera_from_world = still.camera_from_world_end = view->photograph.camera_from_world;
    truth.views.push_back(still);
  }
  return truth;
}

Cloud fused(const SplatModel& splats, const FieldViews& views) {
  std::vector<SplatViewpoint> from;
  for (const SampleView* view : views.train)
    from.push_back({view->photograph.full.camera, view->photograph.camera_from_world});
  return fused_splat_cloud(render_splat_depths(splats, from));
}

}  // namespace

std::vector<ScoreRow> shape_rows(const SeedlingsSample& sample, std::uint64_t seed,
                                 const SplatModel& splats, const FieldViews& views,
                                 const ScoreRow& base) {
  const SceneTruth truth = truth_of(sample, seed, views);
  std::vector<ScoreRow> rows;
  const auto add = [&](const auto& cloud_of, const std::string& of) {
    ScoreRow row = base;
    row.method += of;
    Estimate estimate;
    StageTiming training;
    training.stage = "splats";
    training.wall_s = base.wall_s;
    training.cpu_s = base.cpu_s;
    const StageClock clock("cloud");
    estimate.cloud = cloud_of();
    estimate.timings = {training, clock.finish()};
    row.wall_s += estimate.timings.back().wall_s;
    row.cpu_s += estimate.timings.back().cpu_s;
    for (ScoreRow& one : score_views(truth, estimate, PoseAlignment::none, true, row))
      rows.push_back(std::move(one));
  };
  add([&] { return fused(splats, views); }, ", depths");
  add([&] { return splat_centres(splats, kLeastOpacity); }, ", centres");
  return rows;
}

}  // namespace cousin
