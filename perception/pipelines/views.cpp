#include "perception/pipelines/views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "perception/ngp/ngp.h"
#include "perception/pipelines/views_shapes.h"
#include "perception/splats/swept_start.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<Named<ViewsMethod>, 2> kViewsMethods = {
    {{ViewsMethod::splats, "splats"}, {ViewsMethod::splats_paper, "splats_paper"}}};
constexpr std::array<Named<ViewsPoses>, 3> kViewsPoses = {
    {{ViewsPoses::best, "best"}, {ViewsPoses::reported, "reported"}, {ViewsPoses::sfm, "sfm"}}};
constexpr std::array<Named<SplatGrowth>, 4> kGrowths = {{{SplatGrowth::budgeted, "budgeted"},
                                                         {SplatGrowth::adaptive, "adaptive"},
                                                         {SplatGrowth::mcmc, "mcmc"},
                                                         {SplatGrowth::fixed, "fixed"}}};

std::size_t placed(const Poses& poses) {
  return static_cast<std::size_t>(
      std::count_if(poses.begin(), poses.end(),
                    [](const FramePose& pose) { return pose.status == PoseStatus::ok; }));
}

bool are_reported(const Capture& capture, ViewsPoses from) {
  if (from != ViewsPoses::best) return from == ViewsPoses::reported;
  const std::size_t count = placed(reported_poses(capture));
  return count >= 2 && 2 * count >= capture.frames.size();
}

Poses place_by_tracks(const Capture& capture, SfmConfig config, const SplatWatch& watch,
                      ViewsFindings& findings) {
  config.colmap.folder = watch.sfm_folder;
  // Frames may come in any order; beyond so many, in the order of a walk around.
  constexpr std::size_t kAllPairs = 60;
  if (capture.frames.size() <= kAllPairs) config.pairs.choice = PairChoice::exhaustive;
  if (capture.board.empty() || capture.board == "none") config.scale = SfmScale::none;
  if (!config.refine && config.scale == SfmScale::adjusted) config.scale = SfmScale::squares;
  SfmEstimate estimate = estimate_poses_sfm(capture, config);
  if (watch.posed) watch.posed(estimate);
  if (!has_poses(estimate.status))
    throw std::runtime_error("structure from motion: " + std::string(to_string(estimate.status)) +
                             (estimate.reason.empty() ? "" : ", " + estimate.reason));
  findings.by_tracks = true;
  if (estimate.status != SfmStatus::ok)
    findings.sfm_doubts = std::string(to_string(estimate.status)) +
                          (estimate.reason.empty() ? "" : ", " + estimate.reason);
  if (!estimate.colmap_version.starts_with("3.8"))
    findings.sfm_doubts += (findings.sfm_doubts.empty() ? "" : "; ") +
                           ("COLMAP " + estimate.colmap_version) + ", tested with 3.8";
  findings.is_metric = estimate.gauge == BundleGauge::metric;
  for (const SfmPoint& point : estimate.points)
    findings.tracks.push_back({point.in_world_m, point.color});
  return std::move(estimate.poses);
}

Poses place(const Capture& full, const ViewsPipelineConfig& config, const SplatWatch& watch,
            ViewsFindings& findings) {
  findings = {};
  Poses poses = !needs_sfm(full, config) ? reported_poses(full)
                                         : place_by_tracks(full, config.sfm, watch, findings);
  if (const std::size_t count = placed(poses); count < 2)
    throw std::runtime_error(std::to_string(count) + " of " + std::to_string(poses.size()) +
                             " views have a pose; at least 2 (poses=sfm finds them by COLMAP)");
  return poses;
}

/// Everything: depths are cut to no part of the world.
SweepVolume everywhere() {
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(1e30);
  return {-far, far};
}

/// Where things may be of which the cameras alone are known: the cube of twice their median
/// distance about the point that they look at; nothing where there is none.
std::optional<SweepVolume> looked_at(const std::vector<SplatView>& views) {
  std::vector<NgpView> cameras;
  for (const SplatView& view : views)
    cameras.push_back({view.full.camera, view.camera_from_world, {}, {}});
  const ngp::NgpVolume volume = ngp_volume({}, cameras);
  if (!(volume.side_m > 0)) return std::nullopt;
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(volume.side_m);
  return SweepVolume{volume.centre_in_world_m - half, volume.centre_in_world_m + half};
}

