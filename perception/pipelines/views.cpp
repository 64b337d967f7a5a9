#include "perception/pipelines/views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "perception/ngp/ngp.h"
#include "perception/splats/depth_mesh.h"
#include "perception/splats/swept_start.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::pair<ViewsMethod, std::string_view> kMethods[] = {
    {ViewsMethod::splats, "splats"}, {ViewsMethod::splats_paper, "splats_paper"}};
constexpr std::pair<ViewsPoses, std::string_view> kPoses[] = {
    {ViewsPoses::best, "best"}, {ViewsPoses::reported, "reported"}, {ViewsPoses::sfm, "sfm"}};

constexpr std::pair<SplatGrowth, std::string_view> kGrowths[] = {
    {SplatGrowth::budgeted, "budgeted"},
    {SplatGrowth::adaptive, "adaptive"},
    {SplatGrowth::mcmc, "mcmc"},
    {SplatGrowth::fixed, "fixed"}};

/// A field of an enumeration whose values have names.
template <class Value, std::size_t N>
TextField named(const char* key, Value& value,
                const std::pair<Value, std::string_view> (&names)[N]) {
  return {
      [&value, &names] {
        for (const auto& [is, name] : names) {
          if (is == value) return std::string(name);
        }
        return std::string();
      },
      [key, &value, &names](const std::string& text) {
        std::string all;
        for (const auto& [is, name] : names) {
          if (name == text) {
            value = is;
            return;
          }
          all += (all.empty() ? "" : ", ") + std::string(name);
        }
        throw std::invalid_argument(std::string(key) + " \"" + text + "\" is not one of " + all);
      }};
}

/// How many pixels along a side become one.
int reduction(int width_px, int height_px, int largest_side_px) {
  const int longest = std::max(width_px, height_px);
  return largest_side_px <= 0 ? 1 : std::max(1, (longest + largest_side_px - 1) / largest_side_px);
}

Image<Rgb8> reduced(const Image<Rgb8>& image, int by) {
  Image<Rgb8> small(image.width() / by, image.height() / by);
  const int half = by * by / 2;
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) {
      std::array<int, 3> sum = {half, half, half};
      for (int j = 0; j < by; ++j) {
        for (int i = 0; i < by; ++i) {
          const Rgb8 c = image(by * x + i, by * y + j);
          sum[0] += c.r;
          sum[1] += c.g;
          sum[2] += c.b;
        }
      }
      const auto code = [&](std::size_t k) {
        return static_cast<std::uint8_t>(sum[k] / (by * by));
      };
      small(x, y) = {code(0), code(1), code(2)};
    }
  }
  return small;
}

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

