#include "benchmarks/tools/calibrate/calibration_photos.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "calibration/boards/target_detection.h"
#include "scenes/boards/boards_scene.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/imaging/exif.h"
#include "sim/imaging/image_io.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPhotos = 5000;
constexpr const char* kForms =
    "give chessboard:COLUMNSxROWS:PITCH_M (inner corners), charuco:CxR:PITCH_M:SHARE:DICTIONARY"
    "[:current|legacy] (squares), aprilgrid:CxR:TAG_M:SPACE_SHARE (tags), "
    "circles:CxR:PITCH_M[:SHARE], "
    "acircles:CxR:PITCH_M[:SHARE], or a name of `cousin render boards --keys`";

[[noreturn]] void fail(const std::string& text, const std::string& what) {
  throw std::invalid_argument("board \"" + cut_utf8(text, 200) + "\": " + what + "; " + kForms);
}

std::vector<std::string> parts_of(const std::string& text, char at) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(at, from), text.size());
    parts.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

template <class T>
T number(const std::string& text, const std::string& word, const char* what) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size())
    fail(text, "\"" + word + "\" is no " + what);
  return value;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Numbers of names run as people count: frame2 before frame10.
bool counts_before(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      std::size_t p = i, q = j;
      while (p < a.size() && digit(a[p])) ++p;
      while (q < b.size() && digit(b[q])) ++q;
      std::string x = a.substr(i, p - i), y = b.substr(j, q - j);
      x.erase(0, std::min(x.find_first_not_of('0'), x.size() - 1));
      y.erase(0, std::min(y.find_first_not_of('0'), y.size() - 1));
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
      i = p, j = q;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

std::vector<std::string> picture_names(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": not a folder");
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string extension = lower(entry.path().extension().string());
    if (extension != ".png" && extension != ".jpg" && extension != ".jpeg") continue;
    if (is_temporary_name(entry.path().filename().string())) continue;
    names.push_back(entry.path().filename().string());
    if (!is_utf8(names.back())) {
      throw std::runtime_error(folder.string() + ": the file name \"" +
                               readable_utf8(names.back()) + "\" is not UTF-8; rename it");
    }
    if (names.size() > kMostPhotos)
      throw std::runtime_error(folder.string() + ": more than 5000 images");
  }
  if (names.empty())
    throw std::runtime_error(folder.string() + ": no .png, .jpg or .jpeg in this folder");
  std::sort(names.begin(), names.end(), counts_before);
  return names;
}

std::string file_name(int frame) {
  char file[32];
  std::snprintf(file, sizeof file, "%06d.png", frame);
  return file;
}

std::string depth_folder(const SensorReport& sensor, std::size_t place) {
  return sensor.name == kDepthSensor || place == 0 ? "depth" : sensor.name + "_depth";
}

/// The sensor with images whose pixels a depth image has: itself, or the one that stands where it
/// does with its lens.
int sensor_of_depth(const std::vector<SensorReport>& rig, const SensorFrame& image,
                    std::size_t depth) {
  if (!image.color.empty() || !image.grey.empty()) return static_cast<int>(depth);
  for (std::size_t s = 0; s < rig.size(); ++s) {
    if (s != depth && rig[s].camera == rig[depth].camera &&
        to_matrix(rig[s].sensor_from_rig) == to_matrix(rig[depth].sensor_from_rig))
      return static_cast<int>(s);
  }
  return static_cast<int>(depth);
}

CalibrationTarget target_of_scene(const Capture& capture, const fs::path& scene,
                                  const std::string& board) {
  CalibrationTarget target;
  if (capture.board.find(' ') == std::string::npos) {
    if (board.empty())
      throw std::runtime_error((scene / "rig.json").string() + ": /board = \"" + capture.board +
                               "\" names no calibration target; give --board");
    target = target_from_option(board);
  } else {
    target = target_from_text(capture.board);
    if (!board.empty() && !(target_from_option(board) == target))
      throw std::runtime_error((scene / "rig.json").string() + ": /board = \"" + to_text(target) +
                               "\" is not the board of --board, \"" +
                               to_text(target_from_option(board)) + "\"");
  }
  return target;
}

/// @throws std::runtime_error if the scene's sensors are not those of the first
void check_sensors(const Capture& capture, const CalibrationPhotos& photos, const fs::path& scene,
                   const std::string& first_scene) {
  std::vector<std::string> cameras;
  for (const SensorReport& sensor : capture.rig) cameras.push_back(sensor.name);
  if (cameras != photos.cameras)
    throw std::runtime_error((scene / "rig.json").string() +
                             ": the sensors are not those of scene " + first_scene);
}

