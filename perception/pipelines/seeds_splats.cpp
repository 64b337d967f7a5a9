#include "perception/pipelines/seeds_splats.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "perception/splats/splat_render.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"
#include "sim/imaging/undistort.h"

namespace cousin {
namespace {

constexpr std::array<Named<SplatPoses>, 3> kPoses = {
    {{SplatPoses::board, "board"}, {SplatPoses::sfm, "sfm"}, {SplatPoses::adjusted, "adjusted"}}};

/// Beyond the volume, of its longest side.
constexpr double kStrayShare = 0.2;
constexpr int kLeastSide_px = 16;  ///< of a photograph's part

/// Columns and rows of an image, last ones included.
struct Window {
  int left = 0, top = 0, right = -1, bottom = -1;
};

/// What the photograph, or the pinhole image made of it, shows of the volume. None where part of it
/// lies behind the camera or too little is left.
std::optional<Window> window_of(const FramePose& pose, const SweepVolume& volume, int margin_px) {
  const Lens lens(pose.camera), straight(undistorted_camera(pose.camera));
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d at_m((corner & 1 ? volume.high_m : volume.low_m).x(),
                               (corner & 2 ? volume.high_m : volume.low_m).y(),
                               (corner & 4 ? volume.high_m : volume.low_m).z());
    const Eigen::Vector3d in_camera_m = pose.camera_from_world * at_m;
    for (const Lens* seen_by : {&lens, &straight}) {
      const auto pixel = seen_by->project(in_camera_m);
      if (!pixel) return std::nullopt;
      low = low.cwiseMin(*pixel);
      high = high.cwiseMax(*pixel);
    }
  }
  const auto clamped = [](double value, int last) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(last)));
  };
  const Window window{clamped(std::floor(low.x()) - margin_px, pose.camera.width_px - 1),
                      clamped(std::floor(low.y()) - margin_px, pose.camera.height_px - 1),
                      clamped(std::ceil(high.x()) + margin_px, pose.camera.width_px - 1),
                      clamped(std::ceil(high.y()) + margin_px, pose.camera.height_px - 1)};
  if (window.right - window.left + 1 < kLeastSide_px ||
      window.bottom - window.top + 1 < kLeastSide_px) {
    return std::nullopt;
  }
  return window;
}

/// A photograph's part, and where it shows the screen, which is black in it.
struct PhotographPart {
  Image<Rgb8> color;
  Image<std::uint8_t> screen;
};
PhotographPart part_of(const Image<Rgb8>& image, const Image<std::uint8_t>& keep,
                       const Window& window) {
  const int width = window.right - window.left + 1, height = window.bottom - window.top + 1;
  PhotographPart part{Image<Rgb8>(width, height), Image<std::uint8_t>(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int from_x = window.left + x, from_y = window.top + y;
      const bool is_kept = keep(from_x, from_y) != 0;
      part.color(x, y) = is_kept ? image(from_x, from_y) : Rgb8{};
      part.screen(x, y) = is_kept ? 0 : 255;
    }
  }
  return part;
}

Camera camera_of(const Camera& camera, const Window& window) {
  Camera part = camera;
  part.width_px = window.right - window.left + 1;
  part.height_px = window.bottom - window.top + 1;
  part.cx_px -= window.left;
  part.cy_px -= window.top;
  return part;
}

constexpr float kSameSurface = 0.01F;  ///< relative difference of depths

/// Depth between the four pixels around a place: their mixture on one surface, the nearest one's at
/// an edge; NaN outside.
float depth_at(const Image<float>& depth_m, const Eigen::Vector2d& pixel_px) {
  const int x = static_cast<int>(std::floor(pixel_px.x()));
  const int y = static_cast<int>(std::floor(pixel_px.y()));
  if (!depth_m.contains(x, y) || !depth_m.contains(x + 1, y + 1)) return NAN;
  const std::array<float, 4> around = {depth_m(x, y), depth_m(x + 1, y), depth_m(x, y + 1),
                                       depth_m(x + 1, y + 1)};
  const auto [low, high] = std::minmax_element(around.begin(), around.end());
  const auto right = static_cast<float>(pixel_px.x() - x),
             down = static_cast<float>(pixel_px.y() - y);
  const bool finite =
      std::all_of(around.begin(), around.end(), [](float d) { return std::isfinite(d); });
  if (!finite || *high - *low > kSameSurface * *low)
    return depth_m(x + (right >= 0.5F ? 1 : 0), y + (down >= 0.5F ? 1 : 0));
  const float above = around[0] + right * (around[1] - around[0]);
  const float below = around[2] + right * (around[3] - around[2]);
  return above + down * (below - above);
}

