#include "perception/pipelines/splat_stages.h"

#include <memory>
#include <numeric>
#include <utility>

#include "perception/splats/splat_geometry.h"

namespace cousin {
namespace {

Stages stages_of_ours(SeedsPipelineConfig config, std::uint64_t seed) {
  config.method = SeedsMethod::ours;
  return seeds_stages(config, seed);
}

/// The plane sweep's cloud on the same poses.
Estimate found_by_sweep(const Stages& ours, const Capture& capture, const Estimate& so_far) {
  Estimate found = so_far;
  found.depths = ours.depths(capture, found);
  found.cloud = ours.cloud(capture, found);
  return found;
}

/// What the method `ours` finds on the same poses, up to its closed surfaces.
Estimate found_without_splats(const Stages& stages, const Capture& capture,
                              const Estimate& so_far) {
  Estimate found = found_by_sweep(stages, capture, so_far);
  found.clusters = stages.clusters(capture, found);
  if (found.clusters.count == 0) return found;
  found.silhouettes = stages.silhouettes(capture, found);
  found.surfaces = stages.surfaces(capture, found);
  return found;
}

SplatTrainConfig training_of(const SeedsSplatConfig& config) {
  SplatTrainConfig training;
  training.steps = config.steps;
  training.most_splats = config.most_splats;
  training.any_background = true;
  training.low_pass_px2 = config.low_pass_px2;
  training.rates.centre_first = config.centre_rate;
  training.rates.centre_last = 0.01 * config.centre_rate;
  training.rates.log_scale *= config.shape_rate;
  training.rates.rotation *= config.shape_rate;
  training.rates.opacity *= config.opacity_rate;
  return training;
}

/// The reference starts from the points that structure from motion leaves. COLMAP's own are used
/// where it gave the poses, else as many of the plane sweep's.
std::vector<StartPoint> start_as_paper(const SeedsPipelineConfig& config, std::uint64_t seed,
                                       const Capture& capture, const Estimate& so_far,
                                       const std::vector<StartPoint>& tracks) {
  std::vector<StartPoint> start = tracks;
  if (start.empty()) {
    const Cloud cloud = found_by_sweep(stages_of_ours(config, seed), capture, so_far).cloud;
    const auto limit = static_cast<std::size_t>(config.splats.reference_points);
    const std::size_t count = std::min(cloud.size(), limit);
    for (std::size_t i = 0; i < count; ++i) {
      const CloudPoint& point = cloud[i * cloud.size() / count];
      start.push_back({point.position_m.cast<double>(), point.color});
    }
  }
  return start;
}

SplatModel trained_as_paper(const SeedsPipelineConfig& config, std::uint64_t seed,
                            const Capture& capture, const Estimate& so_far,
                            const std::vector<StartPoint>& tracks, const SplatWatch& watch) {
  const SweepVolume volume = volume_of(config, board_of(capture, config));
  const SeedsSplatConfig& splats = config.splats;
  SplatTrainConfig training = reference_training();
  training.seed = Rng(seed).fork("splats")();
  // It can be left where it reports.
  training.report_every = std::gcd(training.report_every, splats.reference_steps);
  std::vector<StartPoint> start = start_as_paper(config, seed, capture, so_far, tracks);
  if (start.empty())
    fill_start(volume, splats.reference_points, Rng(seed).fork("splat_start"), start);
  return train_on_views(seed_views(capture, so_far.poses, volume, config.green,
                                   splats.reference_margin_px, splats.most_pixels),
                        start, {}, training, splats.reference_steps, watch);
}

SplatModel trained_as_ours(const SeedsPipelineConfig& config, std::uint64_t seed,
                           const Capture& capture, const Estimate& so_far,
                           const SplatWatch& watch) {
  const SweepVolume volume = volume_of(config, board_of(capture, config));
  const SeedsSplatConfig& splats = config.splats;
  SplatTrainConfig training = training_of(splats);
  training.seed = Rng(seed).fork("splats")();
  const Rng rng = Rng(seed).fork("splat_start");
  const Estimate found = found_without_splats(stages_of_ours(config, seed), capture, so_far);
  std::vector<StartPoint> start =
      start_on_surfaces(found.clusters, found.cloud, found.surfaces, splats, rng);
  fill_start(volume, splats.start_points, rng, start);
  return without_strays(
      train_on_views(seed_views(capture, so_far.poses, volume, config.green, splats.margin_px,
                                splats.most_pixels),
                     start, {.opacity = splats.start_opacity, .flatness = splats.flatness},
                     training, training.steps, watch),
      volume);
}

Estimate seen_in_training(const SeedsPipelineConfig& config, Estimate so_far) {
  so_far.poses = training_poses(config.splats, std::move(so_far.poses));
  return so_far;
}

}  // namespace

void take_splats(const SeedsPipelineConfig& config, std::uint64_t seed, const SplatWatch& watch,
                 Stages& stages) {
  // COLMAP's points, from the stage that finds the poses to the one that trains on them.
  const auto tracks = std::make_shared<std::vector<StartPoint>>();
  if (needs_sfm(config)) {
    SfmConfig sfm = config.splats.poses == SplatPoses::sfm ? paper_sfm_config() : SfmConfig{};
    sfm.colmap.folder = watch.sfm_folder.string();
    stages.poses = [config, sfm, tracks, posed = watch.posed](const Capture& capture,
                                                              const Estimate& so_far) {
      const SeedBoard board = board_of(capture, config);
      return poses_by_sfm(capture, so_far.corners, board, volume_of(config, board), sfm, *tracks,
                          posed);
    };
  }
  if (config.method == SeedsMethod::splats_paper) {
    stages.splats = [config, seed, tracks, watch](const Capture& capture, const Estimate& so_far) {
      return trained_as_paper(config, seed, capture, seen_in_training(config, so_far), *tracks,
                              watch);
    };
    stages.depths = nullptr;
    stages.cloud = [config](const Capture&, const Estimate& so_far) {
      return splat_centres(so_far.splats, config.splats.least_opacity);
    };
    return;
  }
  stages.splats = [config, seed, watch](const Capture& capture, const Estimate& so_far) {
    return trained_as_ours(config, seed, capture, seen_in_training(config, so_far), watch);
  };
  stages.depths = [config](const Capture& capture, const Estimate& so_far) {
    return depths_of_splats(so_far.splats, so_far.poses,
                            volume_of(config, board_of(capture, config)),
                            config.splats.low_pass_px2);
  };
}

}  // namespace cousin
