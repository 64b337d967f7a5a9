#include "benchmarks/suites/real/fox_stereo.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "benchmarks/report/pictures.h"
#include "benchmarks/score/order_statistics.h"
#include "perception/cloud/fuse.h"
#include "sim/dataset/import.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/undistort.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "fox";
constexpr const char* kCase = "instant-ngp fox, no truth";
constexpr double kSameSurface =
    0.01;  ///< relative depth difference of views that see the same surface

/// How one reference's depths compare with another's at the pixel they fall on.
struct Agreement {
  std::vector<double> relative;  ///< |difference| / depth, over all pairs of views
  std::int64_t pixels = 0;       ///< of the images with depth
  std::int64_t with_depth = 0;
  std::int64_t compared = 0;   ///< depths that fall on another view's depth
  std::int64_t confirmed = 0;  ///< of those, on the same surface in at least one view
  Depths confirmed_depths;     ///< the others are NaN
};

Agreement compare_depths(const Poses& poses, const Depths& depths) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!depths[i].depth_m.empty()) used.push_back(i);
  }
  Agreement sum;
  sum.confirmed_depths = depths;
  for (const std::size_t i : used) {
    const Image<float>& mine = depths[i].depth_m;
    sum.pixels += static_cast<std::int64_t>(mine.size());
    const Pose world_from_camera = inverse(poses[i].camera_from_world);
    for (int y = 0; y < mine.height(); ++y) {
      for (int x = 0; x < mine.width(); ++x) {
        if (!std::isfinite(mine(x, y))) continue;
        ++sum.with_depth;
        const auto ray = unproject(poses[i].camera, {x, y});
        if (!ray) continue;
        const Eigen::Vector3d world =
            world_from_camera * Eigen::Vector3d(*ray * (mine(x, y) / ray->z()));
        bool seen = false, same = false;
        for (const std::size_t j : used) {
          if (j == i) continue;
          const Eigen::Vector3d there = poses[j].camera_from_world * world;
          const auto pixel = project(poses[j].camera, there);
          if (!pixel) continue;
          const int u = static_cast<int>(std::lround(pixel->x())),
                    v = static_cast<int>(std::lround(pixel->y()));
          if (!depths[j].depth_m.contains(u, v) || !std::isfinite(depths[j].depth_m(u, v)))
            continue;
          const double relative = std::abs(depths[j].depth_m(u, v) / there.z() - 1);
          sum.relative.push_back(relative);
          seen = true;
          same = same || relative < kSameSurface;
        }
        sum.compared += seen ? 1 : 0;
        sum.confirmed += same ? 1 : 0;
        if (!same) sum.confirmed_depths[i].depth_m(x, y) = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  return sum;
}

/// The cloud turned so that the page shows it as one photograph does: z up, y away from the camera.
Cloud as_seen_from(const FramePose& pose, Cloud cloud) {
  for (CloudPoint& point : cloud) {
    const Eigen::Vector3d p = pose.camera_from_world * point.position_m.cast<double>();
    point.position_m = Eigen::Vector3d(p.x(), p.z(), -p.y()).cast<float>();
  }
  return cloud;
}

/// How far the lens bends the rays of its own image, and how much of that a pinhole keeps.
struct Bending {
  double largest_shift_px = 0;
  double valid_share = 0;
};
Bending bending(const Undistorted<Rgb8>& flat, const Camera& lens) {
  Bending result;
  std::int64_t valid = 0;
  for (int y = 0; y < flat.camera.height_px; ++y) {
    for (int x = 0; x < flat.camera.width_px; ++x) {
      if (flat.valid(x, y) == 0) continue;
      ++valid;
      const auto ray = unproject(flat.camera, {x, y});
      const auto pixel = ray ? project(lens, *ray) : std::nullopt;
      if (!pixel) continue;
      result.largest_shift_px =
          std::max(result.largest_shift_px, (*pixel - Eigen::Vector2d(x, y)).norm());
    }
  }
  result.valid_share = static_cast<double>(valid) / static_cast<double>(flat.valid.size());
  return result;
}

/// Photograph, the same without distortion, and depth of each view that has one; two of them on
/// the page.
void write_pictures(const fs::path& out, const Capture& capture, const Depths& depths,
                    RealPart& part) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!depths[i].depth_m.empty()) used.push_back(i);
  }
  for (std::size_t k = 0; k < used.size(); ++k) {
    const FrameDepth& depth = depths[used[k]];
    const SensorFrame& sensor = capture.frames[used[k]].sensors[0];
    const Undistorted<Rgb8> flat =
        undistort(sensor.color, sensor.reported,
                  {.interpolation = UndistortConfig::Interpolation::cubic}, {255, 255, 255});
    const Image<Rgb8> colored = depth_in_color(depth.depth_m);
    const std::string name = "fox_" + std::to_string(depth.frame);
    write_png(out / (name + "_photo.png"), sensor.color);
    write_png(out / (name + "_undistorted.png"), flat.image);
    write_png(out / (name + "_depth.png"), colored);
    if (k != 0 && k != used.size() / 4) continue;  // its side and its face
    part.images.push_back(
        {"Fox, photograph " + std::to_string(depth.frame),
         "As taken; as a pinhole camera would have taken it; depth by plane sweep where another "
         "view agrees within 1 %, near red, far blue, none grey. Nobody measured the fox.",
         encode_png(side_by_side({sensor.color, flat.image, colored}))});
  }
}

