#include "perception/pipelines/seeds.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>
#include <utility>
#include <vector>

#include "perception/pipelines/seeds_sensor.h"
#include "perception/pipelines/splat_stages.h"
#include "perception/silhouette/unclustered_objects.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<std::pair<SeedsMethod, std::string_view>, 6> kMethods = {
    {{SeedsMethod::ours, "ours"},
     {SeedsMethod::paper, "paper"},
     {SeedsMethod::sensor_depth, "sensor_depth"},
     {SeedsMethod::depth_only, "depth_only"},
     {SeedsMethod::splats, "splats"},
     {SeedsMethod::splats_paper, "splats_paper"}}};

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

bool trains_splats(SeedsMethod method) {
  return method == SeedsMethod::splats || method == SeedsMethod::splats_paper;
}

DepthVolume depth_volume(const SeedsPipelineConfig& config, const SeedBoard& board) {
  const SweepVolume volume = volume_of(config, board);
  return {volume.low_m, volume.high_m, board.plate_m};
}

}  // namespace

std::string_view to_string(SeedsMethod method) {
  return kMethods.at(static_cast<std::size_t>(method)).second;
}

Fields fields(SeedsPipelineConfig& config) {
  Fields own = {
      {"method",
       TextField{[&config] { return std::string(to_string(config.method)); },
                 [&config](const std::string& text) { config.method = method_of(text); }},
       "ours: closed surfaces; paper: clusters of points, PCA box, alpha shape; sensor_depth: ours "
       "with a depth camera's depth; depth_only: its depth and nothing else; splats: with the "
       "depth of trained Gaussians; splats_paper: their centres, trained as the reference does"},
      {"board_kind",
       TextField{[&config] { return text_of(config.board_kind); },
                 [&config](const std::string& text) { config.board_kind = board_kind_of(text); }},
       "calibration board: as_reported by the capture, markers or plain"},
      {"agreement_sigmas", &config.agreement_sigmas,
       "sensor_depth, depth_only: depths agree within so many sigmas, and objects rise by as many",
       0.1, 100},
      {"sensor_outline_sigma_px", &config.sensor_outline_sigma_px,
       "sensor_depth: sigma of an offset of all outlines", 1e-6, 10},
      {"sensor_size_sigma_m", &config.sensor_size_sigma_m,
       "sensor_depth: sigma of lengths and widths, beyond the fit's", 0, 1},
      {"sensor_height_sigma_m", &config.sensor_height_sigma_m,
       "sensor_depth: sigma of heights, beyond the fit's", 0, 1},
      {"margin_m", &config.margin_m, "reconstructed beyond the plate's edge", 0, 1},
      {"below_board_m", &config.below_board_m, "reconstructed below the board's face", 0, 1},
      {"tallest_m", &config.tallest_m, "tallest object on the board", 0.001, 1},
  };
  return own + nested("board", fields(config.board)) + nested("poses", fields(config.poses)) +
         nested("green", fields(config.green)) + nested("mvs", fields(config.mvs)) +
         nested("sensor_depth", fields(config.sensor_depth)) +
         nested("splats", fields(config.splats)) + nested("fuse", fields(config.fuse)) +
         nested("clusters", fields(config.clusters)) + nested("outlines", fields(config.outlines)) +
         nested("surface", fields(config.surface)) + nested("traits", fields(config.traits)) +
         nested("paper_clusters", fields(config.paper_clusters)) +
         nested("paper_traits", fields(config.paper_traits));
}

