#include "benchmarks/suites/splats/field_rows.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "benchmarks/score/image_fidelity.h"
#include "benchmarks/suites/splats/ngp_view.h"
#include "benchmarks/suites/splats/posed_set.h"
#include "perception/splats/train_splats.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr int kFoxSide_px = 480;
constexpr int kFoxPoints = 20000;

constexpr const char* kChairIntrinsics = "intrinsic_DSC-HX5_3648x2736_to_640x480.yaml";

/// Means over views, of pixels that their photographs have.
template <class Render>
ImageFidelity mean_fidelity(const std::vector<const SplatView*>& views, const Render& render) {
  ImageFidelity mean{0, 0, 0, 0};
  const auto n = static_cast<double>(views.size());
  for (const SplatView* view : views) {
    const SplatViewLevel& level = view->full;
    const Image<std::uint8_t> counted = counted_pixels(level.weight);
    const ImageFidelity one =
        score_fidelity(where_counted(render(level.camera, view->camera_from_world).channel,
                                     level.color.channel, counted),
                       level.color.channel, counted);
    mean.psnr_db += one.psnr_db / n;
    mean.ssim += one.ssim / n;
    mean.flip += one.flip / n;
  }
  return mean;
}

/// At most `count` of the views, evenly.
std::vector<const SplatView*> some_of(const std::vector<SplatView>& views, std::size_t count) {
  std::vector<const SplatView*> some;
  const std::size_t n = std::min(count, views.size());
  for (std::size_t i = 0; i < n; ++i) some.push_back(&views[i * views.size() / n]);
  return some;
}

/// Rows of the held-out views, and of as many of those trained on: where these are well and those
/// are not, a model has learned the photographs and not the scene.
template <class Render>
void add_point(std::vector<ScoreRow>& rows, ScoreRow row, const PosedSet& set, int steps,
               const StageTiming& training, const Render& render) {
  row.case_name = std::to_string(steps) + " steps";
  row.wall_s = training.wall_s;
  row.cpu_s = training.cpu_s;
  const auto add = [&](const std::string& kind, const std::vector<const SplatView*>& views) {
    const ImageFidelity mean = mean_fidelity(views, render);
    row.n = static_cast<std::int64_t>(views.size());
    for (const auto& [metric, value, unit] :
         {std::tuple("psnr", mean.psnr_db, "dB"), std::tuple("ssim", mean.ssim, "1"),
          std::tuple("flip", mean.flip, "1")}) {
      row.metric = kind + metric;
      row.value = value;
      row.unit = unit;
      rows.push_back(row);
    }
  };
  add("held_out.", some_of(set.test, set.test.size()));
  add("train.", some_of(set.train, set.test.size()));
}

void splat_points(std::vector<ScoreRow>& rows, const ScoreRow& base, const PosedSet& set,
                  const std::vector<int>& steps) {
  for (const int count : steps) {
    SplatTrainConfig config;
    config.steps = count;
    config.seed = base.seed;
    const SplatTraining training = train_splats(set.train, set.start, config);
    ScoreRow row = base;
    row.method = "splats";
    if (training.status != SplatTrainStatus::ok) {
      row.metric = "training: " + to_string(training.status);
      row.status = ScoreStatus::not_solved;
      rows.push_back(row);
      return;
    }
    StageTiming seconds;  // of its steps, as the radiance field's
    seconds.wall_s = training.curve.back().wall_s;
    seconds.cpu_s = training.curve.back().cpu_s;
    add_point(rows, row, set, count, seconds, [&](const Camera& camera, const Pose& pose) {
      return render_splats(training.model, camera, pose).color;
    });
  }
}

void ngp_points(std::vector<ScoreRow>& rows, const ScoreRow& base, const PosedSet& set,
                const std::vector<int>& steps) {
  std::vector<NgpView> views;
  for (const SplatView& view : set.train) views.push_back(ngp_view(view));
  NgpConfig config;
  config.iterations = *std::max_element(steps.begin(), steps.end());
  config.seed = base.seed;
  ScoreRow row = base;
  row.method = "instant-ngp";
  const auto take = [&](const NgpPoint& point, const NgpModel& model) {
    StageTiming seconds;
    seconds.wall_s = point.wall_s;
    seconds.cpu_s = point.cpu_s;
    add_point(rows, row, set, point.iteration, seconds,
              [&](const Camera& camera, const Pose& pose) {
                return ColorPlanes{fidelity_planes(render_ngp(model, camera, pose).color)};
              });
  };
  const NgpTraining training = train_ngp(views, config, {steps, take});
  if (training.status == NgpStatus::ok) {
    row.case_name = std::to_string(config.iterations) + " steps";
    row.metric = "seconds.cpu a sample";
    row.n = training.samples;
    row.wall_s = training.curve.back().wall_s;
    row.cpu_s = training.curve.back().cpu_s;
    row.value = row.cpu_s / static_cast<double>(training.samples);
    row.unit = "s/sample";
    rows.push_back(row);
    return;
  }
  row.metric = "training: " + std::string(to_string(training.status)) + ", " + training.reason;
  row.status = ScoreStatus::not_solved;
  rows.push_back(row);
}

ScoreRow absent(ScoreRow row, const fs::path& where) {
  row.metric = "no photographs at " + where.string();
  row.status = ScoreStatus::not_solved;
  return row;
}

void chair_rows(const fs::path& chair, ScoreRow base, std::vector<ScoreRow>& rows) {
  base.scene = "chair";
  if (!fs::is_directory(chair)) {
    rows.push_back(absent(base, chair));
    return;
  }
  const PlacedSet placed = place_photographs(chair / "img", (chair / kChairIntrinsics).string());
  ScoreRow row = base;
  row.method = "sfm";
  row.case_name = "poses";
  row.n = placed.photographs;
  row.wall_s = placed.seconds.wall_s;
  row.cpu_s = placed.seconds.cpu_s;
  if (placed.set.train.empty()) {
    row.metric = "poses: " + std::string(to_string(placed.status)) + ", " + placed.reason;
    row.status =
        placed.status == SfmStatus::not_built ? ScoreStatus::not_built : ScoreStatus::not_solved;
    rows.push_back(row);
    return;
  }
  row.metric = "views placed";
  row.unit = "1";
  row.value = placed.placed;
  rows.push_back(row);
  splat_points(rows, base, placed.set, {1000, 3000});
  ngp_points(rows, base, placed.set, {1000, 3000});
}

}  // namespace

std::vector<ScoreRow> field_rows(const fs::path& split_set, const fs::path& fox,
                                 const fs::path& chair, std::uint64_t seed, bool quick) {
  ScoreRow base;
  base.suite = "splats";
  base.seed = seed;
  std::vector<ScoreRow> rows;
  base.scene = split_set.filename().string();
  if (fs::is_directory(split_set)) {
    const PosedSet set = read_split_set(split_set);
    splat_points(rows, base, set,
                 quick ? std::vector<int>{500} : std::vector<int>{500, 1000, 5000});
    ngp_points(rows, base, set,
               quick ? std::vector<int>{200, 500} : std::vector<int>{500, 1000, 2000, 5000});
  } else {
    rows.push_back(absent(base, split_set));
  }
  if (quick) return rows;
  base.scene = "fox";
  if (!fs::is_regular_file(fox)) {
    rows.push_back(absent(base, fox));
  } else {
    const PosedSet set = read_every_eighth(fox, kFoxSide_px, kFoxPoints, seed);
    splat_points(rows, base, set, {1000, 3000});
    ngp_points(rows, base, set, {1000, 3000});
  }
  chair_rows(chair, base, rows);
  return rows;
}

}  // namespace cousin