std::vector<StartPoint> somebodys_points(const ViewsPipelineConfig& config,
                                         const ViewsFindings& findings) {
  if (findings.by_tracks)
    throw std::runtime_error("start = " + config.start +
                             ": its frame is that of the capture's poses, and these are COLMAP's "
                             "(poses=reported takes the capture's)");
  std::vector<StartPoint> points = read_start_points(config.start).points;
  if (points.empty()) throw std::runtime_error("start = " + config.start + ": holds no point");
  return points;
}

std::vector<StartPoint> start_points(const ViewsPipelineConfig& config,
                                     const std::optional<SweepVolume>& volume,
                                     const ViewsFindings& findings, std::uint64_t seed) {
  constexpr std::size_t kLeastTracks = 100;
  if (!config.start.empty()) return somebodys_points(config, findings);
  if (findings.tracks.size() >= kLeastTracks) return findings.tracks;
  if (!volume)
    throw std::runtime_error(
        "the cameras look at no common point, about which Gaussians could "
        "begin; poses=sfm begins at its points, start=FILE at somebody's");
  return random_start_points(volume->low_m, volume->high_m, config.start_points,
                             Rng(seed).fork("splat_start"));
}

/// The views in a frame about the volume, in whose middle is the origin and whose half side is a
/// length that things on a bench are looked at from: sweep and fusion know how large these are.
struct OnBench {
  static constexpr double kHalfSide_m = 0.3;
  std::vector<SplatView> views;
  Eigen::Vector3d centre_m;
  double scale;

  OnBench(const std::vector<SplatView>& of, const SweepVolume& volume)
      : views(of),
        centre_m(0.5 * (volume.low_m + volume.high_m)),
        scale(2 * kHalfSide_m / (volume.high_m.x() - volume.low_m.x())) {
    for (SplatView& view : views) {
      Pose& pose = view.camera_from_world;
      pose.translation_m = scale * (pose.translation_m + pose.rotation * centre_m);
    }
  }
  SweepVolume volume() const {
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(kHalfSide_m);
    return {-half, half};
  }
  Eigen::Vector3d in_world(const Eigen::Vector3d& point_m) const {
    return point_m / scale + centre_m;
  }
};

/// Whether a photograph shows the place in a pixel that counts: masked pixels are black, and a
/// sweep takes them as they are.
bool is_shown(const Eigen::Vector3d& point_m, const std::vector<SplatView>& views) {
  return std::any_of(views.begin(), views.end(), [&](const SplatView& view) {
    const Image<float>& weight = view.full.weight;
    if (weight.empty()) return true;
    const auto pixel = Lens(view.full.camera).project(view.camera_from_world * point_m);
    if (!pixel || !(pixel->array().abs() < 1e6).all()) return false;
    const int x = static_cast<int>(std::lround(pixel->x()));
    const int y = static_cast<int>(std::lround(pixel->y()));
    return weight.contains(x, y) && weight(x, y) > 0;
  });
}

constexpr std::size_t kLeastSwept = 1000;  ///< points, of a sweep that found surfaces
/// Where there are surfaces, what begins in the air is a guess, and centres need not be thrown
/// about: else both become fog before the cameras. The fox, held out: 28.9 dB without, 30.7 with
/// the opacity, 31.0 with both (48 s of training for 54).
constexpr double kAirOpacity = 0.02;
constexpr double kSweptRate = 0.25;  ///< of the centres' rate

