// A sequence of the TUM RGB-D benchmark [Sturm et al., IROS 2012]
//   rgb.txt, depth.txt   time file
//   groundtruth.txt      time tx ty tz qx qy qz qw, camera to world
// Depth is 16-bit PNG, 5000 = 1 m, 0 = none, in the colour image's pixels. Other units come by the
// caller, or by a comment of depth.txt such as "# 5000 = 1 m". Times are seconds, or nanoseconds
// since 1970, as robots write them.

#include <cmath>
#include <optional>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/depth_units.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/text_fields.h"
#include "sim/dataset/time_stamps.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr double kDepthUnit_m = 1 / 5000.0;
constexpr double kMostGap_s = 0.1;  ///< between poses, which come at 100 Hz
/// A pose so near to a picture is its own: a hand moves by less than a millimetre in that time.
constexpr double kSameTime_s = 1e-3;
constexpr std::size_t kMaxTumFrames = 1'000'000;

template <class Record>
void check_times(const std::vector<Record>& records, const std::string& name) {
  for (std::size_t i = 1; i < records.size(); ++i) {
    if (!(records[i].time_s > records[i - 1].time_s)) {
      throw std::runtime_error(name + ": time " + exact_text(records[i].time_s) +
                               " is not above the one before it, " +
                               exact_text(records[i - 1].time_s));
    }
  }
  if (records.size() > kMaxTumFrames && name.ends_with("rgb.txt"))
    throw std::runtime_error(name + ": " + std::to_string(records.size()) +
                             " images; the limit is 1000000");
}

std::optional<Pose> world_from_camera_at(const std::vector<TumPose>& poses, double time_s) {
  const auto after = first_from(poses, time_s);
  const bool is_between = after != poses.begin() && after != poses.end();
  if (is_between && after->time_s - std::prev(after)->time_s <= kMostGap_s + kTimeRounding_s) {
    const TumPose& before = *std::prev(after);
    // `interpolate` moves the origin of b on a line: of the camera, in the world.
    if (after->time_s == time_s) return after->world_from_camera;
    return interpolate(before.world_from_camera, after->world_from_camera,
                       (time_s - before.time_s) / (after->time_s - before.time_s));
  }
  const auto near = nearest(poses, time_s, kSameTime_s);
  if (near == poses.end()) return std::nullopt;
  return near->world_from_camera;
}

std::string list_if_there(const fs::path& folder, const char* name) {
  return fs::exists(folder / name) ? read_file(resolve_inside(folder, name)) : std::string();
}

/// Of a comment such as "# time file, 5000 = 1 m": metres a unit.
std::optional<double> unit_in_comments(std::string_view text, const std::string& name) {
  TextLines lines(text, name);
  while (!lines.at_end()) {
    const TextLine line = lines.next();
    if (line.size() == 0 || !line.text(0).starts_with('#')) continue;
    for (std::size_t i = 1; i + 3 < line.size(); ++i) {
      if (!line.is_number(i) || line.text(i + 1) != "=" || line.text(i + 2) != "1" ||
          line.text(i + 3) != "m")
        continue;
      const double units = line.number(i);
      if (!(units >= 1 && units <= 1e6)) line.fail("a metre of that many units is not in [1, 1e6]");
      return 1 / units;
    }
  }
  return std::nullopt;
}

/// Where nothing says the unit: the benchmark's, unless the depth is then none that its cameras
/// measure. @throws std::runtime_error naming the option and what usual units make of the depth.
void check_default_unit(const Capture& capture, const std::string& name) {
  constexpr double kLeast_m = 0.4, kMost_m = 10;
  const std::optional<double> units = median_depth(capture, 0, DepthMeasure::units);
  if (!units) return;
  const double metres = *units * kDepthUnit_m;
  if (metres >= kLeast_m && metres <= kMost_m) return;
  throw std::runtime_error(name + ": the median depth is " + exact_text(*units) +
                           " units; with TUM's 5000 units a metre that is " + short_text(metres) +
                           " m, outside [0.4, 10] m. " + usual_depth_units(*units));
}

void read_depth(const fs::path& folder, const std::string& name,
                const std::vector<std::optional<TumFile>>& files, double unit_m, Capture& capture) {
  std::vector<std::optional<fs::path>> found(files.size());
  std::vector<fs::path> there;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (files[i]) found[i] = find_listed_image(folder, files[i]->file);
    if (found[i]) there.push_back(*found[i]);
  }
  check_depth_memory(folder, capture, there);
  std::vector<char> is_absent(files.size());
  for_each_frame(capture.frames.size(), [&](std::size_t i) {
    if (!files[i]) return;
    SensorFrame& sensor = capture.frames[i].sensors.front();
    const std::optional<fs::path>& file = found[i];
    is_absent[i] = !file;
    if (!file) return;
    sensor.depth = read_png16(*file);
    check_image_size(*file, capture.frames[i].id, sensor.depth.width(), sensor.depth.height(),
                     sensor.reported);
    sensor.depth_unit_m = unit_m;
  });
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (is_absent[i])
      capture.warnings.push_back(name + ": " + files[i]->file + " is skipped: it is absent");
  }
}

