#include "benchmarks/suites/splats/posed_set.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include "perception/ngp/ngp.h"
#include "perception/splats/splat_start.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/import.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kListLimit = std::size_t{1} << 20;  ///< bytes of split.txt

/// Whether split.txt calls a file "test", by its name.
std::map<std::string, bool> read_split(const fs::path& file) {
  std::istringstream lines(read_file(file, kListLimit));
  std::map<std::string, bool> split;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string name, kind, more;
    if (!(words >> name)) continue;
    const auto fail = [&](const std::string& what) {
      throw std::runtime_error(file.string() + ", line " + std::to_string(number) + ": " + what);
    };
    words >> kind;
    if (kind != "train" && kind != "test")
      fail("\"" + kind + "\" of \"" + name + "\" is neither train nor test");
    if (words >> more) fail("\"" + more + "\" after \"" + name + " " + kind + "\"");
    if (!split.emplace(name, kind == "test").second) fail("\"" + name + "\" occurs twice");
  }
  return split;
}

void require_both(const PosedSet& set, const fs::path& where) {
  if (!set.test.empty() && !set.train.empty()) return;
  throw std::runtime_error(where.string() + ": " + std::to_string(set.train.size()) +
                           " views to train on and " + std::to_string(set.test.size()) +
                           " to test; at least 1 of each");
}

}  // namespace

PosedSet read_split_set(const fs::path& folder) {
  PosedSet set;
  const std::map<std::string, bool> split = read_split(folder / "split.txt");
  const fs::path transforms = folder / "transforms.json";
  const NerfstudioFile list = read_nerfstudio(transforms);
  const Capture capture = import_nerfstudio(transforms);
  if (!capture.warnings.empty()) throw std::runtime_error(capture.warnings.front());
  std::map<std::string, int> views_of_name;
  for (const auto& frame : list.frames) ++views_of_name[fs::path(frame.image).filename().string()];
  for (const auto& [name, is_test] : split) {
    if (const int views = views_of_name[name]; views != 1)
      throw std::runtime_error((folder / "split.txt").string() + ": \"" + name +
                               "\" is the image of " + std::to_string(views) +
                               " views of transforms.json, not of one");
  }
  for (SplatView& view : splat_views(capture, reported_poses(capture))) {
    const std::string& image = list.frames.at(static_cast<std::size_t>(view.frame)).image;
    const std::string name = fs::path(image).filename().string();
    const auto own = split.find(name);
    if (own == split.end())
      throw std::runtime_error((folder / "split.txt").string() + ": there is no line for \"" +
                               name + "\"");
    (own->second ? set.test : set.train).push_back(std::move(view));
  }
  require_both(set, folder);
  set.start = splats_from_points(read_start_points(folder / "points.ply").points);
  return set;
}

PosedSet read_every_eighth(const fs::path& transforms_json, int largest_side_px, int points,
                           std::uint64_t seed) {
  PosedSet set;
  const Capture capture = import_nerfstudio(transforms_json);
  SplatViewsConfig config;
  config.largest_side_px = largest_side_px;
  std::vector<NgpView> cameras;
  std::size_t index = 0;
  for (SplatView& view : splat_views(capture, reported_poses(capture), {}, config)) {
    cameras.push_back({view.full.camera, view.camera_from_world, {}, {}});
    (index++ % 8 == 0 ? set.test : set.train).push_back(std::move(view));
  }
  require_both(set, transforms_json);
  const ngp::NgpVolume volume = ngp_volume({}, cameras);
  if (!(volume.side_m > 0))
    throw std::runtime_error(transforms_json.string() + ": the cameras look at no common point");
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(volume.side_m);
  set.start = splats_from_points(random_start_points(volume.centre_in_world_m - half,
                                                     volume.centre_in_world_m + half, points,
                                                     Rng(seed).fork("start")));
  return set;
}

PlacedSet place_photographs(const fs::path& folder, const std::string& intrinsics) {
  const Capture capture = import_folder(folder, intrinsics);
  SfmConfig config;
  config.pairs.choice = PairChoice::exhaustive;
  config.scale = SfmScale::none;
  const StageClock clock("sfm");
  const SfmEstimate estimate = estimate_poses_sfm(capture, config);
  PlacedSet placed{.status = estimate.status,
                   .reason = estimate.reason,
                   .photographs = static_cast<int>(capture.frames.size()),
                   .seconds = clock.finish()};
  if (!has_poses(estimate.status)) return placed;
  for (SplatView& view : splat_views(capture, estimate.poses))
    (placed.placed++ % 8 == 0 ? placed.set.test : placed.set.train).push_back(std::move(view));
  require_both(placed.set, folder);
  std::vector<StartPoint> points;
  for (const SfmPoint& point : estimate.points) points.push_back({point.in_world_m, point.color});
  placed.set.start = splats_from_points(points);
  return placed;
}

}  // namespace cousin
