#include "benchmarks/tools/measure/sample_source.h"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

#include "benchmarks/tools/import/video_frames.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/import.h"
#include "sim/dataset/manifest.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using Kind = SamplePlace::Kind;

constexpr std::array<std::string_view, 8> kVideoEndings = {".mp4",  ".mov", ".m4v", ".mkv",
                                                           ".webm", ".avi", ".mts", ".3gp"};

std::string ending_of(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

bool is_video(const fs::path& file) {
  return fs::is_regular_file(file) && std::find(kVideoEndings.begin(), kVideoEndings.end(),
                                                ending_of(file)) != kVideoEndings.end();
}

bool is_photograph(const fs::path& file) {
  const std::string ending = ending_of(file);
  return fs::is_regular_file(file) && (ending == ".png" || ending == ".jpg" || ending == ".jpeg");
}

/// What lies in a folder but hidden files, by name.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.path().filename().string().starts_with('.')) entries.push_back(entry.path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

bool is_scene(const fs::path& folder) { return fs::is_regular_file(folder / "rig.json"); }

bool holds_photographs(const fs::path& folder) {
  const std::vector<fs::path> entries = entries_of(folder);
  return std::any_of(entries.begin(), entries.end(), is_photograph);
}

/// The captures in one folder; those of folders within only at the first level.
void add_folder(const fs::path& folder, const std::string& name, const std::string& source,
                bool is_source, std::vector<SamplePlace>& places) {
  if (is_scene(folder)) {
    places.push_back({name, source, folder, Kind::scene});
    return;
  }
  if (holds_photographs(folder)) {
    places.push_back({name, source, folder, Kind::photographs});
    return;
  }
  if (!is_source) return;
  const std::vector<fs::path> entries = entries_of(folder);
  const auto scenes = std::count_if(entries.begin(), entries.end(), [](const fs::path& e) {
    return fs::is_directory(e) && is_scene(e);
  });
  for (const fs::path& entry : entries) {
    const std::string within = name + "/" + entry.filename().string();
    if (is_video(entry)) {
      places.push_back({name + "/" + entry.stem().string(), source, entry, Kind::video});
    } else if (fs::is_directory(entry)) {
      add_folder(entry, is_scene(entry) && scenes == 1 ? name : within, source, false, places);
    }
  }
}

}  // namespace

std::vector<SamplePlace> sample_places(const std::vector<std::string>& sources) {
  std::vector<SamplePlace> places;
  for (const std::string& source : sources) {
    const fs::path path = source;
    const std::size_t before = places.size();
    if (fs::is_directory(path)) {
      const std::string name = path.filename().string();
      add_folder(path, name, name, true, places);
    } else if (fs::is_regular_file(path)) {
      const std::string name = path.stem().string();
      places.push_back({name, name, path, Kind::video});
    } else {
      throw std::runtime_error(source + ": no such file or folder");
    }
    if (places.size() == before)
      throw std::runtime_error(source +
                               ": holds no photographs (.png, .jpg, .jpeg), no video and no "
                               "dataset, nor does a folder in it");
  }
  std::map<std::string, fs::path> seen;
  for (const SamplePlace& place : places) {
    if (!is_utf8(place.name))
      throw std::runtime_error("sample \"" + readable_utf8(place.name) +
                               "\": its name is not UTF-8");
    const auto [other, is_new] = seen.emplace(place.name, place.path);
    if (!is_new)
      throw std::runtime_error(place.path.string() + " and " + other->second.string() +
                               " would both be sample \"" + place.name + "\"; rename one");
  }
  return places;
}

namespace {

/// What most phones' main cameras and zooms in the middle have.
AssumedLens usual_lens(const Capture& photographs) {
  const Image<Rgb8>& first = photographs.frames.at(0).sensors.at(0).color;
  const double focal_px = 0.85 * std::max(first.width(), first.height());
  return {camera_of_focal(focal_px, first.width(), first.height()), 0.25 * focal_px,
          "an assumption, 0.85 of the larger side; the board tells a better one"};
}

Capture read_photographs(const fs::path& folder, const SampleReading& reading) {
  Capture capture = import_folder(folder, reading.intrinsics, usual_lens);
  if (!reading.intrinsics.empty()) return capture;
  // A lens with coefficients, which the board then tells too.
  for (Frame& frame : capture.frames) {
    for (SensorFrame& sensor : frame.sensors) sensor.reported.model = LensModel::opencv5;
  }
  for (SensorReport& sensor : capture.rig) sensor.camera.model = LensModel::opencv5;
  return capture;
}

}  // namespace

Capture read_sample(const SamplePlace& place, const SampleReading& reading) {
  if (place.kind == Kind::scene) return read_capture(place.path);
  if (place.kind == Kind::photographs) return read_photographs(place.path, reading);
  const ScratchFolder scratch("cousin_video");
  const fs::path pictures = scratch.path() / "pictures";
  const std::vector<double> times_s =
      extract_sharp_frames(place.path, reading.frames > 0 ? reading.frames : 60, pictures);
  Capture capture = read_photographs(pictures, reading);
  for (std::size_t i = 0; i < capture.frames.size(); ++i) capture.frames[i].time_s = times_s.at(i);
  // The user knows the video, not the folder of its frames.
  for (std::string& warning : capture.warnings) {
    if (const std::size_t at = warning.find(pictures.string()); at != std::string::npos)
      warning.replace(at, pictures.string().size(), place.path.string());
  }
  return capture;
}

}  // namespace cousin
