#include "benchmarks/real/fox_stereo.h"

#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "benchmarks/metrics/order_statistics.h"
#include "benchmarks/real/real_rows.h"
#include "perception/cloud/fuse.h"
#include "sim/dataset/import.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/image_io.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "fox";
constexpr const char* kCase = "instant-ngp fox, no truth";
constexpr double kSameSurface =
    0.01;  ///< relative depth difference of views that see the same surface

Image<Rgb8> scaled_image(const Image<Rgb8>& image, int width, int height) {
  Image<Rgb8> scaled(width, height);
  const double sx = static_cast<double>(image.width()) / width,
               sy = static_cast<double>(image.height()) / height;
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      double sum[3] = {0, 0, 0}, weight = 0;
      const int first_x = static_cast<int>(x * sx),
                last_x = std::min(image.width() - 1, static_cast<int>((x + 1) * sx));
      const int first_y = static_cast<int>(y * sy),
                last_y = std::min(image.height() - 1, static_cast<int>((y + 1) * sy));
      for (int v = first_y; v <= last_y; ++v) {
        const double wy = std::min(v + 1.0, (y + 1) * sy) - std::max<double>(v, y * sy);
        for (int u = first_x; u <= last_x; ++u) {
          const double w = wy * (std::min(u + 1.0, (x + 1) * sx) - std::max<double>(u, x * sx));
          const Rgb8 c = image(u, v);
          sum[0] += w * c.r;
          sum[1] += w * c.g;
          sum[2] += w * c.b;
          weight += w;
        }
      }
      const auto code = [&](int i) {
        return static_cast<std::uint8_t>(std::lround(sum[i] / weight));
      };
      scaled(x, y) = {code(0), code(1), code(2)};
    }
  });
  return scaled;
}

/// How one reference's depths compare with another's at the pixel they fall on.
struct Agreement {
  std::vector<double> relative;  ///< |difference| / depth, over all pairs of views
  std::int64_t pixels = 0;       ///< of the images with depth
  std::int64_t with_depth = 0;
  std::int64_t compared = 0;   ///< depths that fall on another view's depth
  std::int64_t confirmed = 0;  ///< of those, on the same surface in at least one view
};

Agreement compare_depths(const Poses& poses, const Depths& depths) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (!depths[i].depth_m.empty()) used.push_back(i);
  }
  Agreement sum;
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
      }
    }
  }
  return sum;
}

/// Near = white, far = dark, none = black; between the 2 % and 98 % points.
Image<std::uint8_t> depth_picture(const Image<float>& depth_m) {
  std::vector<double> inverse;
  for (const float z : depth_m) {
    if (std::isfinite(z)) inverse.push_back(1.0 / z);
  }
  Image<std::uint8_t> picture(depth_m.width(), depth_m.height());
  if (inverse.empty()) return picture;
  const double low = quantile(inverse, 0.02), high = quantile(inverse, 0.98);
  std::transform(depth_m.begin(), depth_m.end(), picture.begin(), [&](float z) {
    if (!std::isfinite(z)) return std::uint8_t{0};
    const double t = std::clamp((1.0 / z - low) / std::max(high - low, 1e-12), 0.0, 1.0);
    return static_cast<std::uint8_t>(std::lround(30 + 225 * t));
  });
  return picture;
}

void write_pictures(const fs::path& out, const Capture& capture, const Depths& depths) {
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].depth_m.empty()) continue;
    const std::string name = "fox_" + std::to_string(depths[i].frame);
    write_png(out / (name + "_depth.png"), depth_picture(depths[i].depth_m));
    write_png(out / (name + "_photo.png"), capture.frames[i].sensors[0].color);
  }
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

std::vector<ScoreRow> fox_stereo_rows(const fs::path& real_data, const fs::path& out, bool quick) {
  const fs::path file = real_data / "multiview/instantngp_fox/transforms.json";
  if (!fs::exists(file)) return {not_solved_row(kScene, kCase, "transforms.json is absent")};
  const Capture whole = import_nerfstudio(file);
  for (const Frame& frame : whole.frames) validate(frame.sensors.at(0).reported);
  const Capture capture = scaled_capture(whole, quick ? 0.25 : 0.4);
  const Poses poses = poses_of(capture);
  const SweepVolume volume = volume_looked_at(poses, 0.3);

  MvsConfig mvs;
  mvs.max_references = quick ? 8 : 12;
  mvs.min_angle_rad = 0.03;
  mvs.consistent_views = 0;      // what the views confirm is counted below
  mvs.consistency_depth = 0.01;  // largest standard deviation that is kept, relative
  const StageClock clock("stereo");
  const Depths depths = estimate_depths(capture, poses, volume, mvs);
  const double stereo_s = clock.finish().wall_s;
  const double side = volume.high_m.x() - volume.low_m.x();
  FuseConfig fuse;
  fuse.voxel_m = std::min(0.1, side / 400);
  fuse.agreement_m = std::min(0.1, side / 100);
  GreenConfig nothing;
  nothing.value_low = 255;  // an empty box: no pixel is green
  nothing.value_high = 0;
  const StageClock fuse_clock("fuse");
  const Cloud cloud = fuse_depths(capture, poses, depths, nothing, fuse);
  const double fuse_s = fuse_clock.finish().wall_s;
  const Agreement agreement = compare_depths(poses, depths);
  write_pictures(out, capture, depths);
  write_ply(out / "fox.ply", cloud);

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
  const auto frames = static_cast<std::int64_t>(capture.frames.size());
  const auto references = std::count_if(depths.begin(), depths.end(),
                                        [](const FrameDepth& d) { return !d.depth_m.empty(); });
  return {row("frames", static_cast<double>(frames), "1", frames),
          row("reader_warnings", static_cast<double>(whole.warnings.size()), "1", frames),
          row("views_with_depth", static_cast<double>(references), "1", frames),
          row("pixels_with_depth", share(agreement.with_depth, agreement.pixels), "1",
              agreement.pixels),
          row("depths_seen_by_another_view", share(agreement.compared, agreement.with_depth), "1",
              agreement.with_depth),
          row("seen_depths_within_1_percent", share(agreement.confirmed, agreement.compared), "1",
              agreement.compared),
          row("depth_difference.median_relative", at(0.5), "1", pairs),
          row("depth_difference.p90_relative", at(0.9), "1", pairs),
          row("points", static_cast<double>(cloud.size()), "1",
              static_cast<std::int64_t>(cloud.size())),
          row("seconds.stereo", stereo_s, "s", references),
          row("seconds.fuse", fuse_s, "s", references)};
}

}  // namespace cousin
