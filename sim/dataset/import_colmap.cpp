#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/colmap_model.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kColmapLimitBytes = std::size_t{1} << 31;

/// The model in `folder / below`, binary before text; nothing where there is none.
std::optional<ColmapModel> model_in(const fs::path& folder, const fs::path& below) {
  const fs::path dir = below.empty() ? folder : folder / below;
  const auto files = [&](const char* ending) {
    const auto text = [&](const char* name) {
      return read_file(resolve_inside(folder, below / (std::string(name) + ending)),
                       kColmapLimitBytes);
    };
    return ColmapFiles{.cameras = text("cameras"), .images = text("images"), .points = {}};
  };
  if (fs::exists(dir / "cameras.bin")) return colmap_from_binary(files(".bin"), dir.string());
  if (fs::exists(dir / "cameras.txt")) return colmap_from_text(files(".txt"), dir.string());
  return std::nullopt;
}

/// COLMAP writes what hangs together as sparse/0, sparse/1, ...; which is the largest varies.
std::map<int, ColmapModel> numbered_models(const fs::path& folder) {
  std::map<int, ColmapModel> models;
  if (!fs::is_directory(folder / "sparse")) return models;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(resolve_inside(folder, "sparse"))) {
    const std::string name = entry.path().filename().string();
    int number = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (error != std::errc{} || end != name.data() + name.size() || number < 0) continue;
    if (std::to_string(number) != name) continue;
    if (auto model = model_in(folder, fs::path("sparse") / name))
      models.emplace(number, std::move(*model));
  }
  return models;
}

ColmapModel read_model(const fs::path& folder, std::vector<std::string>& warnings) {
  if (auto model = model_in(folder, "")) return *model;
  std::map<int, ColmapModel> models = numbered_models(folder);
  const auto largest = std::max_element(
      models.begin(), models.end(),
      [](const auto& a, const auto& b) { return a.second.images.size() < b.second.images.size(); });
  if (largest != models.end()) {
    const auto size = [](const auto& model) {
      return std::to_string(model.second.images.size()) + " images";
    };
    std::string others;
    for (const auto& model : models) {
      if (model.first == largest->first) continue;
      others += (others.empty() ? "" : ", ") + std::string("sparse/") +
                std::to_string(model.first) + " with " + size(model);
    }
    if (!others.empty())
      warnings.push_back(folder.string() + ": the model sparse/" + std::to_string(largest->first) +
                         " with " + size(*largest) + " is taken; these are not: " + others);
    return largest->second;
  }
  for (const char* below : {"sparse", "sparse_txt"}) {
    if (auto model = model_in(folder, below)) return *model;
  }
  throw std::runtime_error(folder.string() +
                           ": no cameras.bin or cameras.txt there, in sparse/0, sparse or "
                           "sparse_txt");
}

}  // namespace

Capture import_colmap(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": not a folder");
  Capture capture;
  const ColmapModel model = read_model(folder, capture.warnings);
  const std::string below = fs::is_directory(folder / "images") ? "images/" : "";
  std::vector<const ColmapImage*> listed;
  for (const auto& [id, image] : model.images) listed.push_back(&image);
  std::sort(listed.begin(), listed.end(),
            [](const ColmapImage* a, const ColmapImage* b) { return a->name < b->name; });
  std::vector<fs::path> images;
  for (std::size_t i = 0; i < listed.size(); ++i) {
    if (fs::path(listed[i]->name).is_absolute()) resolve_inside(folder, listed[i]->name);
    const std::optional<fs::path> image = find_listed_image(folder, below + listed[i]->name);
    if (!image) {
      capture.warnings.push_back(folder.string() + ": image " + listed[i]->name +
                                 " is skipped: it is absent");
      continue;
    }
    Frame frame{.id = static_cast<int>(i),
                .time_s = static_cast<double>(i),
                .rig_from_world = listed[i]->camera_from_world};
    frame.sensors.push_back({.reported = model.cameras.at(listed[i]->camera)});
    capture.frames.push_back(std::move(frame));
    images.push_back(*image);
  }
  if (capture.frames.empty()) {
    throw std::runtime_error(
        folder.string() + ": none of the listed images is there" +
        (listed.empty() ? "" : "; the first is " + (folder / (below + listed[0]->name)).string()));
  }
  capture.rig.push_back({.camera = capture.frames.front().sensors.front().reported});
  read_frame_colors(capture, images);
  return capture;
}

}  // namespace cousin
