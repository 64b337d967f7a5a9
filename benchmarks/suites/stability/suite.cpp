#include "benchmarks/suites/stability/suite.h"

#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>

#include "benchmarks/suites/stability/bundle_cases.h"
#include "benchmarks/suites/stability/calibration_cases.h"
#include "benchmarks/suites/stability/contact_cases.h"
#include "benchmarks/suites/stability/depth_cases.h"
#include "benchmarks/suites/stability/geometry_cases.h"
#include "benchmarks/suites/stability/lens_cases.h"
#include "benchmarks/suites/stability/mesh_ray_cases.h"
#include "benchmarks/suites/stability/ngp_cases.h"
#include "benchmarks/suites/stability/path_cases.h"
#include "benchmarks/suites/stability/ray_cases.h"
#include "benchmarks/suites/stability/sfm_cases.h"
#include "benchmarks/suites/stability/splat_cases.h"
#include "benchmarks/suites/stability/splat_train_cases.h"
#include "benchmarks/suites/stability/stem_cases.h"
#include "scenes/seeds/seeds_scene.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

/// Rays from inside one seed of each cultivar; every specimen's surface must be closed to them.
std::vector<StabilityRow> watertight_seeds(bool quick) {
  const std::int64_t rays = quick ? 200'000 : 10'000'000;
  std::vector<StabilityRow> rows;
  for (const std::string& cultivar : cultivar_names()) {
    const SeedModel seed = make_seed(cultivar, SizeSpread::literature, Rng(1).fork(cultivar));
    rows.push_back(
        watertight_case("seed of " + cultivar, seed.model.mesh, rays, Rng(2).fork(cultivar)));
  }
  return rows;
}

struct Module {
  const char* name;
  std::function<std::vector<StabilityRow>()> run;
};

std::vector<Module> stability_modules(bool quick) {
  RayCasesConfig rays;
  if (quick) {
    rays.watertight_rays = 500'000;
    rays.offset_rays = 4'000;
  }
  return {{"geometry", geometry_cases},
          {"lenses and light", lens_cases},
          {"bundles", [quick] { return bundle_cases(quick); }},
          {"calibration", calibration_cases},
          {"structure from motion", sfm_cases},
          {"depths and fusion", depth_cases},
          {"rays", [rays] { return ray_cases(rays, Rng(1)); }},
          {"rays at bad meshes", mesh_ray_cases},
          {"light at its limits", [quick] { return path_cases(quick); }},
          {"watertight seeds", [quick] { return watertight_seeds(quick); }},
          {"splats", splat_cases},
          {"training of splats", [quick] { return splat_train_cases(quick); }},
          {"radiance fields", [quick] { return ngp_cases(quick); }},
          {"contacts", [quick] { return contact_cases(quick); }},
          {"stems", [quick] { return stem_cases(quick); }}};
}

/// @param base  what all rows of the module share
ScoreRow score_of(const StabilityRow& row, const ScoreRow& base) {
  ScoreRow score = base;
  score.case_name = row.case_name;
  char limit[64];
  std::snprintf(limit, sizeof limit, " (%s %.3g)", row.upper ? "at most" : "at least", row.limit);
  const bool is_held = !std::isnan(row.limit);
  score.metric = is_held ? row.quantity + limit : row.quantity;
  score.value = row.value;
  score.unit = row.unit.empty() ? "1" : row.unit;
  score.n = 1;
  if (is_held) {
    score = limited(score, row.upper ? at_most(row.limit) : at_least(row.limit));
  } else {
    score.status = std::isnan(row.value) ? ScoreStatus::not_built : ScoreStatus::ok;
  }
  return score;
}

}  // namespace

ScoreFile stability_suite(bool quick, const Progress& progress) {
  const std::vector<Module> modules = stability_modules(quick);
  ScoreFile file;
  for (std::size_t i = 0; i < modules.size(); ++i) {
    if (progress) progress(modules[i].name, static_cast<int>(i), static_cast<int>(modules.size()));
    const StageClock clock(modules[i].name);
    std::vector<StabilityRow> rows;
    ScoreRow base;
    base.suite = "stability";
    base.scene = modules[i].name;
    base.method = "ours";
    try {
      rows = modules[i].run();
    } catch (const std::exception& error) {
      base.case_name = modules[i].name;
      base.metric = error.what();
      base.status = ScoreStatus::error;
      file.scores.push_back(base);
      continue;
    }
    for (const StabilityRow& row : rows) file.scores.push_back(score_of(row, base));
    ScoreRow seconds = base;
    seconds.case_name = modules[i].name;
    seconds.metric = "seconds";
    seconds.value = seconds.wall_s = clock.finish().wall_s;
    seconds.unit = "s";
    seconds.n = static_cast<std::int64_t>(rows.size());
    file.scores.push_back(std::move(seconds));
  }
  return file;
}

}  // namespace cousin