bool contains(const SweepVolume& volume, const Eigen::Vector3d& at_m) {
  return (at_m.array() >= volume.low_m.array()).all() &&
         (at_m.array() <= volume.high_m.array()).all();
}

Image<float> depth_of_view(const SplatModel& model, const FramePose& pose,
                           const SweepVolume& volume, double low_pass_px2) {
  const Camera straight = undistorted_camera(pose.camera);
  const Image<float> rendered_m =
      render_splats(model, straight, pose.camera_from_world, {.low_pass_px2 = low_pass_px2})
          .depth_m;
  const Lens lens(pose.camera), pinhole(straight);
  const Pose world_from_camera = inverse(pose.camera_from_world);
  Image<float> depth_m(pose.camera.width_px, pose.camera.height_px, NAN);
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const auto ray = lens.unproject({x, y});
      if (!ray || !(ray->z() > 0)) continue;
      const auto pixel = pinhole.project(*ray);
      if (!pixel) continue;
      const float value_m = depth_at(rendered_m, *pixel);
      if (!std::isfinite(value_m)) continue;
      if (contains(volume, world_from_camera * (static_cast<double>(value_m) / ray->z() * *ray)))
        depth_m(x, y) = value_m;
    }
  });
  return depth_m;
}

/// Of each pixel whose four neighbours show the same surface: across the lines between them, unit,
/// in the camera and towards it; else zero.
Image<Eigen::Vector3f> normals_of(const Image<float>& depth_m, const Camera& camera) {
  const Lens lens(camera);
  const int width = depth_m.width(), height = depth_m.height();
  Image<Eigen::Vector3f> point_m(width, height, Eigen::Vector3f::Constant(NAN));
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      if (!std::isfinite(depth_m(x, y))) continue;
      if (const auto ray = lens.unproject({x, y}); ray && ray->z() > 0)
        point_m(x, y) = (static_cast<double>(depth_m(x, y)) / ray->z() * *ray).cast<float>();
    }
  });
  Image<Eigen::Vector3f> normal(width, height, Eigen::Vector3f::Zero());
  tbb::parallel_for(1, std::max(1, height - 1), [&](int y) {
    for (int x = 1; x + 1 < width; ++x) {
      const float here_m = depth_m(x, y);
      const std::array<Eigen::Vector3f, 4> around = {point_m(x - 1, y), point_m(x + 1, y),
                                                     point_m(x, y - 1), point_m(x, y + 1)};
      const bool is_surface = std::all_of(around.begin(), around.end(), [&](const auto& p) {
        return std::abs(p.z() - here_m) <= kSameSurface * here_m;  // not of NaN
      });
      if (!is_surface) continue;
      const Eigen::Vector3f across =
          Eigen::Vector3f(around[1] - around[0]).cross(Eigen::Vector3f(around[3] - around[2]));
      if (!(across.norm() > 0)) continue;
      normal(x, y) = (across.dot(point_m(x, y)) > 0 ? -1 : 1) * across.normalized();
    }
  });
  return normal;
}

}  // namespace

std::string_view to_string(SplatPoses poses) { return name_in<SplatPoses>(kPoses, poses); }