/// Photographs and depths of a scene, whose frames and seconds follow on those before it.
void add_scene_frames(const Capture& capture, const fs::path& scene, int first_frame,
                      double first_s, CalibrationPhotos& result) {
  for (const Frame& frame : capture.frames) {
    for (std::size_t s = 0; s < frame.sensors.size(); ++s) {
      const SensorFrame& image = frame.sensors[s];
      if (!image.depth.empty())
        result.depths.push_back({scene / depth_folder(capture.rig[s], s) / file_name(frame.id),
                                 sensor_of_depth(capture.rig, image, s), first_frame + frame.id,
                                 image.depth_unit_m});
      if (image.color.empty() && image.grey.empty()) continue;
      fs::path path = scene / capture.rig[s].name / file_name(frame.id);
      if (!fs::exists(path)) path.replace_extension(".jpg");  // of a real capture
      result.photos.push_back(
          {path,
           scene.filename().string() + "/" + capture.rig[s].name + "/" + path.filename().string(),
           static_cast<int>(s), first_frame + frame.id, image.color.empty(),
           image.time_s.value_or(frame.time_s) + first_s});
    }
  }
}

/// Sensors without images, such as depth, are no cameras.
void keep_cameras(const fs::path& dataset, CalibrationPhotos& result) {
  std::vector<int> number(result.cameras.size(), -1);
  std::vector<std::string> kept;
  std::vector<SensorReport> reported;
  for (std::size_t s = 0; s < result.cameras.size(); ++s) {
    const bool used =
        std::any_of(result.photos.begin(), result.photos.end(),
                    [&](const CalibrationPhoto& p) { return p.camera == static_cast<int>(s); });
    if (!used) continue;
    number[s] = static_cast<int>(kept.size());
    kept.push_back(result.cameras[s]);
    reported.push_back(result.reported[s]);
  }
  if (kept.empty()) throw std::runtime_error(dataset.string() + ": no colour or grey image");
  result.cameras = kept;
  result.reported = reported;
  for (CalibrationPhoto& p : result.photos) p.camera = number[static_cast<std::size_t>(p.camera)];
  for (CalibrationDepth& d : result.depths) d.camera = number[static_cast<std::size_t>(d.camera)];
  std::erase_if(result.depths, [](const CalibrationDepth& d) { return d.camera < 0; });
}

}  // namespace

CalibrationTarget target_from_option(const std::string& text) {
  const std::vector<std::string> names = board_names();
  if (std::find(names.begin(), names.end(), text) != names.end()) return board_preset(text);
  const std::vector<std::string> parts = parts_of(text, ':');
  static const std::map<std::string, TargetKind> kKinds = {
      {"chessboard", TargetKind::chessboard},
      {"charuco", TargetKind::charuco},
      {"aprilgrid", TargetKind::april_grid},
      {"april_grid", TargetKind::april_grid},
      {"circles", TargetKind::circles},
      {"acircles", TargetKind::asymmetric_circles},
      {"asymmetric_circles", TargetKind::asymmetric_circles}};
  const auto kind = kKinds.find(parts.front());
  if (kind == kKinds.end()) fail(text, "\"" + parts.front() + "\" is no kind of board");
  if (parts.size() < 3) fail(text, "its size or its pitch is missing");
  const std::vector<std::string> size = parts_of(parts[1], 'x');
  if (size.size() != 2) fail(text, "\"" + parts[1] + "\" is no size");
  CalibrationTarget target;
  target.kind = kind->second;
  target.columns = number<int>(text, size[0], "number");
  target.rows = number<int>(text, size[1], "number");
  target.pitch_m = number<double>(text, parts[2], "length");
  const bool has_corners = target.kind == TargetKind::chessboard;
  const bool has_markers = target.kind == TargetKind::charuco;
  if (has_corners) ++target.columns, ++target.rows;  // squares
  const std::size_t most = has_corners ? 3 : has_markers ? 6 : 4;
  if (parts.size() > most) fail(text, "has more than " + std::to_string(most) + " parts");
  if (has_markers && parts.size() < 5) fail(text, "its share or its dictionary is missing");
  if (target.kind == TargetKind::april_grid && parts.size() < 4)
    fail(text, "the space between tags is missing");
  target.mark_share = target.kind == TargetKind::circles              ? 0.25
                      : target.kind == TargetKind::asymmetric_circles ? 0.4
                                                                      : 0;
  if (parts.size() > 3) target.mark_share = number<double>(text, parts[3], "share");
  if (has_markers) target.dictionary = parts[4];
  try {
    if (parts.size() > 5) charuco_layout_from_string(parts[5]);
    validate(target);
  } catch (const std::invalid_argument& error) {
    fail(text, error.what());
  }
  return target;
}

std::optional<CharucoLayout> layout_from_option(const std::string& text) {
  const std::vector<std::string> parts = parts_of(text, ':');
  if (parts.front() != "charuco" || parts.size() < 6) return std::nullopt;
  return charuco_layout_from_string(parts[5]);
}

CharucoLayout layout_seen(const CalibrationPhotos& photos) {
  if (photos.layout) return *photos.layout;
  if (!has_two_layouts(photos.target)) return CharucoLayout::current;
  constexpr int kSure = 12;  // pairs of markers; in the wrong layout about half of them agree
  LayoutVotes sum;
  for (const CalibrationPhoto& photo : photos.photos) {
    const LayoutVotes votes = layout_votes(read_light(photo), photos.target);
    sum.current += votes.current;
    sum.legacy += votes.legacy;
    if (std::abs(sum.current - sum.legacy) >= kSure) break;
  }
  return sum.legacy > sum.current ? CharucoLayout::legacy : CharucoLayout::current;
}