MvsConfig fox_depths(bool quick) {
  MvsConfig mvs;
  mvs.max_references = quick ? 8 : 12;
  mvs.min_angle_rad = 0.03;
  mvs.consistent_views = 0;      // what the views confirm is counted afterwards
  mvs.consistency_depth = 0.01;  // largest standard deviation that is kept, relative
  return mvs;
}

/// What the photographs of the fox gave, and in how long.
struct FoxRun {
  std::size_t warnings = 0;
  std::int64_t frames = 0, references = 0, points = 0;
  double stereo_s = 0, fuse_s = 0;
};

std::vector<ScoreRow> fox_rows(const FoxRun& run, const Agreement& agreement, const Bending& bent) {
  const auto row = [&](const std::string& metric, double value, const std::string& unit,
                       std::int64_t n) {
    return real_row(kScene, kCase, "plane sweep and slanted refinement", metric, value, unit, n);
  };
  const auto share = [](std::int64_t a, std::int64_t b) {
    return b == 0 ? ScoreRow::kNone : static_cast<double>(a) / static_cast<double>(b);
  };
  const auto at = [&](double p) {
    return agreement.relative.empty() ? ScoreRow::kNone : quantile(agreement.relative, p);
  };
  const auto pairs = static_cast<std::int64_t>(agreement.relative.size());
  return {row("frames", static_cast<double>(run.frames), "1", run.frames),
          row("reader_warnings", static_cast<double>(run.warnings), "1", run.frames),
          row("undistortion.largest_shift", bent.largest_shift_px, "px", 1),
          row("undistortion.valid_pixels", bent.valid_share, "1", 1),
          row("views_with_depth", static_cast<double>(run.references), "1", run.frames),
          row("pixels_with_depth", share(agreement.with_depth, agreement.pixels), "1",
              agreement.pixels),
          row("pixels_with_confirmed_depth", share(agreement.confirmed, agreement.pixels), "1",
              agreement.pixels),
          row("depths_seen_by_another_view", share(agreement.compared, agreement.with_depth), "1",
              agreement.with_depth),
          row("seen_depths_within_1_percent", share(agreement.confirmed, agreement.compared), "1",
              agreement.compared),
          row("depth_difference.median_relative", at(0.5), "1", pairs),
          row("depth_difference.p90_relative", at(0.9), "1", pairs),
          row("points", static_cast<double>(run.points), "1", run.points),
          row("seconds.stereo", run.stereo_s, "s", run.references),
          row("seconds.fuse", run.fuse_s, "s", run.references)};
}

}  // namespace

Poses poses_of(const Capture& capture) {
  Poses poses;
  for (const Frame& frame : capture.frames) {
    FramePose pose;
    pose.frame = frame.id;
    if (frame.rig_from_world && !frame.sensors.empty()) {
      pose.status = PoseStatus::ok;
      pose.camera_from_world = capture.rig.at(0).sensor_from_rig * *frame.rig_from_world;
      pose.camera = frame.sensors[0].reported;
    }
    poses.push_back(pose);
  }
  return poses;
}