/// @param colmap  folder that COLMAP works in; empty: one that goes
Poses place_by_tracks(const Capture& capture, const std::filesystem::path& colmap,
                      ViewsFindings& findings) {
  SfmConfig config;
  config.colmap.folder = colmap;
  // Frames may come in any order; beyond so many, in the order of a walk around.
  constexpr std::size_t kAllPairs = 60;
  if (capture.frames.size() <= kAllPairs) config.pairs.choice = PairChoice::exhaustive;
  if (capture.board.empty() || capture.board == "none") config.scale = SfmScale::none;
  SfmEstimate estimate = estimate_poses_sfm(capture, config);
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

Poses place(const Capture& full, ViewsPoses from, const std::filesystem::path& colmap,
            ViewsFindings& findings) {
  findings = {};
  Poses poses =
      are_reported(full, from) ? reported_poses(full) : place_by_tracks(full, colmap, findings);
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

std::vector<StartPoint> start_points(const ViewsPipelineConfig& config,
                                     const std::optional<SweepVolume>& volume,
                                     const std::vector<StartPoint>& tracks, std::uint64_t seed) {
  constexpr std::size_t kLeastTracks = 100;
  if (tracks.size() >= kLeastTracks) return tracks;
  if (!volume)
    throw std::runtime_error(
        "the cameras look at no common point, about which Gaussians could "
        "begin; poses=sfm begins at its points");
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
  std::vector<StartPoint> start = start_points(config, volume, findings.tracks, seed);
  if (config.method == ViewsMethod::splats && (config.one_exposure || config.swept_points > 0)) {
    if (config.one_exposure) findings.exposures.log_gain.assign(views.size(), kNaN);
    const std::size_t before = start.size();
    if (volume) take_out_exposures(config, *volume, views, start, findings);
    if (start.size() - before >= kLeastSwept && findings.tracks.empty()) {
      for (std::size_t i = 0; i < before; ++i) start[i].opacity = kAirOpacity;
      training.rates.centre_first *= kSweptRate;
    }
  }
  return train_on_views(views, start, {}, training, last, watch);
}

/// Calls `use` with about a hundredth of the pixels of posed views that have depth, and their z.
template <class Use>
void for_some_depths(const Poses& poses, const Depths& depths, const Use& use) {
  constexpr int kEvery = 97;  // pixels
  for (std::size_t v = 0; v < depths.size(); ++v) {
    const Image<float>& depth_m = depths[v].depth_m;
    if (poses[v].status != PoseStatus::ok || depth_m.empty()) continue;
    for (std::size_t i = 0; i < depth_m.size(); i += kEvery) {
      const auto z = static_cast<double>(depth_m.data()[i]);
      const auto width = static_cast<std::size_t>(depth_m.width());
      if (std::isfinite(z) && z > 0)
        use(poses[v], static_cast<int>(i % width), static_cast<int>(i / width), z);
    }
  }
}

/// The median of the pixels' spans in the world over all depths; NaN where there is none.
double median_span_m(const Poses& poses, const Depths& depths) {
  std::vector<double> spans_m;
  for_some_depths(poses, depths, [&](const FramePose& pose, int, int, double z) {
    spans_m.push_back(z / pose.camera.fx_px);
  });
  if (spans_m.empty()) return kNaN;
  const auto middle = spans_m.begin() + static_cast<std::ptrdiff_t>(spans_m.size() / 2);
  std::nth_element(spans_m.begin(), middle, spans_m.end());
  return *middle;
}

/// A frame whose origin is amid the cameras, in which a pixel spans 0.1 mm at the median depth:
/// fusion and meshing know how large things are that lie on a bench.
class DepthBench {
 public:
  static constexpr double kSpan_m = 1e-4;
  /// @param span_m  of a pixel in the world
  DepthBench(const Poses& poses, double span_m) : scale_(kSpan_m / span_m) {
    int count = 0;
    for (const FramePose& pose : poses) {
      if (pose.status != PoseStatus::ok) continue;
      centre_m_ += centre_in_world_m(pose.camera_from_world);
      ++count;
    }
    centre_m_ /= std::max(1, count);
  }
  Poses of(Poses poses) const {
    for (FramePose& pose : poses) {
      Pose& camera = pose.camera_from_world;
      camera.translation_m = scale_ * (camera.translation_m + camera.rotation * centre_m_);
    }
    return poses;
  }
  Image<float> of(Image<float> depth_m) const {
    for (float& z : depth_m) z *= static_cast<float>(scale_);
    return depth_m;
  }
  Eigen::Vector3d of(const Eigen::Vector3d& world_m) const {
    return scale_ * (world_m - centre_m_);
  }
  Eigen::Vector3d in_world(const Eigen::Vector3d& point_m) const {
    return point_m / scale_ + centre_m_;
  }

 private:
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();
  double scale_;
};

Cloud cloud_of(const ViewsPipelineConfig& config, const Capture& capture,
               const SeedsEstimate& so_far) {
  const double span_m = median_span_m(so_far.poses, so_far.depths);
  if (!std::isfinite(span_m)) return {};
  std::vector<std::size_t> with_depth;
  for (std::size_t v = 0; v < so_far.depths.size(); ++v) {
    if (so_far.poses[v].status == PoseStatus::ok && !so_far.depths[v].depth_m.empty())
      with_depth.push_back(v);
  }
  const std::size_t count =
      std::min(with_depth.size(), static_cast<std::size_t>(config.cloud_views));
  const DepthBench bench(so_far.poses, span_m);
  Depths some;
  for (const FrameDepth& depth : so_far.depths) some.push_back({depth.frame, {}, {}});
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t v = with_depth[i * with_depth.size() / count];
    some[v].depth_m = bench.of(so_far.depths[v].depth_m);
  }
  FuseConfig fuse;
  fuse.voxel_m = config.voxel_px * DepthBench::kSpan_m;
  fuse.agreement_m = config.agreement_px * DepthBench::kSpan_m;
  const GreenConfig nothing_is_green{.hue_low = 1, .hue_high = 0};
  Cloud cloud = fuse_depths(capture, bench.of(so_far.poses), some, nothing_is_green, fuse);
  for (CloudPoint& point : cloud) {
    point.position_m = bench.in_world(point.position_m.cast<double>()).cast<float>();
    point.sigma_m = 0;  // depths of Gaussians have none
  }
  return cloud;
}

/// Where the middle 98 % of points along each axis lie, and a tenth more on either side.
Eigen::AlignedBox3d middle_of(const std::vector<Eigen::Vector3d>& points_m) {
  Eigen::AlignedBox3d box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  for (int k = 0; k < 3; ++k) {
    std::vector<double> at;
    for (const Eigen::Vector3d& point : points_m) at.push_back(point[k]);
    std::sort(at.begin(), at.end());
    const std::size_t cut = at.size() / 100;
    const double low = at[cut], high = at[at.size() - 1 - cut];
    box.min()[k] = low - 0.1 * (high - low);
    box.max()[k] = high + 0.1 * (high - low);
  }
  return box;
}

/// The cloud's points; where no cloud was wanted, some of the depths'.
std::vector<Eigen::Vector3d> points_of(const ViewsPipelineConfig& config,
                                       const SeedsEstimate& so_far) {
  std::vector<Eigen::Vector3d> points_m;
  for (const CloudPoint& point : so_far.cloud) points_m.push_back(point.position_m.cast<double>());
  if (config.cloud_views > 0 || !points_m.empty()) return points_m;
  for_some_depths(so_far.poses, so_far.depths, [&](const FramePose& pose, int x, int y, double z) {
    const auto ray = Lens(pose.camera).unproject({x, y});
    if (!ray || !(ray->z() > 0)) return;
    const Eigen::Vector3d in_camera_m = *ray * (z / ray->z());
    points_m.push_back(inverse(pose.camera_from_world) * in_camera_m);
  });
  return points_m;
}

Surfaces mesh_of(const ViewsPipelineConfig& config, const SeedsEstimate& so_far) {
  constexpr std::size_t kLeastPoints = 100;
  Surface surface;
  std::vector<Eigen::Vector3d> points_m = points_of(config, so_far);
  const double span_m = median_span_m(so_far.poses, so_far.depths);
  if (points_m.size() >= kLeastPoints && std::isfinite(span_m)) {
    const DepthBench bench(so_far.poses, span_m);
    for (Eigen::Vector3d& point : points_m) point = bench.of(point);
    const Eigen::AlignedBox3d box = middle_of(points_m);
    DepthMeshConfig mesh;
    mesh.low_m = box.min();
    mesh.high_m = box.max();
    mesh.step_m = box.sizes().maxCoeff() / config.mesh_cells;
    mesh.truncation_m = 4 * mesh.step_m;
    mesh.no_depth = DepthMeshConfig::NoDepth::unknown;
    Depths depths = so_far.depths;
    for (FrameDepth& depth : depths) depth.depth_m = bench.of(std::move(depth.depth_m));
    if ((box.sizes().array() > 0).all())
      surface.mesh = mesh_of_depths(bench.of(so_far.poses), depths, mesh);
    for (Eigen::Vector3d& vertex : surface.mesh.vertices_m) vertex = bench.in_world(vertex);
  }
  surface.status = surface.mesh.triangles.empty() ? SurfaceStatus::empty : SurfaceStatus::ok;
  return {surface};
}

}  // namespace

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
  return kMethods[static_cast<std::size_t>(method)].second;
}