Fields fields(SeedsSplatConfig& config) {
  return {
      {"poses", choice_field<SplatPoses>("poses", kPoses, config.poses),
       "board: from its corners; sfm: by COLMAP without the lens, scaled by the board's squares, "
       "as "
       "the paper; adjusted: COLMAP's tracks adjusted with the reported lens and the corners"},
      {"steps", &config.steps, "splats: training steps, one view each", 1, 1e6},
      {"most_splats", &config.most_splats, "splats: Gaussians at the end", 1, 1e7},
      {"reference_steps", &config.reference_steps,
       "splats_paper: steps of the reference's 30,000 after which training is left", 1, 30000},
      {"reference_points", &config.reference_points,
       "splats_paper: Gaussians at the beginning, where COLMAP has none", 1, 1e6},
      {"start_points", &config.start_points, "splats: Gaussians at the beginning", 1, 1e6},
      {"centre_rate", &config.centre_rate,
       "splats: first rate of the centres, a share of the cameras' extent; the last is a hundredth",
       1e-9, 1},
      {"flatness", &config.flatness,
       "splats: thickness of a Gaussian over its width at the start, across the surface", 1e-3, 1},
      {"shape_rate", &config.shape_rate,
       "splats: rates of scales and rotations over those that training has", 0, 1},
      {"opacity_rate", &config.opacity_rate,
       "splats: rate of opacities over the one that training has", 0, 1},
      {"start_opacity", &config.start_opacity, "splats: of each Gaussian at the start", 0.01, 0.99},
      {"low_pass_px2", &config.low_pass_px2,
       "splats: added to the variances of a Gaussian in the image; the reference has 0.3", 1e-6,
       100},
      {"raised_share", &config.raised_share, "splats: of the points at the start, those on grains",
       0, 1},
      {"least_opacity", &config.least_opacity,
       "splats_paper: opacity of a centre that becomes a point", 0, 1},
      {"margin_px", &config.margin_px, "splats: kept around the volume in each photograph", 0,
       100000},
      {"reference_margin_px", &config.reference_margin_px,
       "splats_paper: the same; less needs less memory", 0, 100000},
      {"hold_out_every", &config.hold_out_every,
       "every so many-th view has no part in the training and only scores it; 0 or 1: all have", 0,
       1000},
      {"most_pixels", &config.most_pixels,
       "of all photographs of a training together: 12 to 20 bytes each", 1, 1e10}};
}

void validate(const SeedsSplatConfig& config) {
  SeedsSplatConfig copy = config;
  check_limits(fields(copy), "splats");
}

bool is_held_out(const SeedsSplatConfig& config, int frame) {
  const int every = config.hold_out_every;
  return every > 1 && frame % every == every / 2;
}

Poses training_poses(const SeedsSplatConfig& config, Poses poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (is_held_out(config, static_cast<int>(i))) poses[i].status = PoseStatus::no_board;
  }
  return poses;
}

Poses poses_by_sfm(const Capture& capture, const Corners& corners, const SeedBoard& board,
                   const SweepVolume& volume, const SfmConfig& config,
                   std::vector<StartPoint>& points,
                   const std::function<void(const SfmEstimate&)>& posed) {
  points.clear();
  const SfmEstimate estimate = estimate_poses_sfm(capture, corners, board, config);
  if (posed) posed(estimate);
  if (!has_poses(estimate.status) || estimate.gauge != BundleGauge::metric) {
    throw NoPosesError(estimate.status,
                       "no metric model: " + std::string(to_string(estimate.status)) +
                           (estimate.reason.empty() ? "" : ", " + estimate.reason));
  }
  for (const SfmPoint& point : estimate.points) {
    if (contains(volume, point.in_world_m)) points.push_back({point.in_world_m, point.color});
  }
  return estimate.poses;
}

std::vector<SplatView> seed_views(const Capture& capture, const Poses& poses,
                                  const SweepVolume& volume, const GreenConfig& green,
                                  int margin_px, double most_pixels) {
  Capture cut;
  cut.rig = capture.rig;
  Poses cut_poses;
  std::vector<Image<std::uint8_t>> screens;
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    const Frame& frame = capture.frames[i];
    if (poses.at(i).status != PoseStatus::ok || frame.sensors.empty() ||
        frame.sensors.front().color.empty()) {
      continue;
    }
    const Image<Rgb8>& color = frame.sensors.front().color;
    const Camera& camera = poses[i].camera;
    if (color.width() != camera.width_px || color.height() != camera.height_px)
      throw std::invalid_argument("frame " + std::to_string(frame.id) + ": its photograph is " +
                                  std::to_string(color.width()) + " x " +
                                  std::to_string(color.height()) + ", the camera of its pose " +
                                  std::to_string(camera.width_px) + " x " +
                                  std::to_string(camera.height_px));
    const auto window = window_of(poses[i], volume, margin_px);
    if (!window) continue;
    Frame next{.id = frame.id, .time_s = frame.time_s};
    FramePose pose = poses[i];
    pose.camera = camera_of(pose.camera, *window);
    PhotographPart part = part_of(color, without_specks(remove_green(color, green)), *window);
    next.sensors.push_back({.reported = pose.camera, .color = std::move(part.color)});
    screens.push_back(std::move(part.screen));
    cut.frames.push_back(std::move(next));
    cut_poses.push_back(pose);
  }
  std::vector<SplatView> views =
      splat_views(cut, cut_poses, {}, {.most_pixels = most_pixels}, screens);
  for (SplatView& view : views) {  // back to the frames of the capture
    const int id = cut.frames[static_cast<std::size_t>(view.frame)].id;
    const auto own = std::find_if(capture.frames.begin(), capture.frames.end(),
                                  [&](const Frame& frame) { return frame.id == id; });
    view.frame = static_cast<int>(own - capture.frames.begin());
  }
  return views;
}