void validate(const SeedsPipelineConfig& config) {
  SeedsPipelineConfig copy = config;
  check_limits(fields(copy));
  validate(config.board);
  validate(config.poses);
  validate(config.green);
  validate(config.mvs);
  validate(config.sensor_depth);
  validate(config.splats);
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

SweepVolume volume_of(const SeedsPipelineConfig& config, const SeedBoard& board) {
  const double half = 0.5 * board.plate_m + config.margin_m;
  return {{-half, -half, -config.below_board_m}, {half, half, config.tallest_m}};
}

namespace {

/// Poses, depth and cloud of a depth camera in place of those from several colour views.
void take_sensor_depth(const SeedsPipelineConfig& config, Stages& stages) {
  stages.depths = [config](const Capture& capture, const Estimate& so_far) {
    return depths_of_sensor(capture, so_far.poses, depth_volume(config, board_of(capture, config)),
                            config.sensor_depth);
  };
  stages.cloud = [config](const Capture& capture, const Estimate& so_far) {
    return fuse_depths(capture, so_far.poses, so_far.depths, config.green,
                       fuse_for(config, so_far.depths));
  };
  if (config.method != SeedsMethod::depth_only) return;
  stages.corners = nullptr;
  stages.poses = [](const Capture& capture, const Estimate&) { return poses_of_rig(capture); };
}

void measure_points(const SeedsPipelineConfig& config, Stages& stages) {
  stages.surfaces = [](const Capture&, const Estimate& so_far) {
    return surfaces_of_clusters(so_far.clusters);
  };
  stages.traits = [config](const Capture& capture, const Estimate& so_far) {
    Traits traits = traits_as_paper(so_far.surfaces, config.paper_traits);
    if (config.method != SeedsMethod::depth_only) return traits;
    return without_noise(with_point_sigmas(std::move(traits), config, capture, so_far), config,
                         capture, so_far);
  };
}

/// The paper's clusters of the cloud, whatever it is of.
void cluster_as_papers(const SeedsPipelineConfig& config, std::uint64_t seed, Stages& stages) {
  stages.clusters = [config, seed](const Capture&, const Estimate& so_far) {
    return cluster_as_paper(so_far.cloud, config.paper_clusters, Rng(seed).fork("paper_clusters"));
  };
}

/// What photographs show and no cluster is of: a specimen that is not solved, with the reason, so
/// that nothing is lost without a word.
Traits with_unclustered(Traits traits, const SeedsPipelineConfig& config, const Capture& capture,
                        const Estimate& so_far) {
  int instance = so_far.clusters.count;
  for (const SpecimenTraits& specimen : traits)
    instance = std::max(instance, specimen.instance + 1);
  for (const UnclusteredObject& object : unclustered_objects(
           capture, so_far.poses, board_of(capture, config), so_far.clusters, config.green)) {
    SpecimenTraits lost;
    lost.instance = instance++;
    char text[160];
    std::snprintf(text, sizeof text,
                  "seen in %d views at x %.0f, y %.0f mm, but %d points of the cloud are too few; "
                  "more views from nearer places help",
                  object.views, object.centre_m.x() * 1e3, object.centre_m.y() * 1e3,
                  object.points);
    lost.reason = text;
    traits.push_back(std::move(lost));
  }
  return traits;
}

Stages stages_of_method(const SeedsPipelineConfig& config, std::uint64_t seed,
                        const SplatWatch& watch) {
  Stages stages;
  stages.corners = [config](const Capture& capture, const Estimate&) {
    return detect_board(capture, board_of(capture, config), config.board);
  };
  stages.poses = [config](const Capture& capture, const Estimate& so_far) {
    return estimate_board_poses(capture, so_far.corners, board_of(capture, config), config.poses);
  };
  stages.depths = [config](const Capture& capture, const Estimate& so_far) {
    return estimate_depths(capture, so_far.poses, volume_of(config, board_of(capture, config)),
                           config.mvs);
  };
  stages.cloud = [config](const Capture& capture, const Estimate& so_far) {
    return fuse_depths(capture, so_far.poses, so_far.depths, config.green, config.fuse);
  };
  if (trains_splats(config.method)) take_splats(config, seed, watch, stages);
  if (config.method == SeedsMethod::paper || config.method == SeedsMethod::splats_paper) {
    cluster_as_papers(config, seed, stages);
    measure_points(config, stages);
    return stages;
  }
  stages.clusters = [config](const Capture& capture, const Estimate& so_far) {
    return cluster_on_board(so_far.cloud, clusters_for(config, capture, so_far));
  };
  if (config.method == SeedsMethod::sensor_depth || config.method == SeedsMethod::depth_only)
    take_sensor_depth(config, stages);
  if (config.method == SeedsMethod::depth_only) {
    measure_points(config, stages);
    return stages;
  }
  stages.silhouettes = [config](const Capture& capture, const Estimate& so_far) {
    return find_outlines(capture, so_far.poses, board_of(capture, config), so_far.clusters,
                         config.outlines);
  };
  stages.surfaces = [config, seed](const Capture& capture, const Estimate& so_far) {
    return fit_surfaces(so_far.poses, so_far.clusters, so_far.silhouettes,
                        surface_for(config, capture, so_far), Rng(seed).fork("surface_samples"));
  };
  stages.traits = [config](const Capture& capture, const Estimate& so_far) {
    const double pixel_m = pixel_at_board_m(so_far.poses);
    return without_noise(traits_of_meshes(so_far.surfaces, pixel_m, traits_for(config, pixel_m)),
                         config, capture, so_far);
  };
  return stages;
}

}  // namespace

Stages seeds_stages(const SeedsPipelineConfig& config, std::uint64_t seed,
                    const SplatWatch& watch) {
  validate(config);
  Stages stages = stages_of_method(config, seed, watch);
  if (config.method == SeedsMethod::depth_only) return stages;  // it looks at no colour
  stages.traits = [config, measure = stages.traits](const Capture& capture,
                                                    const Estimate& so_far) {
    return with_unclustered(measure(capture, so_far), config, capture, so_far);
  };
  return stages;
}

bool needs_sfm(const SeedsPipelineConfig& config) {
  return trains_splats(config.method) && config.splats.poses != SplatPoses::board;
}

PipelineNeeds needs(const SeedsPipelineConfig& config) {
  PipelineNeeds result;
  const bool splats = trains_splats(config.method);
  const bool papers =
      config.method == SeedsMethod::paper || config.method == SeedsMethod::splats_paper;
  const bool points = papers || config.method == SeedsMethod::depth_only;
  if (config.method == SeedsMethod::depth_only) {
    result.images = {"depth"};
    result.left_out.emplace_back("corners", "the rig knows its poses");
    result.stages = {"poses", "depth", "cloud", "clusters"};
  } else {
    result.images = {"color"};
    if (config.method == SeedsMethod::sensor_depth) result.images.emplace_back("depth");
    result.stages = {"corners", "poses", "depth", "cloud", "clusters"};
    if (splats) result.stages.insert(result.stages.begin() + 2, "splats");
    if (config.method == SeedsMethod::splats_paper) {
      std::erase(result.stages, "depth");
      result.left_out.emplace_back("depth", "the cloud is the Gaussians' centres");
    }
  }
  if (points) {
    result.left_out.emplace_back("masks", papers
                                              ? "the paper's chain measures points, not silhouettes"
                                              : "without colour there are no silhouettes");
  } else {
    result.stages.push_back("masks");
  }
  if (!splats) result.left_out.emplace_back("splats", "no Gaussians are trained");
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

namespace {
constexpr auto kSeedsOrder = std::to_array<std::string_view>(
    {"corners", "poses", "splats", "depth", "cloud", "clusters", "masks", "surfaces", "traits"});
}

StageOrder seeds_stage_order() { return kSeedsOrder; }

Estimate run_seeds(const Capture& capture, const SeedsPipelineConfig& config, const Stages& stages,
                   const StageObserver& observer) {
  validate(config);
  if (!capture.frames.empty()) require_images(capture, config);
  return run_stages(capture, stages, kSeedsOrder, observer);
}

}  // namespace cousin
