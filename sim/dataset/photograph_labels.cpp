#include "sim/dataset/photograph_labels.h"

#include <set>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/seam_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLabelsFolder = "labels";
constexpr const char* kPicturesFile = "pictures.json";
constexpr std::size_t kMostPictures = 1'000'000;
constexpr std::size_t kMostCategories = 10'000;
constexpr std::size_t kMostPicturesBytes = std::size_t{1} << 30;

}  // namespace

std::string pictures_to_json(const PhotographLabels& labels) {
  Json list = Json::array();
  for (const LabelledPicture& picture : labels.pictures)
    list.push_back({{"frame", picture.frame}, {"file", picture.file}, {"id", picture.id}});
  Json root = Json::object();
  root["pictures"] = std::move(list);
  root["category_ids"] = labels.category_ids;
  return to_text(root);
}

PhotographLabels pictures_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"pictures"}, {"category_ids"});
  PhotographLabels labels;
  std::set<int> frames;
  for (const JsonNode& node : root["pictures"].elements(kMostPictures)) {
    node.expect_keys({"frame", "file", "id"});
    LabelledPicture& picture = labels.pictures.emplace_back();
    picture.frame = static_cast<int>(node["frame"].integer(0, 999'999));
    if (!frames.insert(picture.frame).second) node["frame"].fail("occurs twice");
    picture.file = node["file"].text(4096);
    picture.id = node["id"].text(256);
  }
  if (!root.has("category_ids")) return labels;
  for (const JsonNode& node : root["category_ids"].elements(kMostCategories))
    labels.category_ids.push_back(static_cast<int>(node.integer(0, 1'000'000)));
  return labels;
}

bool has_labels(const fs::path& scene_dir) {
  return fs::exists(scene_dir / kLabelsFolder / kPicturesFile);
}

void write_labels(const fs::path& scene_dir, const PhotographLabels& labels, int scene_index) {
  const fs::path dir = scene_dir / kLabelsFolder;
  fs::create_directories(dir);
  write_boxes(dir, labels.boxes, scene_index);
  write_file(dir / kPicturesFile, pictures_to_json(labels));
}

PhotographLabels read_labels(const fs::path& scene_dir, const DetectionImages& images) {
  const fs::path dir = scene_dir / kLabelsFolder, file = dir / kPicturesFile;
  PhotographLabels labels = pictures_from_json(read_file(file, kMostPicturesBytes), file.string());
  labels.boxes = read_boxes(dir, images);
  return labels;
}

}  // namespace cousin
