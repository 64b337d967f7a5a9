#include "perception/pipelines/seeds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

#include "perception/cloud/board_noise.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr std::array<std::pair<SeedsMethod, std::string_view>, 4> kMethods = {
    {{SeedsMethod::ours, "ours"},
     {SeedsMethod::paper, "paper"},
     {SeedsMethod::sensor_depth, "sensor_depth"},
     {SeedsMethod::depth_only, "depth_only"}}};

SeedsMethod method_of(const std::string& text) {
  std::string known;
  for (const auto& [method, name] : kMethods) {
    if (name == text) return method;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw std::invalid_argument("method \"" + text + "\" is not one of " + known);
}

bool reads(const PipelineNeeds& needs, std::string_view image) {
  return std::find(needs.images.begin(), needs.images.end(), image) != needs.images.end();
}

std::string text_of(BoardKind kind) {
  switch (kind) {
    case BoardKind::markers:
      return "markers";
    case BoardKind::plain:
      return "plain";
    case BoardKind::as_reported:
      break;
  }
  return "as_reported";
}

BoardKind board_kind_of(const std::string& text) {
  if (text == "as_reported") return BoardKind::as_reported;
  if (text == "markers") return BoardKind::markers;
  if (text == "plain") return BoardKind::plain;
  throw std::invalid_argument("board \"" + text + "\" is not one of as_reported, markers, plain");
}

/// What a pixel spans at the board's middle: the median over the views that have a pose, else NaN.
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

SweepVolume sweep_volume(const SeedsPipelineConfig& config, const SeedBoard& board) {
  const double half = 0.5 * board.plate_m + config.margin_m;
  return {{-half, -half, -config.below_board_m}, {half, half, config.tallest_m}};
}

DepthVolume depth_volume(const SeedsPipelineConfig& config, const SeedBoard& board) {
  const SweepVolume volume = sweep_volume(config, board);
  return {volume.low_m, volume.high_m, board.plate_m};
}

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

/// The fusion's configuration for depths of a sensor: their sigma says how far two of them differ.
FuseConfig fuse_for(const SeedsPipelineConfig& config, const Depths& depths) {
  FuseConfig fuse = config.fuse;
  fuse.agreement_m =
      std::clamp(config.agreement_sigmas * median_sigma_m(depths), fuse.agreement_m, 0.1);
  return fuse;
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
                    const SeedsEstimate& so_far) {
  constexpr double kLeastPatch_m = 0.001;
  const double patch_m = std::max(kLeastPatch_m, 2 * window_reach_m(config, so_far.poses));
  return board_noise(so_far.cloud, board_of(capture, config).plate_m, patch_m);
}

/// Of a sensor's depth, what rises above the board by less than the cloud's noise is no object.
BoardClusterConfig clusters_for(const SeedsPipelineConfig& config, const Capture& capture,
                                const SeedsEstimate& so_far) {
  BoardClusterConfig clusters = config.clusters;
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

/// A sensor's depth as measurements of a surface: points within a matching window of an object's
/// rim are smeared with the board's and left out; what is left errs together over a window, and
/// all over an object, by as much as the board's patches do.
SurfaceFitConfig surface_for(const SeedsPipelineConfig& config, const Capture& capture,
                             const SeedsEstimate& so_far) {
  SurfaceFitConfig surface = config.surface;
  if (!reads_sensor_depth(config)) return surface;
  surface.cloud_rim_m = std::clamp(window_reach_m(config, so_far.poses), surface.cloud_rim_m, 1.0);
  const BoardNoise noise = noise_of(config, capture, so_far);
  if (!std::isfinite(noise.patch_sigma_m)) return surface;
  const double sigma_m = std::min(0.01, std::hypot(noise.patch_sigma_m, noise.offset_m));
  surface.cloud_sigma_m = std::max(surface.cloud_sigma_m, sigma_m);
  surface.cloud_bias_sigma_m = std::max(surface.cloud_bias_sigma_m, sigma_m);
  return surface;
}

/// Runs one stage, times it and tells the observer; an exception names the stage and keeps what is
/// finished.
template <class Value, class Stage>
void run_stage(const char* name, const Stage& stage, const Capture& capture,
               SeedsEstimate& estimate, Value SeedsEstimate::*result,
               const StageObserver& observer) {
  if (!stage) return;
  if (observer) observer(name, false, estimate);
  const StageClock clock(name);
  try {
    estimate.*result = stage(capture, estimate);
  } catch (const std::exception& error) {
    std::throw_with_nested(StageError(name, error.what()));
  }
  estimate.timings.push_back(clock.finish());
  if (observer) observer(name, true, estimate);
}

}  // namespace

StageError::StageError(const std::string& stage_name, const std::string& what)
    : std::runtime_error("stage " + stage_name + ": " + what), stage(stage_name) {}

std::string_view to_string(SeedsMethod method) {
  return kMethods.at(static_cast<std::size_t>(method)).second;
}

Fields fields(SeedsPipelineConfig& config) {
  Fields own = {
      {"method",
       TextField{[&config] { return std::string(to_string(config.method)); },
                 [&config](const std::string& text) { config.method = method_of(text); }},
       "ours: closed surfaces; paper: clusters of points, PCA box, alpha shape; sensor_depth: ours "
       "with a depth camera's depth; depth_only: its depth and nothing else"},
      {"board_kind",
       TextField{[&config] { return text_of(config.board_kind); },
                 [&config](const std::string& text) { config.board_kind = board_kind_of(text); }},
       "calibration board: as_reported by the capture, markers or plain"},
      {"agreement_sigmas", &config.agreement_sigmas,
       "sensor_depth, depth_only: depths agree within so many sigmas, and objects rise by as many",
       0.1, 100},
      {"margin_m", &config.margin_m, "reconstructed beyond the plate's edge", 0, 1},
      {"below_board_m", &config.below_board_m, "reconstructed below the board's face", 0, 1},
      {"tallest_m", &config.tallest_m, "tallest object on the board", 0.001, 1},
  };
  return own + nested("board", fields(config.board)) + nested("poses", fields(config.poses)) +
         nested("green", fields(config.green)) + nested("mvs", fields(config.mvs)) +
         nested("sensor_depth", fields(config.sensor_depth)) + nested("fuse", fields(config.fuse)) +
         nested("clusters", fields(config.clusters)) + nested("outlines", fields(config.outlines)) +
         nested("surface", fields(config.surface)) + nested("traits", fields(config.traits)) +
         nested("paper_clusters", fields(config.paper_clusters)) +
         nested("paper_traits", fields(config.paper_traits));
}

void validate(const SeedsPipelineConfig& config) {
  validate(config.board);
  validate(config.poses);
  validate(config.green);
  validate(config.mvs);
  validate(config.sensor_depth);
  validate(config.fuse);
  validate(config.clusters);
  validate(config.outlines);
  validate(config.surface);
  validate(config.traits);
  validate(config.paper_clusters);
  validate(config.paper_traits);
}

SeedBoard board_of(const Capture& capture, const SeedsPipelineConfig& config) {
  SeedBoard board;
  if (config.board_kind == BoardKind::as_reported) {
    if (!capture.board.empty() && capture.board != "markers" && capture.board != "plain") {
      throw std::invalid_argument(
          "the capture's board is \"" + capture.board +
          "\"; the seeds pipeline needs markers or plain (--set board_kind=...)");
    }
    board.has_markers = capture.board != "plain";
  } else {
    board.has_markers = config.board_kind == BoardKind::markers;
  }
  return board;
}

namespace {

/// Poses, depth and cloud of a depth camera in place of those from several colour views.
void take_sensor_depth(const SeedsPipelineConfig& config, SeedsStages& stages) {
  stages.depth = [config](const Capture& capture, const SeedsEstimate& so_far) {
    return depths_of_sensor(capture, so_far.poses, depth_volume(config, board_of(capture, config)),
                            config.sensor_depth);
  };
  stages.cloud = [config](const Capture& capture, const SeedsEstimate& so_far) {
    return fuse_depths(capture, so_far.poses, so_far.depths, config.green,
                       fuse_for(config, so_far.depths));
  };
  if (config.method != SeedsMethod::depth_only) return;
  stages.corners = nullptr;
  stages.poses = [](const Capture& capture, const SeedsEstimate&) { return poses_of_rig(capture); };
}

void measure_points(const SeedsPipelineConfig& config, SeedsStages& stages) {
  stages.surfaces = [](const Capture&, const SeedsEstimate& so_far) {
    return surfaces_of_clusters(so_far.clusters);
  };
  stages.traits = [config](const Capture&, const SeedsEstimate& so_far) {
    return traits_as_paper(so_far.surfaces, config.paper_traits);
  };
}

}  // namespace

SeedsStages seeds_stages(const SeedsPipelineConfig& config, std::uint64_t seed) {
  validate(config);
  SeedsStages stages;
  stages.corners = [config](const Capture& capture, const SeedsEstimate&) {
    return detect_board(capture, board_of(capture, config), config.board);
  };
  stages.poses = [config](const Capture& capture, const SeedsEstimate& so_far) {
    return estimate_board_poses(capture, so_far.corners, board_of(capture, config), config.poses);
  };
  stages.depth = [config](const Capture& capture, const SeedsEstimate& so_far) {
    return estimate_depths(capture, so_far.poses, sweep_volume(config, board_of(capture, config)),
                           config.mvs);
  };
  stages.cloud = [config](const Capture& capture, const SeedsEstimate& so_far) {
    return fuse_depths(capture, so_far.poses, so_far.depths, config.green, config.fuse);
  };
  if (config.method == SeedsMethod::paper) {
    stages.clusters = [config, seed](const Capture&, const SeedsEstimate& so_far) {
      return cluster_as_paper(so_far.cloud, config.paper_clusters,
                              Rng(seed).fork("paper_clusters"));
    };
    measure_points(config, stages);
    return stages;
  }
  stages.clusters = [config](const Capture& capture, const SeedsEstimate& so_far) {
    return cluster_on_board(so_far.cloud, clusters_for(config, capture, so_far));
  };
  if (config.method != SeedsMethod::ours) take_sensor_depth(config, stages);
  if (config.method == SeedsMethod::depth_only) {
    measure_points(config, stages);
    return stages;
  }
  stages.masks = [config](const Capture& capture, const SeedsEstimate& so_far) {
    return find_outlines(capture, so_far.poses, board_of(capture, config), so_far.clusters,
                         config.outlines);
  };
  stages.surfaces = [config, seed](const Capture& capture, const SeedsEstimate& so_far) {
    return fit_surfaces(so_far.poses, so_far.clusters, so_far.silhouettes,
                        surface_for(config, capture, so_far), Rng(seed).fork("surface_samples"));
  };
  stages.traits = [config](const Capture&, const SeedsEstimate& so_far) {
    return traits_of_meshes(so_far.surfaces, pixel_at_board_m(so_far.poses), config.traits);
  };
  return stages;
}

PipelineNeeds needs(const SeedsPipelineConfig& config) {
  PipelineNeeds result;
  const bool points =
      config.method == SeedsMethod::paper || config.method == SeedsMethod::depth_only;
  if (config.method == SeedsMethod::depth_only) {
    result.images = {"depth"};
    result.left_out.emplace_back("corners", "the rig knows its poses");
    result.stages = {"poses", "depth", "cloud", "clusters"};
  } else {
    result.images = {"color"};
    if (config.method == SeedsMethod::sensor_depth) result.images.emplace_back("depth");
    result.stages = {"corners", "poses", "depth", "cloud", "clusters"};
  }
  if (points) {
    result.left_out.emplace_back("masks", config.method == SeedsMethod::paper
                                              ? "the paper's chain measures points, not silhouettes"
                                              : "without colour there are no silhouettes");
  } else {
    result.stages.push_back("masks");
  }
  result.stages.insert(result.stages.end(), {"surfaces", "traits"});
  return result;
}

void require_images(const Capture& capture, const SeedsPipelineConfig& config) {
  const PipelineNeeds needed = needs(config);
  const auto require = [&](bool there, const char* what) {
    if (there) return;
    throw std::invalid_argument("method " + std::string(to_string(config.method)) + " reads " +
                                what);
  };
  require(!reads(needed, "depth") || has_sensor_depth(capture),
          "the depth images of a depth camera; the capture has none");
  const bool has_poses =
      std::any_of(capture.frames.begin(), capture.frames.end(),
                  [](const Frame& frame) { return frame.rig_from_world.has_value(); });
  require(config.method != SeedsMethod::depth_only || has_poses,
          "the poses of a rig that knows where it is; the capture has none (a simulated rig knows "
          "with --set knows_pose=true)");
}

SeedsEstimate run_seeds(const Capture& capture, const SeedsPipelineConfig& config,
                        const SeedsStages& stages, const StageObserver& observer) {
  validate(config);
  if (capture.frames.empty()) throw std::invalid_argument("the capture has no frames");
  require_images(capture, config);
  SeedsEstimate estimate;
  run_stage("corners", stages.corners, capture, estimate, &SeedsEstimate::corners, observer);
  run_stage("poses", stages.poses, capture, estimate, &SeedsEstimate::poses, observer);
  run_stage("depth", stages.depth, capture, estimate, &SeedsEstimate::depths, observer);
  run_stage("cloud", stages.cloud, capture, estimate, &SeedsEstimate::cloud, observer);
  run_stage("clusters", stages.clusters, capture, estimate, &SeedsEstimate::clusters, observer);
  run_stage("masks", stages.masks, capture, estimate, &SeedsEstimate::silhouettes, observer);
  run_stage("surfaces", stages.surfaces, capture, estimate, &SeedsEstimate::surfaces, observer);
  run_stage("traits", stages.traits, capture, estimate, &SeedsEstimate::traits, observer);
  return estimate;
}

}  // namespace cousin