/// Takes exposures out of the photographs, and adds points of what was swept for them.
void take_out_exposures(const ViewsPipelineConfig& config, const SweepVolume& volume,
                        std::vector<SplatView>& views, std::vector<StartPoint>& start,
                        ViewsFindings& findings) {
  SweptStartConfig sweep;
  sweep.most_points = config.swept_points;
  const OnBench bench(views, volume);
  const Camera& camera = views.front().full.camera;
  const int longest_px = std::max(camera.width_px, camera.height_px);
  SweptStart swept = swept_start(bench.views, bench.volume(), sweep);
  // Where neighbours are far apart or things small, hardly any surface is found at that size.
  constexpr int kLargestSide_px = 512;
  while (swept.points.size() < kLeastSwept && 2 * sweep.largest_side_px <= kLargestSide_px &&
         sweep.largest_side_px < longest_px) {
    sweep.largest_side_px *= 2;
    swept = swept_start(bench.views, bench.volume(), sweep);
  }
  for (StartPoint& point : swept.points) {
    if (!is_shown(point.position_m, bench.views)) continue;
    point.position_m = bench.in_world(point.position_m);
    start.push_back(point);
  }
  if (!config.one_exposure) return;
  ViewExposures& exposures = findings.exposures = std::move(swept.exposures);
  const auto measured =
      static_cast<std::size_t>(std::count_if(exposures.log_gain.begin(), exposures.log_gain.end(),
                                             [](double gain) { return std::isfinite(gain); }));
  if (exposures.status == ExposureStatus::ok && 2 * measured < views.size())
    exposures.status = ExposureStatus::too_few_sightings;
  if (exposures.status != ExposureStatus::ok) return;
  for (std::size_t v = 0; v < views.size(); ++v) {
    views[v].full =
        at_mean_exposure(std::move(views[v].full), exposures.gain_of(v), exposures.vignetting);
    findings.exposed_frames.push_back(views[v].frame);
  }
}

SplatTrainConfig training_of(const ViewsPipelineConfig& config) {
  SplatTrainConfig training;
  if (config.method == ViewsMethod::splats_paper) {
    training = reference_training();
    // It can be left where it reports.
    training.report_every = std::gcd(training.report_every, config.reference_steps);
  } else {
    training.steps = config.steps;
    training.rates = rates_for(config.steps);
    training.most_splats = config.most_splats;
    training.growth = config.growth;
    training.low_pass_px2 = config.low_pass_px2;
  }
  training.sh_degree = config.sh_degree;
  return training;
}

/// A cloud's points are numbers of 32 bits.
/// @throws std::runtime_error where the origin is so far away that they are no finer than its
/// voxels
void require_near_origin(const ViewsPipelineConfig& config, const std::vector<SplatView>& views,
                         const SweepVolume& volume) {
  if (config.cloud_views == 0) return;
  constexpr double kMostVoxels = 1 << 21;
  const Eigen::Vector3d middle_m = 0.5 * (volume.low_m + volume.high_m);
  for (const SplatView& view : views) {
    const Eigen::Vector3d centre_m = centre_in_world_m(view.camera_from_world);
    const double voxel_m = config.voxel_px * (centre_m - middle_m).norm() / view.full.camera.fx_px;
    if (!(voxel_m > 0) || centre_m.norm() <= kMostVoxels * voxel_m) continue;
    std::ostringstream text;
    text << "a camera is " << centre_m.norm() << " from the origin of the poses, more than 2^21 of "
         << "the cloud's voxels, " << voxel_m << " each (voxel_px = " << config.voxel_px
         << "), in the capture's unit: its points have 32 bits. Move the origin near the scene, or "
         << "leave the cloud out (cloud_views=0)";
    throw std::runtime_error(text.str());
  }
}