void fill_start(const SweepVolume& volume, int count, Rng rng, std::vector<StartPoint>& start) {
  if (2 * start.size() >= static_cast<std::size_t>(count)) return;
  const auto more = random_start_points(volume.low_m, volume.high_m,
                                        count - static_cast<int>(start.size()), std::move(rng));
  start.insert(start.end(), more.begin(), more.end());
}

SplatModel train_on_views(std::span<const SplatView> views, std::span<const StartPoint> from,
                          const SplatStartConfig& start_config, const SplatTrainConfig& training,
                          int stop_after, const SplatWatch& watch) {
  const SplatModel start = splats_from_points(from, start_config);
  const auto go_on = [&](const SplatTrainPoint& point) {
    if (watch.progress) watch.progress(point.step, stop_after);
    return point.step < stop_after;
  };
  SplatCheckpoint checkpoint = watch.checkpoint;
  checkpoint.most_steps = stop_after;
  SplatTraining trained = train_splats(views, start, training, go_on, checkpoint, watch.snapshots);
  if (watch.end) watch.end(trained);
  switch (trained.status) {
    case SplatTrainStatus::ok:
    case SplatTrainStatus::stopped:
      return std::move(trained.model);
    case SplatTrainStatus::not_finite:
      throw std::runtime_error("training diverged: the loss is not a number");
    case SplatTrainStatus::too_many_pairs:
      if (watch.left_early && !trained.curve.empty()) {
        watch.left_early("training was left after step " +
                         std::to_string(trained.curve.back().step) + " of " +
                         std::to_string(stop_after) + ": " + explained(trained.status));
        return std::move(trained.model);
      }
      [[fallthrough]];
    default: {
      SplatModel none;
      none.why_none = explained(trained.status);
      return none;
    }
  }
}

SplatModel without_strays(SplatModel model, const SweepVolume& volume) {
  const double reach_m = kStrayShare * (volume.high_m - volume.low_m).maxCoeff();
  const bool has_views = model.views_seen.size() == model.splats.size();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < model.splats.size(); ++i) {
    const Eigen::Vector3d at_m = model.origin_in_world_m + model.splats[i].centre_m.cast<double>();
    const Eigen::Vector3d beyond_m = (volume.low_m - at_m).cwiseMax(at_m - volume.high_m);
    if (!at_m.allFinite() || beyond_m.maxCoeff() > reach_m) continue;
    model.splats[kept] = model.splats[i];
    if (has_views) model.views_seen[kept] = model.views_seen[i];
    ++kept;
  }
  if (kept == 0 && !model.splats.empty())
    model.why_none =
        to_string(SplatTrainStatus::nothing_left) + ": every Gaussian has left the volume";
  model.splats.resize(kept);
  if (has_views) model.views_seen.resize(kept);
  return model;
}

Depths depths_of_splats(const SplatModel& model, const Poses& poses, const SweepVolume& volume,
                        double low_pass_px2, bool with_normals) {
  Depths depths;
  for (const FramePose& pose : poses) {
    FrameDepth depth{pose.frame, {}, {}};
    if (pose.status == PoseStatus::ok && !model.splats.empty()) {
      depth.depth_m = depth_of_view(model, pose, volume, low_pass_px2);
      if (with_normals) depth.normal = normals_of(depth.depth_m, pose.camera);
    }
    depths.push_back(std::move(depth));
  }
  return depths;
}

}  // namespace cousin
