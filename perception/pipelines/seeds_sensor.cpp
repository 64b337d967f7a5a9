#include "perception/pipelines/seeds_sensor.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "perception/cloud/board_noise.h"

namespace cousin {
namespace {

/// Median of the depths' sigmas; 0 if none has one.
double median_sigma_m(const Depths& depths) {
  std::vector<float> sigmas;
  for (const FrameDepth& frame : depths) {
    for (const float sigma : frame.sigma_m) {
      if (std::isfinite(sigma)) sigmas.push_back(sigma);
    }
  }
  if (sigmas.empty()) return 0;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return static_cast<double>(*middle);
}

bool reads_sensor_depth(const SeedsPipelineConfig& config) {
  return config.method == SeedsMethod::sensor_depth || config.method == SeedsMethod::depth_only;
}

/// Half of what the sensor's matching window covers on the board; 0 if no view has a pose.
double window_reach_m(const SeedsPipelineConfig& config, const Poses& poses) {
  const double pixel_m = pixel_at_board_m(poses);
  return std::isfinite(pixel_m) ? 0.5 * config.sensor_depth.window_px * pixel_m : 0;
}

/// What the cloud says of its own noise on the board.
BoardNoise noise_of(const SeedsPipelineConfig& config, const Capture& capture,
                    const Estimate& so_far) {
  constexpr double kLeastPatch_m = 0.001;
  const double patch_m = std::max(kLeastPatch_m, 2 * window_reach_m(config, so_far.poses));
  return board_noise(so_far.cloud, board_of(capture, config).plate_m, patch_m);
}

/// The finest harmonic of a body of 10 mm that spans 3 pixels, at least 8: outlines of a dozen
/// pixels do not hold finer ones, and the fit does not settle.
int degree_for(int most, double pixel_m) {
  constexpr double kRound_m = 3.14159 * 0.010;
  constexpr int kLeast = 8;
  if (!(pixel_m > 0)) return most;
  return std::min(most,
                  std::max(kLeast, static_cast<int>(std::min(64.0, kRound_m / (3 * pixel_m)))));
}

}  // namespace

double pixel_at_board_m(const Poses& poses) {
  std::vector<double> spans_m;
  for (const FramePose& pose : poses) {
    if (pose.status != PoseStatus::ok || !(pose.camera.fx_px > 0)) continue;
    spans_m.push_back(pose.camera_from_world.translation_m.norm() / pose.camera.fx_px);
  }
  if (spans_m.empty()) return kNaN;
  const auto middle = spans_m.begin() + static_cast<std::ptrdiff_t>(spans_m.size() / 2);
  std::nth_element(spans_m.begin(), middle, spans_m.end());
  return *middle;
}

FuseConfig fuse_for(const SeedsPipelineConfig& config, const Depths& depths) {
  FuseConfig fuse = config.fuse;
  fuse.agreement_m =
      std::clamp(config.agreement_sigmas * median_sigma_m(depths), fuse.agreement_m, 0.1);
  return fuse;
}

BoardClusterConfig clusters_for(const SeedsPipelineConfig& config, const Capture& capture,
                                const Estimate& so_far) {
  BoardClusterConfig clusters = config.clusters;
  // Depth of Gaussians has no smears between objects: their sides are theirs down to the board.
  constexpr int kJoinRounds = 8;
  constexpr double kJoinSaturation = 0.5;
  if (config.method == SeedsMethod::splats) {
    clusters.join_rounds = std::max(clusters.join_rounds, kJoinRounds);
    clusters.join_saturation = std::max(clusters.join_saturation, kJoinSaturation);
  }
  if (!reads_sensor_depth(config)) return clusters;
  const BoardNoise noise = noise_of(config, capture, so_far);
  if (!std::isfinite(noise.sigma_m)) return clusters;
  const auto raised = [&](double height_m, double by_m) {
    return std::max(height_m, std::min(noise.offset_m + by_m, config.tallest_m));
  };
  clusters.min_height_m = raised(clusters.min_height_m, 2 * noise.sigma_m);
  clusters.low_height_m = raised(clusters.low_height_m, noise.sigma_m);
  clusters.min_top_m = raised(clusters.min_top_m, config.agreement_sigmas * noise.sigma_m);
  return clusters;
}

SurfaceFitConfig surface_for(const SeedsPipelineConfig& config, const Capture& capture,
                             const Estimate& so_far) {
  SurfaceFitConfig surface = config.surface;
  if (!reads_sensor_depth(config)) return surface;
  surface.degree = degree_for(surface.degree, pixel_at_board_m(so_far.poses));
  surface.outline_bias_sigma_px =
      std::max(surface.outline_bias_sigma_px, config.sensor_outline_sigma_px);
  surface.cloud_rim_m = std::clamp(window_reach_m(config, so_far.poses), surface.cloud_rim_m, 1.0);
  const BoardNoise noise = noise_of(config, capture, so_far);
  if (!std::isfinite(noise.patch_sigma_m)) return surface;
  const double sigma_m = std::min(0.01, std::hypot(noise.patch_sigma_m, noise.offset_m));
  surface.cloud_sigma_m = std::max(surface.cloud_sigma_m, sigma_m);
  surface.cloud_bias_sigma_m = std::max(surface.cloud_bias_sigma_m, sigma_m);
  return surface;
}

MeshTraitConfig traits_for(const SeedsPipelineConfig& config, double pixel_m) {
  MeshTraitConfig traits = config.traits;
  if (!reads_sensor_depth(config) || !(pixel_m > 0)) return traits;
  const auto with = [&](double sigma_px, double more_m) {
    return std::min(100.0, std::hypot(sigma_px, more_m / pixel_m));
  };
  traits.length_sigma_px = with(traits.length_sigma_px, config.sensor_size_sigma_m);
  traits.width_sigma_px = with(traits.width_sigma_px, config.sensor_size_sigma_m);
  traits.height_sigma_px = with(traits.height_sigma_px, config.sensor_height_sigma_m);
  return traits;
}

Traits without_noise(Traits traits, const SeedsPipelineConfig& config, const Capture& capture,
                     const Estimate& so_far) {
  if (!reads_sensor_depth(config)) return traits;
  const BoardNoise noise = noise_of(config, capture, so_far);
  for (SpecimenTraits& specimen : traits) {
    for (const Trait& trait : specimen.traits) {
      if (trait.name != "height") continue;
      double least_m = 0;
      for (const double sigma_m : {noise.sigma_m, trait.sigma}) {
        if (std::isfinite(sigma_m)) least_m = std::max(least_m, config.agreement_sigmas * sigma_m);
      }
      if (trait.value >= least_m) continue;
      specimen.status = TraitStatus::not_solved;
      specimen.reason = "its height is within the noise of the sensor's depth";
    }
    if (specimen.status != TraitStatus::ok) specimen.traits.clear();
  }
  return traits;
}

Traits with_point_sigmas(Traits traits, const SeedsPipelineConfig& config, const Capture& capture,
                         const Estimate& so_far) {
  const double reach_m = window_reach_m(config, so_far.poses);
  const double size_m = reach_m > 0 ? 3 * reach_m : kNaN;
  const double height_m = 4 * noise_of(config, capture, so_far).sigma_m;
  for (SpecimenTraits& specimen : traits) {
    std::map<std::string, double> value;
    for (const Trait& trait : specimen.traits) value[trait.name] = trait.value;
    const double flat = size_m / value["length"] + size_m / value["width"];
    const std::map<std::string, double> sigma = {
        {"length", size_m},
        {"width", size_m},
        {"height", height_m},
        {"area", flat * value["area"]},
        {"volume", value["length"] * value["width"] * value["height"]}};
    for (Trait& trait : specimen.traits) {
      const auto known = sigma.find(trait.name);
      if (known != sigma.end()) trait.sigma = known->second;
    }
  }
  return traits;
}

}  // namespace cousin
