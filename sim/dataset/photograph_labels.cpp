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
constexpr std::size_t kMostPicturesBytes = std::size_t{1} << 30;

}  // namespace

std::string pictures_to_json(const std::vector<LabelledPicture>& pictures) {
  Json list = Json::array();
  for (const LabelledPicture& picture : pictures)
    list.push_back({{"frame", picture.frame}, {"file", picture.file}, {"id", picture.id}});
  Json root = Json::object();
  root["pictures"] = std::move(list);
  return to_text(root);
}

std::vector<LabelledPicture> pictures_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"pictures"});
  std::vector<LabelledPicture> pictures;
  std::set<int> frames;
  for (const JsonNode& node : root["pictures"].elements(kMostPictures)) {
    node.expect_keys({"frame", "file", "id"});
    LabelledPicture& picture = pictures.emplace_back();
    picture.frame = static_cast<int>(node["frame"].integer(0, 999'999));
    if (!frames.insert(picture.frame).second) node["frame"].fail("occurs twice");
    picture.file = node["file"].text(1024);
    picture.id = node["id"].text(256);
  }
  return pictures;
}

bool has_labels(const fs::path& scene_dir) {
  return fs::exists(scene_dir / kLabelsFolder / kPicturesFile);
}

void write_labels(const fs::path& scene_dir, const PhotographLabels& labels, int scene_index) {
  const fs::path dir = scene_dir / kLabelsFolder;
  fs::create_directories(dir);
  write_boxes(dir, labels.boxes, scene_index);
  write_file(dir / kPicturesFile, pictures_to_json(labels.pictures));
}

PhotographLabels read_labels(const fs::path& scene_dir, const DetectionImages& images) {
  const fs::path dir = scene_dir / kLabelsFolder, file = dir / kPicturesFile;
  PhotographLabels labels;
  labels.pictures = pictures_from_json(read_file(file, kMostPicturesBytes), file.string());
  labels.boxes = read_boxes(dir, images);
  return labels;
}

}  // namespace cousin
