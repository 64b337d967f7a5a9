#include "perception/pipelines/splat_stages.h"

#include "perception/splats/splat_geometry.h"

namespace cousin {
namespace {

/// What the method `ours` finds on the same poses, up to its closed surfaces.
SeedsEstimate found_without_splats(const SeedsPipelineConfig& config, std::uint64_t seed,
                                   const Capture& capture, const SeedsEstimate& so_far) {
  SeedsPipelineConfig without = config;
  without.method = SeedsMethod::ours;
  const SeedsStages stages = seeds_stages(without, seed);
  SeedsEstimate found = so_far;
  found.depths = stages.depth(capture, found);
  found.cloud = stages.cloud(capture, found);
  found.clusters = stages.clusters(capture, found);
  if (found.clusters.count == 0) return found;
  found.silhouettes = stages.masks(capture, found);
  found.surfaces = stages.surfaces(capture, found);
  return found;
}

SplatTrainConfig training_of(const SeedsSplatConfig& config) {
  SplatTrainConfig training;
  training.steps = config.steps;
  training.most_splats = config.most_splats;
  training.rates.centre_first = config.centre_rate;
  training.rates.centre_last = 0.01 * config.centre_rate;
  training.rates.log_scale *= config.shape_rate;
  training.rates.rotation *= config.shape_rate;
  return training;
}

}  // namespace

void take_splats(const SeedsPipelineConfig& config, std::uint64_t seed, SeedsStages& stages) {
  const bool paper = config.method == SeedsMethod::splats_paper;
  if (config.splats.poses == SplatPoses::sfm) {
    stages.poses = [config](const Capture& capture, const SeedsEstimate& so_far) {
      return poses_by_sfm(capture, so_far.corners, board_of(capture, config));
    };
  }
  stages.splats = [config, seed, paper](const Capture& capture, const SeedsEstimate& so_far) {
    const SweepVolume volume = volume_of(config, board_of(capture, config));
    const SeedsSplatConfig& splats = config.splats;
    SplatTrainConfig training = paper ? reference_training() : training_of(splats);
    training.seed = Rng(seed).fork("splats")();
    const Rng rng = Rng(seed).fork("splat_start");
    std::vector<StartPoint> start;
    SplatStartConfig gaussians;
    Rgb8 screen{};
    if (!paper) {
      screen = screen_color(capture, config.green);
      training.background = {static_cast<float>(screen.r) / 255, static_cast<float>(screen.g) / 255,
                             static_cast<float>(screen.b) / 255};
      gaussians.flatness = splats.flatness;
      gaussians.opacity = splats.start_opacity;
      const SeedsEstimate found = found_without_splats(config, seed, capture, so_far);
      start = start_on_surfaces(found.clusters, found.cloud, found.surfaces, splats, rng);
    }
    fill_start(volume, splats.start_points, rng, start);
    return train_on_seeds(
        seed_views(capture, so_far.poses, volume, config.green, splats.margin_px, screen), start,
        gaussians, training, paper ? splats.reference_steps : training.steps);
  };
  if (paper) {
    stages.depth = nullptr;
    stages.cloud = [config](const Capture&, const SeedsEstimate& so_far) {
      return splat_centres(so_far.splats, config.splats.least_opacity);
    };
    return;
  }
  stages.depth = [config](const Capture& capture, const SeedsEstimate& so_far) {
    return depths_of_splats(so_far.splats, so_far.poses,
                            volume_of(config, board_of(capture, config)));
  };
}

}  // namespace cousin