/// Seconds, of a list's first word.
double seconds_of(const TextLine& line) {
  const double time = line.number(0);
  if (const std::optional<double> seconds = seconds_of_stamp(time)) return *seconds;
  line.fail("the time " + exact_text(time) +
            " is neither in seconds, below 1e11, nor in nanoseconds since 1970, from 1e17 on");
}

std::string lens_of(const fs::path& folder, const std::string& intrinsics) {
  if (!intrinsics.empty()) return intrinsics;
  if (!fs::exists(folder / "camera.yaml"))
    throw std::runtime_error(folder.string() +
                             ": TUM's files hold no lens, and there is no camera.yaml: give "
                             "--intrinsics, a YAML file or fx,fy,cx,cy[,k1,k2,p1,p2,k3]");
  return resolve_inside(folder, "camera.yaml").string();
}

}  // namespace

std::vector<TumFile> tum_files(std::string_view text, const std::string& name) {
  std::vector<TumFile> files;
  for (const TextLine& line : records(text, name)) {
    files.push_back({seconds_of(line), line.rest(1)});
    require_utf8(files.back().file, line.where().substr(0, line.where().size() - 2));
  }
  check_times(files, name);
  return files;
}

std::vector<TumPose> tum_poses(std::string_view text, const std::string& name) {
  std::vector<TumPose> poses;
  for (const TextLine& line : records(text, name)) {
    if (line.size() != 8) line.fail("has " + std::to_string(line.size()) + " words, not 8");
    TumPose& pose = poses.emplace_back();
    pose.time_s = seconds_of(line);
    for (int k = 0; k < 3; ++k)
      pose.world_from_camera.translation_m[k] =
          line.number_within(static_cast<std::size_t>(1 + k), kMostCoordinate);
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

Capture import_tum(const fs::path& folder, const std::string& intrinsics,
                   std::optional<double> depth_unit_m) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": not a folder");
  const auto name = [&](const char* file) { return (folder / file).string(); };
  const std::vector<TumFile> colors =
      tum_files(read_file(resolve_inside(folder, "rgb.txt")), name("rgb.txt"));
  const std::string depth_text = list_if_there(folder, "depth.txt");
  const std::vector<TumFile> depths = tum_files(depth_text, name("depth.txt"));
  const std::vector<TumPose> poses =
      tum_poses(list_if_there(folder, "groundtruth.txt"), name("groundtruth.txt"));
  if (colors.empty()) throw std::runtime_error(name("rgb.txt") + ": lists no image");
  const std::string lens = lens_of(folder, intrinsics);

  Capture capture;
  std::vector<fs::path> images;
  std::vector<std::optional<TumFile>> depth_of;
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const std::optional<fs::path> image = find_listed_image(folder, colors[i].file);
    if (!image) {
      capture.warnings.push_back(name("rgb.txt") + ": " + colors[i].file +
                                 " is skipped: it is absent");
      continue;
    }
    images.push_back(*image);
    Frame& frame = capture.frames.emplace_back();
    frame.id = static_cast<int>(i);
    frame.time_s = colors[i].time_s;
    frame.sensors.emplace_back();
    const std::optional<Pose> world_from_camera = world_from_camera_at(poses, frame.time_s);
    if (world_from_camera) frame.rig_from_world = inverse(*world_from_camera);
    const auto depth = nearest(depths, frame.time_s, kMostApart_s);
    depth_of.push_back(depth == depths.end() ? std::nullopt : std::optional(*depth));
    const auto lacks = [&](const std::string& what) {
      capture.warnings.push_back(name("rgb.txt") + ": " + colors[i].file + " has no " + what);
    };
    if (!poses.empty() && !world_from_camera)
      lacks("pose: groundtruth.txt has none around its time, 0.1 s apart at most");
    if (!depths.empty() && !depth_of.back()) lacks("depth image within 0.02 s");
  }
  if (images.empty())
    throw std::runtime_error(name("rgb.txt") +
                             ": none of the listed images is there; the first is " +
                             (folder / colors.front().file).string());
  const ImageSize first = read_image_size(images.front());
  const Camera camera = camera_from_intrinsics(lens, first.width_px, first.height_px);
  for (Frame& frame : capture.frames) frame.sensors.front().reported = camera;
  capture.rig.push_back({.camera = camera});
  read_frame_colors(capture, images);
  const std::optional<double> said =
      depth_unit_m ? depth_unit_m : unit_in_comments(depth_text, name("depth.txt"));
  read_depth(folder, name("depth.txt"), depth_of, said.value_or(kDepthUnit_m), capture);
  if (said)
    check_median_depth(capture, 0, name("depth.txt"));
  else
    check_default_unit(capture, name("depth.txt"));
  return capture;
}

}  // namespace cousin
