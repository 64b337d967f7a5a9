#include "benchmarks/app/perceive_places.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "benchmarks/loop/stage_files.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/links.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// Scenes of a dataset, or the folder itself if it is one scene.
std::vector<fs::path> scenes_of(const fs::path& dataset) {
  if (!fs::is_directory(dataset)) throw std::runtime_error(dataset.string() + ": no such folder");
  std::vector<fs::path> scenes = scene_folders(dataset);
  if (scenes.empty() && fs::exists(dataset / "rig.json")) scenes.push_back(dataset);
  if (scenes.empty()) {
    throw std::runtime_error(dataset.string() +
                             ": holds no scene (000000/rig.json); see `cousin import`");
  }
  return scenes;
}

/// An estimate in the dataset's own folder would be taken for part of it.
void refuse_dataset_as_out(const fs::path& dataset, const fs::path& out) {
  const fs::path inner = fs::weakly_canonical(out), outer = fs::weakly_canonical(dataset);
  const auto parted = std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end());
  if (parted.first != outer.end()) return;
  throw std::invalid_argument("--out " + out.string() + ": lies in the dataset " +
                              dataset.string() + "; name a folder beside it");
}

}  // namespace

PerceivePlaces perceive_places(const Options& options) {
  PerceivePlaces places;
  places.dataset = options.arguments.at(0);
  if (!places.dataset.has_filename()) places.dataset = places.dataset.parent_path();  // "data/"
  places.out =
      options.out.empty() ? fs::path(places.dataset.string() + "_estimate") : fs::path(options.out);
  refuse_dataset_as_out(places.dataset, places.out);
  places.scenes = scenes_of(places.dataset);
  refuse_links_out(places.dataset, "manifest.json");
  for (const fs::path& scene : places.scenes) {
    refuse_links_out(places.dataset, scene.lexically_relative(places.dataset), "truth");
    const fs::path estimate = places.out / scene_id(scene_index_of(scene));
    if (fs::weakly_canonical(estimate) == fs::weakly_canonical(scene))
      throw std::invalid_argument("--out " + places.out.string() + ": the estimate of " +
                                  scene.string() + " would lie in the scene itself");
  }
  return places;
}

OutputFolder estimate_folder(const PerceivePlaces& places, bool has_page) {
  FolderClaim claim{.verb = "perceive", .version = COUSIN_VERSION, .config = {}, .names = {}};
  if (has_page) claim.names = {"specimens.csv", "report.html"};
  for (const fs::path& scene : places.scenes) {
    for (std::string& name : estimate_names(scene_id(scene_index_of(scene))))
      claim.names.push_back(std::move(name));
    // A dataset's own files would be taken for those of an estimate.
    for (const char* name : {"rig.json", "scene_camera.json"})
      claim.names.push_back(scene_id(scene_index_of(scene)) + "/" + name);
  }
  return {places.out, std::move(claim)};
}

int scene_index_of(const fs::path& scene) {
  const std::string name = scene.filename().string();
  const bool is_scene_id =
      name.size() == 6 && name.find_first_not_of("0123456789") == std::string::npos;
  return is_scene_id ? std::stoi(name) : 0;
}

}  // namespace cousin