Fields fields(ViewsPipelineConfig& c) {
  return {
      {"method", named("method", c.method, kMethods),
       "splats: ours; splats_paper: the reference's schedule, left after reference_steps"},
      {"poses", named("poses", c.poses, kPoses),
       "best: the capture's where at least half of its frames have them, else sfm; reported; sfm: "
       "by COLMAP and our adjustment"},
      {"largest_side_px", &c.largest_side_px,
       "longer side that photographs are made small to after they were placed, from 16 on; 0: they "
       "stay",
       0, 100000},
      {"hold_out_every", &c.hold_out_every,
       "every so many-th view has no part in the training and scores it; 0 or 1: all have", 0,
       1000},
      {"steps", &c.steps, "splats: training steps, one view each", 1, 1e6},
      {"most_splats", &c.most_splats, "splats: Gaussians at the end", 1, 1e7},
      {"growth", named("growth", c.growth, kGrowths),
       "splats: how they become that many. budgeted: those of the largest gradients part; "
       "adaptive: "
       "the reference's clone, split and prune; mcmc: relocation and noise; fixed: they do not"},
      {"reference_steps", &c.reference_steps,
       "splats_paper: steps of the reference's 30,000 after which training is left", 1, 30000},
      {"masks",
       TextField{[&c] { return c.masks; }, [&c](const std::string& text) { c.masks = text; }},
       "folder of masks, as 000012.png: where one is 0, its photograph is neither trained on nor "
       "scored; empty: there are none"},
      {"sh_degree", &c.sh_degree, "of the colours over directions", 0, 3},
      {"low_pass_px2", &c.low_pass_px2,
       "splats: added to the variances of a Gaussian in the image; the reference has 0.3", 1e-6,
       100},
      {"one_exposure", &c.one_exposure,
       "splats: exposures and vignetting are measured on swept surfaces and taken out"},
      {"swept_points", &c.swept_points, "splats: at most so many of these surfaces begin too", 0,
       1e6},
      {"start_points", &c.start_points, "Gaussians at the beginning, where there are no tracks", 1,
       1e6},
      {"cloud_views", &c.cloud_views, "views whose depths become the cloud; 0: no cloud", 0, 1000},
      {"voxel_px", &c.voxel_px, "of the cloud, in pixels at the median depth", 0.01, 100},
      {"agreement_px", &c.agreement_px, "along the normal, at which depths agree; likewise", 0.01,
       100},
      {"mesh_cells", &c.mesh_cells,
       "of the mesh's lattice along the cloud's longest side; 0: no mesh", 0, 390}};
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

Camera reduced(const Camera& camera, int by) {
  if (by < 1) throw std::invalid_argument("reduced: by = " + std::to_string(by) + " is not >= 1");
  Camera small = camera;
  small.width_px /= by;
  small.height_px /= by;
  small.fx_px /= by;
  small.fy_px /= by;
  // A pixel's centre is the middle of the centres that it covers.
  small.cx_px = (camera.cx_px + 0.5) / by - 0.5;
  small.cy_px = (camera.cy_px + 0.5) / by - 0.5;
  return small;
}

Capture reduced(const Capture& capture, int largest_side_px) {
  Capture small;
  small.pipeline = capture.pipeline;
  small.board = capture.board;
  small.warnings = capture.warnings;
  if (!capture.rig.empty()) {
    small.rig.push_back(capture.rig.front());
    Camera& camera = small.rig.front().camera;
    camera = reduced(camera, reduction(camera.width_px, camera.height_px, largest_side_px));
  }
  for (const Frame& frame : capture.frames) {
    Frame next{.id = frame.id, .time_s = frame.time_s, .rig_from_world = frame.rig_from_world};
    if (!frame.sensors.empty()) {
      const SensorFrame& from = frame.sensors.front();
      const int by = reduction(from.reported.width_px, from.reported.height_px, largest_side_px);
      SensorFrame sensor{.reported = reduced(from.reported, by)};
      if (!from.color.empty()) sensor.color = by > 1 ? reduced(from.color, by) : from.color;
      next.sensors.push_back(std::move(sensor));
    }
    small.frames.push_back(std::move(next));
  }
  return small;
}

Poses reduced(Poses poses, const Capture& full, int largest_side_px) {
  std::map<int, const Camera*> sizes;  // of frames with a photograph
  for (const Frame& frame : full.frames) {
    if (!frame.sensors.empty()) sizes[frame.id] = &frame.sensors.front().reported;
  }
  for (FramePose& pose : poses) {
    const auto found = sizes.find(pose.frame);
    if (found == sizes.end()) continue;
    Camera& camera = pose.camera;
    const Camera& size = *found->second;
    if (camera.width_px != size.width_px || camera.height_px != size.height_px) continue;
    camera = reduced(camera, reduction(camera.width_px, camera.height_px, largest_side_px));
  }
  return poses;
}

Image<std::uint8_t> reduced_mask(const Image<std::uint8_t>& mask, int width_px, int height_px) {
  const int by = width_px > 0 ? mask.width() / width_px : 0;
  if (by < 1 || height_px < 1 || mask.width() / by != width_px || mask.height() / by != height_px)
    throw std::invalid_argument("a mask of " + std::to_string(mask.width()) + " x " +
                                std::to_string(mask.height()) + " pixels for a photograph of " +
                                std::to_string(width_px) + " x " + std::to_string(height_px));
  Image<std::uint8_t> small(width_px, height_px, 255);
  for (int y = 0; y < by * height_px; ++y) {
    for (int x = 0; x < by * width_px; ++x) {
      if (mask(x, y) == 0) small(x / by, y / by) = 0;
    }
  }
  return small;
}

bool is_held_out(const ViewsPipelineConfig& config, std::size_t place) {
  const auto every = static_cast<std::size_t>(std::max(0, config.hold_out_every));
  return every > 1 && place % every == 0;
}

std::filesystem::path colmap_folder(const SplatCheckpoint& checkpoint) {
  return checkpoint.file.empty() ? std::filesystem::path()
                                 : std::filesystem::path(checkpoint.file.string() + ".colmap");
}

SeedsStages views_stages(const ViewsPipelineConfig& config, const Capture& full, std::uint64_t seed,
                         const SplatWatch& watch, std::shared_ptr<ViewsFindings> findings,
                         std::vector<Image<std::uint8_t>> masks) {
  validate(config);
  SeedsStages stages;
  // From the stage that finds the poses to the one that begins on their tracks.
  if (!findings) findings = std::make_shared<ViewsFindings>();
  stages.poses = [config, &full, findings, colmap = colmap_folder(watch.checkpoint)](
                     const Capture&, const SeedsEstimate&) {
    return reduced(place(full, config.poses, colmap, *findings), full, config.largest_side_px);
  };
  stages.splats = [config, seed, findings, watch, masks = std::move(masks)](
                      const Capture& capture, const SeedsEstimate& so_far) {
    return train(config, capture, so_far.poses, masks, *findings, seed, watch);
  };
  stages.depth = [](const Capture&, const SeedsEstimate& so_far) {
    return depths_of_splats(so_far.splats, so_far.poses, everywhere(), so_far.splats.low_pass_px2);
  };
  if (config.cloud_views > 0) {
    stages.cloud = [config](const Capture& capture, const SeedsEstimate& so_far) {
      return cloud_of(config, capture, so_far);
    };
  }
  if (config.mesh_cells > 0) {
    stages.surfaces = [config](const Capture&, const SeedsEstimate& so_far) {
      return mesh_of(config, so_far);
    };
  }
  return stages;
}

}  // namespace cousin
