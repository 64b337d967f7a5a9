// A sequence of the TUM RGB-D benchmark [Sturm et al., IROS 2012]
//   rgb.txt, depth.txt   time file
//   groundtruth.txt      time tx ty tz qx qy qz qw, camera to world
// Depth is 16-bit PNG, 5000 = 1 m, 0 = none, in the colour image's pixels.

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/text_fields.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr double kDepthUnit_m = 1 / 5000.0;
constexpr double kMostApart_s = 0.02;  ///< as the benchmark's associate.py
constexpr double kMostGap_s = 0.1;     ///< between poses, which come at 100 Hz
constexpr std::size_t kMaxFrames = 1'000'000;

template <class Record>
void check_times(const std::vector<Record>& records, const std::string& name) {
  for (std::size_t i = 1; i < records.size(); ++i) {
    if (!(records[i].time_s > records[i - 1].time_s)) {
      throw std::runtime_error(name + ": time " + exact_text(records[i].time_s) +
                               " is not above the one before it, " +
                               exact_text(records[i - 1].time_s));
    }
  }
  if (records.size() > kMaxFrames && name.ends_with("rgb.txt"))
    throw std::runtime_error(name + ": " + std::to_string(records.size()) +
                             " images; the limit is 1000000");
}

/// The first record not before the time.
template <class Record>
auto first_from(const std::vector<Record>& records, double time_s) {
  return std::lower_bound(records.begin(), records.end(), time_s,
                          [](const Record& record, double t) { return record.time_s < t; });
}

std::optional<TumFile> nearest(const std::vector<TumFile>& files, double time_s) {
  const auto after = first_from(files, time_s);
  std::optional<TumFile> best;
  const auto consider = [&](const TumFile& file) {
    const double apart_s = std::abs(file.time_s - time_s);
    if (apart_s > kMostApart_s) return;
    if (!best || apart_s < std::abs(best->time_s - time_s)) best = file;
  };
  if (after != files.begin()) consider(*std::prev(after));
  if (after != files.end()) consider(*after);
  return best;
}

std::optional<Pose> world_from_camera_at(const std::vector<TumPose>& poses, double time_s) {
  const auto after = first_from(poses, time_s);
  if (after == poses.end()) return std::nullopt;
  if (after->time_s == time_s) return after->world_from_camera;
  if (after == poses.begin()) return std::nullopt;
  const TumPose& before = *std::prev(after);
  if (after->time_s - before.time_s > kMostGap_s) return std::nullopt;
  // `interpolate` moves the origin of b on a line: of the camera, in the world.
  return interpolate(before.world_from_camera, after->world_from_camera,
                     (time_s - before.time_s) / (after->time_s - before.time_s));
}

std::string list_if_there(const fs::path& folder, const char* name) {
  return fs::exists(folder / name) ? read_file(resolve_inside(folder, name)) : std::string();
}

void read_depth(const fs::path& folder, const std::vector<std::optional<TumFile>>& files,
                Capture& capture) {
  for_each_frame(capture.frames.size(), [&](std::size_t i) {
    if (!files[i]) return;
    SensorFrame& sensor = capture.frames[i].sensors.front();
    const fs::path file = resolve_inside(folder, files[i]->file);
    sensor.depth = read_png16(file);
    check_image_size(file, capture.frames[i].id, sensor.depth.width(), sensor.depth.height(),
                     sensor.reported);
    sensor.depth_unit_m = kDepthUnit_m;
  });
}

}  // namespace

std::vector<TumFile> tum_files(std::string_view text, const std::string& name) {
  std::vector<TumFile> files;
  for (const TextLine& line : records(text, name)) files.push_back({line.number(0), line.rest(1)});
  check_times(files, name);
  return files;
}

std::vector<TumPose> tum_poses(std::string_view text, const std::string& name) {
  std::vector<TumPose> poses;
  for (const TextLine& line : records(text, name)) {
    if (line.size() != 8) line.fail("has " + std::to_string(line.size()) + " words, not 8");
    TumPose& pose = poses.emplace_back();
    pose.time_s = line.number(0);
    pose.world_from_camera.translation_m = {line.number(1), line.number(2), line.number(3)};
    Eigen::Quaterniond& q = pose.world_from_camera.rotation;
    q = {line.number(7), line.number(4), line.number(5), line.number(6)};
    const double norm = q.norm();
    if (!(std::abs(norm - 1) < 1e-2))
      line.fail("the quaternion's norm " + exact_text(norm) + " is not 1 to within 0.01");
    if (std::abs(norm - 1) > 1e-12) q.normalize();  // the benchmark's have four decimals
  }
  check_times(poses, name);
  return poses;
}

Capture import_tum(const fs::path& folder, const std::string& intrinsics) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": not a folder");
  const auto name = [&](const char* file) { return (folder / file).string(); };
  const std::vector<TumFile> colors =
      tum_files(read_file(resolve_inside(folder, "rgb.txt")), name("rgb.txt"));
  const std::vector<TumFile> depths =
      tum_files(list_if_there(folder, "depth.txt"), name("depth.txt"));
  const std::vector<TumPose> poses =
      tum_poses(list_if_there(folder, "groundtruth.txt"), name("groundtruth.txt"));
  if (colors.empty()) throw std::runtime_error(name("rgb.txt") + ": lists no image");
  std::string lens = intrinsics;
  if (lens.empty()) {
    lens = name("camera.yaml");
    if (!fs::exists(lens))
      throw std::runtime_error(folder.string() +
                               ": TUM's files hold no lens, and there is no camera.yaml: give "
                               "--intrinsics, a YAML file or fx,fy,cx,cy[,k1,k2,p1,p2,k3]");
  }
  const Image<Rgb8> first = read_color(resolve_inside(folder, colors.front().file));
  const Camera camera = camera_from_intrinsics(lens, first.width(), first.height());

  Capture capture;
  std::vector<fs::path> images;
  std::vector<std::optional<TumFile>> depth_of;
  for (std::size_t i = 0; i < colors.size(); ++i) {
    Frame& frame = capture.frames.emplace_back();
    frame.id = static_cast<int>(i);
    frame.time_s = colors[i].time_s;
    frame.sensors.push_back({.reported = camera});
    const std::optional<Pose> world_from_camera = world_from_camera_at(poses, frame.time_s);
    if (world_from_camera) frame.rig_from_world = inverse(*world_from_camera);
    images.push_back(resolve_inside(folder, colors[i].file));
    depth_of.push_back(nearest(depths, frame.time_s));
    const auto lacks = [&](const std::string& what) {
      capture.warnings.push_back(name("rgb.txt") + ": " + colors[i].file + " has no " + what);
    };
    if (!poses.empty() && !world_from_camera)
      lacks("pose: groundtruth.txt has none around its time, 0.1 s apart at most");
    if (!depths.empty() && !depth_of.back()) lacks("depth image within 0.02 s");
  }
  capture.rig.push_back({.camera = camera});
  read_frame_colors(capture, images);
  read_depth(folder, depth_of, capture);
  return capture;
}

}  // namespace cousin
