#include "benchmarks/seeds/splat_images.h"

#include <algorithm>
#include <cmath>

#include "benchmarks/metrics/image_fidelity.h"
#include "perception/splats/splat_render.h"

namespace cousin {
namespace {

/// Not zero where the photograph shows more of the scene than of what is behind it.
Image<std::uint8_t> objects_of(const SplatViewLevel& level) {
  Image<std::uint8_t> mask(level.behind.width(), level.behind.height());
  for (std::size_t i = 0; i < mask.size(); ++i) mask.data()[i] = level.behind.data()[i] < 0.5F;
  return mask;
}

/// Mean of what is finite; NaN if nothing is.
struct Mean {
  double sum = 0;
  std::int64_t count = 0;
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum += value;
    ++count;
  }
  double value() const { return count > 0 ? sum / static_cast<double>(count) : kNaN; }
};

}  // namespace

std::vector<ScoreRow> splat_image_rows(const Capture& capture, const SeedsEstimate& estimate,
                                       const SeedsPipelineConfig& config,
                                       const SeedsScoreLabels& labels,
                                       const LearnedDistance* learned) {
  if (estimate.splats.splats.empty()) return {};
  const std::vector<SplatView> views =
      seed_views(capture, estimate.poses, volume_of(config, board_of(capture, config)),
                 config.green, config.splats.margin_px);
  Mean psnr, object, whole, similarity, flips, distance;
  for (const SplatView& view : views) {
    const SplatViewLevel& level = view.levels.front();
    const FidelityPlanes image =
        render_splats(estimate.splats, level.camera, view.camera_from_world).color.channel;
    const double part_db = psnr_db(image, level.color.channel);
    const Camera& camera = capture.frames[static_cast<std::size_t>(view.frame)].sensors[0].reported;
    const double share = static_cast<double>(image[0].size()) /
                         (static_cast<double>(camera.width_px) * camera.height_px);
    psnr.add(part_db);
    whole.add(part_db - 10 * std::log10(share));
    object.add(psnr_db(image, level.color.channel, objects_of(level)));
    similarity.add(ssim(image, level.color.channel));
    flips.add(flip(image, level.color.channel));
    if (learned) distance.add(learned->between(image, level.color.channel));
  }
  ScoreRow base;
  base.suite = labels.suite;
  base.scene = labels.scene;
  base.case_name = labels.case_name;
  base.method = labels.method;
  base.seed = labels.seed;
  for (const StageTiming& timing : estimate.timings) {
    if (timing.stage != "splats") continue;
    base.wall_s = timing.wall_s;
    base.cpu_s = timing.cpu_s;
    base.peak_rss_mb = timing.peak_rss_mb;
    base.peak_above_start_mb = timing.peak_above_start_mb;
  }
  std::vector<ScoreRow> rows;
  const auto add = [&](const char* metric, double value, const char* unit, std::int64_t n) {
    ScoreRow row = base;
    row.metric = metric;
    row.value = value;
    row.unit = unit;
    row.n = n;
    rows.push_back(row);
  };
  add("train.psnr", psnr.value(), "dB", psnr.count);
  add("train.psnr_object", object.value(), "dB", object.count);
  add("train.psnr_whole", whole.value(), "dB", whole.count);
  add("train.ssim", similarity.value(), "1", similarity.count);
  add("train.flip", flips.value(), "1", flips.count);
  if (learned) add("train.lpips", distance.value(), "1", distance.count);
  add("gaussians", static_cast<double>(estimate.splats.splats.size()), "1", 1);
  add("seconds.splats", base.wall_s, "s", 1);
  return rows;
}

}  // namespace cousin
