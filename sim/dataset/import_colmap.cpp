#include <algorithm>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/colmap_model.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kLimitBytes = std::size_t{1} << 31;

ColmapModel read_model(const fs::path& folder) {
  for (const char* below : {"", "sparse/0", "sparse", "sparse_txt"}) {
    const fs::path dir = *below == '\0' ? folder : folder / below;
    const auto files = [&](const char* ending) {
      const auto text = [&](const char* name) {
        const fs::path relative = fs::path(below) / (std::string(name) + ending);
        return read_file(resolve_inside(folder, relative), kLimitBytes);
      };
      return ColmapFiles{.cameras = text("cameras"), .images = text("images"), .points = {}};
    };
    if (fs::exists(dir / "cameras.bin")) return colmap_from_binary(files(".bin"), dir.string());
    if (fs::exists(dir / "cameras.txt")) return colmap_from_text(files(".txt"), dir.string());
  }
  throw std::runtime_error(folder.string() +
                           ": no cameras.bin or cameras.txt there, in sparse/0, sparse or "
                           "sparse_txt");
}

}  // namespace

Capture import_colmap(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": not a folder");
  const ColmapModel model = read_model(folder);
  const fs::path root = fs::is_directory(folder / "images") ? folder / "images" : folder;
  std::vector<const ColmapImage*> listed;
  for (const auto& [id, image] : model.images) listed.push_back(&image);
  std::sort(listed.begin(), listed.end(),
            [](const ColmapImage* a, const ColmapImage* b) { return a->name < b->name; });
  Capture capture;
  std::vector<fs::path> images;
  for (std::size_t i = 0; i < listed.size(); ++i) {
    const fs::path image = resolve_inside(root, listed[i]->name);
    if (!fs::exists(image)) {
      capture.warnings.push_back(folder.string() + ": image " + listed[i]->name +
                                 " is skipped: it is absent");
      continue;
    }
    Frame frame{.id = static_cast<int>(i),
                .time_s = static_cast<double>(i),
                .rig_from_world = listed[i]->camera_from_world};
    frame.sensors.push_back({.reported = model.cameras.at(listed[i]->camera)});
    capture.frames.push_back(std::move(frame));
    images.push_back(image);
  }
  if (capture.frames.empty())
    throw std::runtime_error(folder.string() + ": none of the listed images is there");
  capture.rig.push_back({.camera = capture.frames.front().sensors.front().reported});
  read_frame_colors(capture, images);
  return capture;
}

}  // namespace cousin