CalibrationPhotos photos_of_folder(const fs::path& folder, const CalibrationTarget& target) {
  const std::vector<std::string> names = picture_names(folder);
  CalibrationPhotos result;
  result.target = target;
  const auto begins = [](const std::string& name, const char* word) {
    return lower(name).starts_with(word);
  };
  const bool stereo =
      std::all_of(names.begin(), names.end(),
                  [&](const std::string& n) { return begins(n, "left") || begins(n, "right"); }) &&
      std::any_of(names.begin(), names.end(),
                  [&](const std::string& n) { return begins(n, "left"); }) &&
      std::any_of(names.begin(), names.end(),
                  [&](const std::string& n) { return begins(n, "right"); });
  result.cameras =
      stereo ? std::vector<std::string>{"left", "right"} : std::vector<std::string>{"camera"};
  // Frames count over what follows the side's name.
  const auto rest_of = [&](const std::string& name) {
    const std::string stem = fs::path(name).stem().string();
    return !stereo ? name : stem.substr(begins(name, "left") ? 4 : 5);
  };
  std::vector<std::string> rests;
  for (const std::string& name : names) rests.push_back(rest_of(name));
  std::sort(rests.begin(), rests.end(), counts_before);
  rests.erase(std::unique(rests.begin(), rests.end()), rests.end());
  for (const std::string& name : names) {
    const auto at = std::find(rests.begin(), rests.end(), rest_of(name));
    result.photos.push_back({resolve_inside(folder, name), name,
                             stereo && begins(name, "right") ? 1 : 0,
                             static_cast<int>(at - rests.begin()), false});
  }
  std::stable_sort(result.photos.begin(), result.photos.end(),
                   [](const CalibrationPhoto& a, const CalibrationPhoto& b) {
                     return a.camera != b.camera ? a.camera < b.camera : a.frame < b.frame;
                   });
  for (CalibrationPhoto& photo : result.photos)
    photo.exif_orientation = read_exif(photo.file).orientation;
  return result;
}

CalibrationPhotos photos_of_dataset(const fs::path& dataset, const std::string& board) {
  CalibrationPhotos result;
  std::string first_scene;
  const std::vector<fs::path> scenes = scene_folders(dataset);
  if (scenes.empty())
    throw std::runtime_error(dataset.string() + ": no scene folder such as 000000 in this dataset");
  int first_frame = 0;
  double first_s = 0;  // scenes follow each other with a gap that no video has
  for (const fs::path& scene : scenes) {
    const Capture capture = read_capture(scene);
    const CalibrationTarget target = target_of_scene(capture, scene, board);
    if (first_scene.empty()) {
      result.target = target;
      first_scene = scene.filename().string();
      for (const SensorReport& sensor : capture.rig) result.cameras.push_back(sensor.name);
      result.reported = capture.rig;
    }
    if (!(target == result.target))
      throw std::runtime_error((scene / "rig.json").string() + ": /board = \"" + to_text(target) +
                               "\"; scene " + first_scene + " has \"" + to_text(result.target) +
                               "\"");
    check_sensors(capture, result, scene, first_scene);
    add_scene_frames(capture, scene, first_frame, first_s, result);
    for (const Frame& frame : capture.frames) first_frame = std::max(first_frame, frame.id + 1);
    double last_s = first_s;
    for (const CalibrationPhoto& p : result.photos) last_s = std::max(last_s, p.time_s);
    constexpr double kGap_s = 1000;
    first_s = last_s + kGap_s;
    if (result.photos.size() > kMostPhotos)
      throw std::runtime_error(dataset.string() + ": more than 5000 images");
  }
  keep_cameras(dataset, result);
  std::stable_sort(result.photos.begin(), result.photos.end(),
                   [](const CalibrationPhoto& a, const CalibrationPhoto& b) {
                     return a.camera != b.camera ? a.camera < b.camera : a.frame < b.frame;
                   });
  for (CalibrationPhoto& photo : result.photos) {
    if (photo.file.extension() == ".jpg")
      photo.exif_orientation = read_exif(photo.file).orientation;
  }
  return result;
}

Image<float> read_depth(const CalibrationDepth& depth) {
  const Image<std::uint16_t> codes = read_png16(depth.file);
  Image<float> depth_m(codes.width(), codes.height(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    if (codes.data()[i] > 0) depth_m.data()[i] = static_cast<float>(codes.data()[i] * depth.unit_m);
  }
  return depth_m;
}

Image<float> read_light(const CalibrationPhoto& photo) {
  return photo.is_linear_grey ? light_of(read_png8(photo.file)) : light_of(read_color(photo.file));
}

}  // namespace cousin