SplatModel train(const ViewsPipelineConfig& config, const Capture& capture, const Poses& poses,
                 const std::vector<Image<std::uint8_t>>& masks, ViewsFindings& findings,
                 std::uint64_t seed, const SplatWatch& watch) {
  findings.exposures = {};
  findings.exposed_frames.clear();
  std::vector<SplatView> views;
  std::size_t place = 0;
  for (SplatView& view : splat_views(capture, poses, masks)) {
    if (!is_held_out(config, place++)) views.push_back(std::move(view));
  }
  if (views.empty())
    throw std::runtime_error(std::to_string(placed(poses)) + " views have a pose, of " +
                             std::to_string(place) + " with a colour photograph none is left to " +
                             "train on (hold_out_every = " + std::to_string(config.hold_out_every) +
                             ")");
  SplatTrainConfig training = training_of(config);
  training.seed = Rng(seed).fork("splats")();
  const int last =
      config.method == ViewsMethod::splats_paper ? config.reference_steps : training.steps;
  const std::optional<SweepVolume> volume = looked_at(views);
  if (volume) require_near_origin(config, views, *volume);
  std::vector<StartPoint> start = start_points(config, volume, findings, seed);
  const bool is_random = config.start.empty() && findings.tracks.empty();
  if (config.method == ViewsMethod::splats && (config.one_exposure || config.swept_points > 0)) {
    if (config.one_exposure) findings.exposures.log_gain.assign(views.size(), kNaN);
    const std::size_t before = start.size();
    if (volume) take_out_exposures(config, *volume, views, start, findings);
    if (start.size() - before >= kLeastSwept && is_random) {
      for (std::size_t i = 0; i < before; ++i) start[i].opacity = kAirOpacity;
      training.rates.centre_first *= kSweptRate;
    }
  }
  return train_on_views(views, start, {}, training, last, watch);
}

}  // namespace

bool needs_sfm(const Capture& capture, const ViewsPipelineConfig& config) {
  return !are_reported(capture, config.poses);
}

ColorPlanes as_exposed(ColorPlanes image, const SplatView& photograph,
                       const ViewsFindings& findings) {
  const ViewExposures& exposures = findings.exposures;
  if (exposures.status != ExposureStatus::ok) return image;
  double before = kNaN, after = kNaN;
  int first = 0, last = 0;  // their frames, in the capture's order
  for (std::size_t v = 0; v < findings.exposed_frames.size(); ++v) {
    const int frame = findings.exposed_frames[v];
    if (frame == photograph.frame)
      return as_exposed(std::move(image), photograph.full.camera, exposures.gain_of(v),
                        exposures.vignetting);
    if (!std::isfinite(exposures.log_gain[v])) continue;
    if (frame < photograph.frame) before = exposures.log_gain[v], first = frame;
    if (frame > photograph.frame && !std::isfinite(after))
      after = exposures.log_gain[v], last = frame;
  }
  if (!std::isfinite(before)) before = std::isfinite(after) ? after : 0;
  if (!std::isfinite(after)) after = before;
  const double share =
      last > first ? static_cast<double>(photograph.frame - first) / (last - first) : 0;
  return as_exposed(std::move(image), photograph.full.camera, before + share * (after - before),
                    exposures.vignetting);
}

std::string_view to_string(ViewsMethod method) {
  return name_in<ViewsMethod>(kViewsMethods, method);
}

