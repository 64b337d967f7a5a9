#include "benchmarks/suites/scenes/strawberry_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "benchmarks/loop/rest_folder.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/score/order_statistics.h"
#include "benchmarks/suites/scenes/leaf_crossing.h"
#include "scenes/strawberries/strawberries_scene.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/truth_io.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr double kBuild_s = 1, kSettle_s = 10, kOverlap_m = 5e-4, kCrossing = 0.01;
constexpr double kImage_s = 75 * 60 / 1000.0;
constexpr int kDraws = 2000;  // stretches whose fruits are counted, without meshes

ScoreRow row_of(const std::string& case_name, const std::string& metric, const char* unit,
                std::uint64_t seed) {
  ScoreRow row;
  row.suite = "scenes";
  row.scene = "strawberries";
  row.case_name = case_name;
  row.method = "ours";
  row.metric = metric;
  row.unit = unit;
  row.seed = seed;
  return row;
}

/// Fruits of many stretches and their maturity, as scenes ask for them.
void paper_rows(std::vector<ScoreRow>& rows, std::uint64_t seed) {
  const StrawberriesSceneConfig config;
  std::array<std::int64_t, 3> counts{};
  std::int64_t all = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Rng rng = attempt_rng(stretch_rng(seed, i), 0);
    const Stand stand = draw_stand(config.stand, config.bed, rng);
    const Ripening colours{0,
                           Rng(seed).fork("colours of a draw").fork(static_cast<std::uint64_t>(i))};
    for (std::size_t t = 0; t < stand.trusses.size(); ++t) {
      for (const double red :
           asked_red_shares(stand.trusses[t], truss_rng(rng, t), ripening_of(stand, colours, t))) {
        ++counts[static_cast<std::size_t>(maturity_of(red))];
        ++all;
      }
    }
  }
  constexpr double kMean = 8627.0 / 1158;
  ScoreRow row =
      row_of("as the paper's images", "fruits a scene (8627 in 1158: 7.45 within 5 %)", "1", seed);
  row.n = kDraws;
  row.value = static_cast<double>(all) / kDraws;
  rows.push_back(limited(row, about(kMean, 0.05 * kMean)));
  constexpr std::array<const char*, 3> kNames = {
      "share of low maturity (4776 of 8627: 0.554 +- 0.05)",
      "share of medium maturity (2452 of 8627: 0.284 +- 0.05)",
      "share of high maturity (1399 of 8627: 0.162 +- 0.05)"};
  constexpr std::array<double, 3> kPaper = {4776.0 / 8627, 2452.0 / 8627, 1399.0 / 8627};
  for (std::size_t k = 0; k < 3; ++k) {
    row.metric = kNames[k];
    row.n = all;
    row.value = static_cast<double>(counts[k]) / static_cast<double>(all);
    rows.push_back(limited(row, about(kPaper[k], 0.05)));
  }
}

/// Plants before the camera.
std::vector<const Instance*> near_row(const Scene& scene) {
  std::vector<const Instance*> plants;
  for (const Instance& instance : scene.instances) {
    if (instance.category == "strawberry plant" && instance.name.starts_with("plant "))
      plants.push_back(&instance);
  }
  return plants;
}

/// Settles stretches into the folder and builds them; overlaps of all.
void stretch_rows(std::vector<ScoreRow>& rows, const StrawberriesSceneConfig& config,
                  std::uint64_t seed, int count) {
  std::vector<double> settle_s, build_s;
  double overlap_m = 0, leaf_m = -1, sepal_m = -1;
  SurfaceCrossing crossing;
  const RestFolder kept(config.cache);
  for (int i = 0; i < count; ++i) {
    const StageClock settling("settle");
    const StandRest rest = stand_at_rest(config, seed, i, &kept);
    settle_s.push_back(settling.finish().wall_s);
    const StageClock building("build");
    const Scene scene = build_strawberries_scene(config, rest, stretch_rng(seed, i), Rng(seed));
    build_s.push_back(building.finish().wall_s);
    overlap_m = std::max(overlap_m, rest.sag.max_penetration_m);
    leaf_m = std::max(leaf_m, plants_in_fruits_m(scene));
    sepal_m = std::max(sepal_m, sepals_in_fruits_m(scene));
    const SurfaceCrossing own = leaf_crossing(scene, near_row(scene));
    crossing.area_m2 += own.area_m2;
    crossing.crossed_m2 += own.crossed_m2;
  }
  const auto add = [&](const char* metric, const char* unit, double value, double limit) {
    ScoreRow row = row_of("stretch of bed", metric, unit, seed);
    row.n = count;
    row.value = value;
    rows.push_back(limited(row, at_most(limit)));
  };
  add("seconds.settle, longest (at most 10)", "s",
      *std::max_element(settle_s.begin(), settle_s.end()), kSettle_s);
  add("seconds.build without settling, median (at most 1)", "s", quantile(build_s, 0.5), kBuild_s);
  add("deepest overlap of fruits, stalks and bed (at most 0.0005)", "m", overlap_m, kOverlap_m);
  add("deepest overlap of leaves and petioles with fruits (at most 0.0005; negative: distance)",
      "m", leaf_m, kOverlap_m);
  add("deepest overlap of sepals with fruits beside theirs (at most 0.0005; negative: distance)",
      "m", sepal_m, kOverlap_m);
  add("leaf_crossing.share of the near row's leaves (at most 0.01)", "1", crossing.share(),
      kCrossing);
}

