#include "sim/dataset/rgbd_files.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/image_pairs.h"
#include "sim/dataset/picture_list.h"
#include "sim/dataset/time_stamps.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostRgbdFrames = 1'000'000;

const std::array<PairNames, 1>& rgbd_names() {
  static const std::array<PairNames, 1> kNames = {{{{"rgb", "color", "colour", "image", "images"},
                                                    {"depth"},
                                                    {"rgb", "color", "colour"},
                                                    {"depth"},
                                                    {".png", ".jpg", ".jpeg"},
                                                    {".png", ".npy", ".exr"}}}};
  return kNames;
}

struct TimedFile {
  double time_s = 0;
  std::string key;
};

/// The files in the order of their times; nothing unless every name is a time stamp.
std::optional<std::vector<TimedFile>> timed(const FilesByKey& files) {
  std::vector<TimedFile> result;
  for (const auto& [key, file] : files) {
    const std::optional<double> time_s = time_of_name(key);
    if (!time_s) return std::nullopt;
    result.push_back({*time_s, key});
  }
  std::sort(result.begin(), result.end(),
            [](const TimedFile& a, const TimedFile& b) { return a.time_s < b.time_s; });
  return result;
}

/// The depth that belongs to each colour image, by key; "" where there is none.
std::vector<std::string> partners(const fs::path& folder, const PictureHalves& halves) {
  std::vector<std::string> result;
  bool has_any = false;
  for (const auto& [key, file] : halves.first) {
    const bool is_there = halves.second.contains(key);
    result.push_back(is_there ? key : "");
    has_any = has_any || is_there;
  }
  if (has_any) return result;
  const auto colors = timed(halves.first), depths = timed(halves.second);
  if (!colors || !depths)
    throw std::runtime_error(folder.string() + ": no two pictures of " + halves.first_name +
                             " and " + halves.second_name + " have the same name, as " +
                             halves.first.begin()->second.filename().string() + " and " +
                             halves.second.begin()->second.filename().string() +
                             ", and not all names are time stamps");
  result.clear();
  for (const auto& [key, file] : halves.first) {
    const auto depth = nearest(*depths, *time_of_name(key), kMostApart_s);
    result.push_back(depth == depths->end() ? "" : depth->key);
  }
  return result;
}

/// Texts of poses by the keys of their pictures.
FilesByKey poses_in(const fs::path& folder) {
  FilesByKey poses;
  const auto add = [&](const fs::path& inside, const fs::path& relative, bool needs_word) {
    if (!fs::is_directory(inside / relative)) return;
    const fs::path there = relative.empty() ? inside : resolve_inside(inside, relative);
    for (const fs::path& file : list_pictures(there, {".txt"}).files) {
      const std::optional<std::string> bare = without_word(file.stem().string(), "pose");
      if (needs_word && !bare) continue;
      poses.emplace(bare && !bare->empty() ? *bare : file.stem().string(), file);
    }
  };
  for (const char* name : {"pose", "poses"}) add(folder, name, false);
  for (const char* name : {"", "rgb", "color", "colour"}) add(folder, name, true);
  return poses;
}

void add_frames(const PictureHalves& halves, const std::vector<std::string>& depth_keys,
                const FilesByKey& poses, RgbdFiles& result) {
  std::vector<std::string> keys;
  for (const auto& [key, file] : halves.first) keys.push_back(key);
  const std::vector<double> times_s = times_of_names(keys);
  FilesByKey without_color = halves.second;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    RgbdFile& frame = result.frames.emplace_back();
    frame.key = keys[i];
    frame.time_s = times_s[i];
    frame.color = halves.first.at(keys[i]);
    if (!depth_keys[i].empty() || halves.second.contains(keys[i])) {
      frame.depth = halves.second.at(depth_keys[i]);
      without_color.erase(depth_keys[i]);
    } else {
      result.warnings.push_back(frame.color.string() + " has no depth image");
    }
    if (const auto pose = poses.find(keys[i]); pose != poses.end()) frame.pose = pose->second;
    if (!poses.empty() && !frame.pose)
      result.warnings.push_back(frame.color.string() + " has no pose");
  }
  for (const auto& [key, file] : without_color)
    result.warnings.push_back(file.string() + " is skipped: it has no colour image");
}

}  // namespace

RgbdFiles find_rgbd_files(const fs::path& folder) {
  if (fs::is_directory(folder) && fs::exists(folder / "rgb.txt") &&
      fs::exists(folder / "depth.txt"))
    throw std::runtime_error(folder.string() +
                             ": rgb.txt and depth.txt are there: import it by --format tum");
  PictureHalves halves = find_halves(
      folder, rgbd_names(),
      "folder rgb/ (or color/, colour/, image/, images/) beside a folder depth/, nor pictures with "
      "such words in their names, as a_rgb.png and a_depth.png");
  if (halves.first.size() > kMostRgbdFrames)
    throw std::runtime_error(folder.string() + ": " + std::to_string(halves.first.size()) +
                             " colour images; the limit is 1000000");
  RgbdFiles result;
  result.depth_name = halves.second_name;
  result.warnings = std::move(halves.warnings);
  add_frames(halves, partners(folder, halves), poses_in(folder), result);
  return result;
}

}  // namespace cousin