Fields fields(ViewsPipelineConfig& c) {
  return Fields{
             {"method", choice_field<ViewsMethod>("method", kViewsMethods, c.method),
              "splats: ours; splats_paper: the reference's schedule, left after reference_steps"},
             {"poses", choice_field<ViewsPoses>("poses", kViewsPoses, c.poses),
              "best: the capture's where at least half of its frames have them, else sfm; "
              "reported; sfm: "
              "by COLMAP and our adjustment"},
             {"largest_side_px", &c.largest_side_px,
              "longer side that photographs are made small to after they were placed, from 16 on; "
              "0: they "
              "stay",
              0, 100000},
             {"hold_out_every", &c.hold_out_every,
              "every so many-th view has no part in the training and scores it; 0 or 1: all have",
              0, 1000},
             {"steps", &c.steps, "splats: training steps, one view each", 1, 1e6},
             {"most_splats", &c.most_splats, "splats: Gaussians at the end", 1, 1e7},
             {"growth", choice_field<SplatGrowth>("growth", kGrowths, c.growth),
              "splats: how they become that many. budgeted: those of the largest gradients part; "
              "adaptive: "
              "the reference's clone, split and prune; mcmc: relocation and noise; fixed: they do "
              "not"},
             {"reference_steps", &c.reference_steps,
              "splats_paper: steps of the reference's 30,000 after which training is left", 1,
              30000},
             {"masks",
              TextField{[&c] { return c.masks; },
                        [&c](const std::string& text) { c.masks = text; }},
              "folder of masks, as 000012.png: where one is 0, its photograph is neither trained "
              "on nor "
              "scored; empty: there are none"},
             {"sh_degree", &c.sh_degree, "of the colours over directions", 0, 3},
             {"low_pass_px2", &c.low_pass_px2,
              "splats: added to the variances of a Gaussian in the image; the reference has 0.3",
              1e-6, 100},
             {"one_exposure", &c.one_exposure,
              "splats: exposures and vignetting are measured on swept surfaces and taken out"},
             {"swept_points", &c.swept_points,
              "splats: at most so many of these surfaces begin too", 0, 1e6},
             {"start",
              TextField{[&c] { return c.start; },
                        [&c](const std::string& text) { c.start = text; }},
              "file of points that Gaussians begin at, in the frame of the capture's poses: a PLY, "
              "COLMAP's points3D.txt or points3D.bin; empty: tracks, else start_points"},
             {"start_points", &c.start_points,
              "Gaussians at the beginning, where there are no tracks", 1, 1e6},
             {"normals", &c.normals, "depth images have normals too (depth_normal/)"},
             {"cloud_views", &c.cloud_views, "views whose depths become the cloud; 0: no cloud", 0,
              1000},
             {"voxel_px", &c.voxel_px, "of the cloud, in pixels at the median depth", 0.01, 100},
             {"agreement_px", &c.agreement_px, "along the normal, at which depths agree; likewise",
              0.01, 100},
             {"mesh_cells", &c.mesh_cells,
              "of the mesh's lattice along the cloud's longest side; 0: no mesh", 0, 390}} +
         nested("sfm", fields_of_pipelines(c.sfm));
}

void validate(const ViewsPipelineConfig& config) {
  ViewsPipelineConfig copy = config;
  check_limits(fields(copy), "views");
  constexpr int kLeastSide_px = 16;
  if (config.largest_side_px > 0 && config.largest_side_px < kLeastSide_px)
    throw std::invalid_argument(
        "views: largest_side_px = " + std::to_string(config.largest_side_px) +
        " is neither 0 nor " + std::to_string(kLeastSide_px) + " or more");
}

bool is_held_out(const ViewsPipelineConfig& config, std::size_t place) {
  const auto every = static_cast<std::size_t>(std::max(0, config.hold_out_every));
  return every > 1 && place % every == 0;
}

namespace {
constexpr auto kViewsOrder =
    std::to_array<std::string_view>({"poses", "splats", "depth", "cloud", "surfaces"});
}

StageOrder views_stage_order() { return kViewsOrder; }

Stages views_stages(const ViewsPipelineConfig& config, const Capture& full, std::uint64_t seed,
                    const SplatWatch& watch, std::shared_ptr<ViewsFindings> findings,
                    std::vector<Image<std::uint8_t>> masks) {
  validate(config);
  Stages stages;
  // From the stage that finds the poses to the one that begins on their tracks.
  if (!findings) findings = std::make_shared<ViewsFindings>();
  stages.poses = [config, &full, findings, watch](const Capture&, const Estimate&) {
    return reduced(place(full, config, watch, *findings), full, config.largest_side_px);
  };
  stages.splats = [config, seed, findings, watch, masks = std::move(masks)](
                      const Capture& capture, const Estimate& so_far) {
    return train(config, capture, so_far.poses, masks, *findings, seed, watch);
  };
  stages.depths = [normals = config.normals](const Capture&, const Estimate& so_far) {
    return depths_of_splats(so_far.splats, so_far.poses, everywhere(), so_far.splats.low_pass_px2,
                            normals);
  };
  if (config.cloud_views > 0) {
    stages.cloud = [config](const Capture& capture, const Estimate& so_far) {
      return views_cloud(config, capture, so_far);
    };
  }
  if (config.mesh_cells > 0) {
    stages.surfaces = [config](const Capture&, const Estimate& so_far) {
      return views_mesh(config, so_far);
    };
  }
  return stages;
}

}  // namespace cousin
