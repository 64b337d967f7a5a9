#include "perception/sfm/colmap_files.h"

#include <algorithm>
#include <cstdio>

#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLimitBytes = std::size_t{1} << 31;

SfmModel read_model(const fs::path& folder, const std::vector<std::string>& names) {
  const auto bytes = [&](const char* name) { return read_file(folder / name, kLimitBytes); };
  const ColmapFiles files{.cameras = bytes("cameras.bin"),
                          .images = bytes("images.bin"),
                          .points = bytes("points3D.bin")};
  return sfm_model(colmap_tracks_from_binary(files, folder.string()), names, folder.string());
}

}  // namespace

std::string colmap_image_name(int index) {
  char text[24];
  std::snprintf(text, sizeof text, "%06d.png", index);
  return text;
}

std::string match_list(const std::vector<std::array<int, 2>>& pairs) {
  std::string text;
  for (const auto& [a, b] : pairs) text += colmap_image_name(a) + " " + colmap_image_name(b) + "\n";
  return text;
}

SfmModels read_models(const fs::path& sparse, int images) {
  std::vector<std::string> names;
  for (int i = 0; i < images; ++i) names.push_back(colmap_image_name(i));
  SfmModels found;
  constexpr int kMostModels = 1000;  // COLMAP stops at 50
  for (int i = 0; i < kMostModels; ++i) {
    const fs::path folder = sparse / std::to_string(i);
    if (!fs::exists(folder / "cameras.bin")) break;
    try {
      found.models.push_back(read_model(folder, names));
    } catch (const ColmapLensError& error) {
      const std::string why = error.what(), place = sparse.string() + "/";
      found.bent.push_back(why.starts_with(place) ? "model " + why.substr(place.size()) : why);
    }
  }
  std::stable_sort(found.models.begin(), found.models.end(),
                   [](const SfmModel& a, const SfmModel& b) {
                     if (a.images.size() != b.images.size())
                       return a.images.size() > b.images.size();
                     return a.points.size() > b.points.size();
                   });
  return found;
}

}  // namespace cousin