/// Seconds of an image's steps.
struct ImageSeconds {
  double build = 0, image = 0, truth = 0, files = 0, cpu = 0;
  double all() const { return build + image + truth + files; }
};

/// One scene of one image, made and written as `cousin render` does.
ImageSeconds make_image(const RunConfig& config, std::uint64_t seed, int index,
                        const fs::path& folder, TruthImages& images) {
  ImageSeconds s;
  const StageClock building("build");
  const Simulation simulation(config, seed, index);
  const StageTiming built = building.finish();
  const StageClock taking("image");
  Capture capture = simulation.capture_header();
  capture.frames.push_back(simulation.take(0, planned_streams(config)).frame);
  const StageTiming taken = taking.finish();
  const StageClock looking("truth");
  TruthNeeds needs;
  needs.visibility = needs.keypoints = true;
  SceneTruth truth = simulation.scene_truth();
  images = simulation.truth(0, needs);
  const StageTiming looked = looking.finish();
  const StageClock writing("files");
  write_capture(folder, capture);
  truth.images = {images};
  write_truth(folder, truth);
  const StageTiming written = writing.finish();
  s.build = built.wall_s;
  s.image = taken.wall_s;
  s.truth = looked.wall_s;
  s.files = written.wall_s;
  s.cpu = built.cpu_s + taken.cpu_s + looked.cpu_s + written.cpu_s;
  return s;
}

void image_rows(std::vector<ScoreRow>& rows, const RunConfig& config, std::uint64_t seed, int count,
                const fs::path& folder) {
  std::vector<ImageSeconds> seconds;
  std::vector<double> sides_px;
  int fruits = 0;
  for (int i = 0; i < count; ++i) {
    TruthImages images;
    seconds.push_back(make_image(config, seed, i, folder / std::to_string(i), images));
    for (const InstanceVisibility& seen : images.visibility) {
      if (seen.pixels_visible == 0) continue;
      ++fruits;
      sides_px.push_back(std::sqrt(static_cast<double>(seen.box_width) * seen.box_height));
    }
  }
  const auto mean_of = [&](const auto& part) {
    double sum = 0;
    for (const ImageSeconds& s : seconds) sum += part(s);
    return sum / count;
  };
  ScoreRow row =
      row_of("640 x 640, 4 samples, labelled", "seconds an image (at most 4.5)", "s", seed);
  row.n = count;
  row.value = row.wall_s = mean_of([](const ImageSeconds& s) { return s.all(); });
  row.cpu_s = mean_of([](const ImageSeconds& s) { return s.cpu; });
  rows.push_back(limited(row, at_most(kImage_s)));
  row.wall_s = row.cpu_s = ScoreRow::kNone;
  row.status = ScoreStatus::ok;
  const auto part = [&](const char* metric, double value, const char* unit) {
    row.metric = metric;
    row.value = value;
    row.unit = unit;
    rows.push_back(row);
  };
  part("seconds.build", mean_of([](const ImageSeconds& s) { return s.build; }), "s");
  part("seconds.image and sensor", mean_of([](const ImageSeconds& s) { return s.image; }), "s");
  part("seconds.truth", mean_of([](const ImageSeconds& s) { return s.truth; }), "s");
  part("seconds.files", mean_of([](const ImageSeconds& s) { return s.files; }), "s");
  part("fruits seen an image", static_cast<double>(fruits) / count, "1");
  row.n = fruits;
  part("side of a fruit's box, median (the paper gives none)",
       sides_px.empty() ? ScoreRow::kNone : quantile(sides_px, 0.5), "px");
}

}  // namespace

std::vector<ScoreRow> strawberry_rows(
    std::uint64_t seed, bool quick,
    const std::function<void(const std::string&, int, int)>& progress) {
  std::vector<ScoreRow> rows;
  const auto tell = [&](const char* what, int done) {
    if (progress) progress(what, done, 3);
  };
  tell("strawberries: fruits and maturity", 0);
  paper_rows(rows, seed);
  const ScratchFolder scratch("cousin-strawberries");
  StrawberriesSceneConfig scene;
  scene.views = 1;
  scene.plants = quick ? 3 : 12;
  scene.cache = scratch.path() / "stands";
  if (!can_settle()) {
    ScoreRow row = row_of("stretch of bed", "not built in: MuJoCo (WITH_MUJOCO=OFF)", "1", seed);
    row.status = ScoreStatus::not_built;
    rows.push_back(row);
    return rows;
  }
  tell("strawberries: settling", 1);
  try {
    stretch_rows(rows, scene, seed, scene.plants);
  } catch (const std::runtime_error& error) {
    ScoreRow row = row_of("stretch of bed", error.what(), "1", seed);
    row.status = ScoreStatus::error;
    rows.push_back(row);
    return rows;
  }
  tell("strawberries: labelled images", 2);
  RunConfig config =
      run_config(strawberries_row(), {"rig=dslr_apsc_24mp", "streams=color", "rig.rgb.width_px=640",
                                      "rig.rgb.height_px=640", "render.pixel_samples=4"});
  auto& own = *config.scene.get_if<StrawberriesSceneConfig>();
  own.views = scene.views;
  own.plants = scene.plants;
  own.cache = scene.cache;
  image_rows(rows, config, seed, quick ? 4 : 20, scratch.path());
  return rows;
}

}  // namespace cousin