SweepVolume volume_looked_at(const Poses& poses, double half_side_over_distance) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> centres;
  for (const FramePose& pose : poses) {
    if (pose.status != PoseStatus::ok) continue;
    const Pose world_from_camera = inverse(pose.camera_from_world);
    const Eigen::Vector3d axis = world_from_camera.rotation * Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    normal += across;
    right += across * world_from_camera.translation_m;
    centres.push_back(world_from_camera.translation_m);
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(normal);
  if (centres.size() < 2 || !(solver.rcond() > 1e-6)) {
    throw std::invalid_argument("volume_looked_at: " + std::to_string(centres.size()) +
                                " posed views whose optical axes do not meet");
  }
  const Eigen::Vector3d point = solver.solve(right);
  std::vector<double> distances;
  for (const Eigen::Vector3d& centre : centres) distances.push_back((centre - point).norm());
  const double half = half_side_over_distance * quantile(distances, 0.5);
  return {point.array() - half, point.array() + half};
}

Capture scaled_capture(Capture capture, double factor) {
  if (!(factor > 0 && factor <= 1)) {
    throw std::invalid_argument("scaled_capture: factor = " + std::to_string(factor) +
                                " is not within (0, 1]");
  }
  const auto side = [&](int px) { return std::max(1, static_cast<int>(std::lround(px * factor))); };
  for (SensorReport& sensor : capture.rig) {
    sensor.camera =
        resized(sensor.camera, side(sensor.camera.width_px), side(sensor.camera.height_px));
  }
  for (Frame& frame : capture.frames) {
    for (SensorFrame& sensor : frame.sensors) {
      const int width = side(sensor.reported.width_px), height = side(sensor.reported.height_px);
      sensor.reported = resized(sensor.reported, width, height);
      if (!sensor.color.empty()) sensor.color = scaled_image(sensor.color, width, height);
    }
  }
  return capture;
}

RealPart fox_stereo(const fs::path& real_data, const fs::path& out, bool quick) {
  const fs::path file = real_data / "multiview/instantngp_fox/transforms.json";
  RealPart part;
  if (!fs::exists(file)) {
    part.rows.push_back(not_solved_row(kScene, kCase, "transforms.json is absent"));
    return part;
  }
  const Capture whole = import_nerfstudio(file);
  for (const Frame& frame : whole.frames) validate(frame.sensors.at(0).reported);
  const Capture capture = scaled_capture(whole, quick ? 0.25 : 0.4);
  const Poses poses = poses_of(capture);
  // Wide enough for all that the photographs show, so that only what no view confirms is without
  // depth.
  const SweepVolume volume = volume_looked_at(poses, 0.7);

  const StageClock clock("stereo");
  const Depths depths = estimate_depths(capture, poses, volume, fox_depths(quick));
  const double stereo_s = clock.finish().wall_s;
  const double side = volume.high_m.x() - volume.low_m.x();
  FuseConfig fuse;
  fuse.voxel_m = std::min(0.1, side / 400);
  fuse.agreement_m = std::min(0.1, side / 100);
  GreenConfig nothing;
  nothing.value_low = 255;  // an empty box: no pixel is green
  nothing.value_high = 0;
  const Agreement agreement = compare_depths(poses, depths);
  const StageClock fuse_clock("fuse");
  const Cloud cloud = fuse_depths(capture, poses, agreement.confirmed_depths, nothing, fuse);
  const double fuse_s = fuse_clock.finish().wall_s;
  write_pictures(out, capture, agreement.confirmed_depths, part);
  write_ply(out / "fox.ply", cloud);
  part.shapes.push_back(cloud_shape("Fox", "Points fused from the confirmed depths.",
                                    as_seen_from(poses[capture.frames.size() / 4], cloud)));
  const SensorFrame& first = capture.frames.front().sensors[0];
  const Bending bent = bending(undistort(first.color, first.reported), first.reported);
  const auto references = std::count_if(depths.begin(), depths.end(),
                                        [](const FrameDepth& d) { return !d.depth_m.empty(); });
  part.rows = fox_rows({.warnings = whole.warnings.size(),
                        .frames = static_cast<std::int64_t>(capture.frames.size()),
                        .references = references,
                        .points = static_cast<std::int64_t>(cloud.size()),
                        .stereo_s = stereo_s,
                        .fuse_s = fuse_s},
                       agreement, bent);
  return part;
}

}  // namespace cousin
