#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/coco_entries.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/import_labels.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/labelled_frames.h"
#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostCocoBytes = std::size_t{1} << 30;
constexpr std::size_t kMostCocoEntries = 10'000'000;
constexpr std::int64_t kMostCocoId = 1'000'000'000'000;

/// The annotation file: the source, or the one .json of a folder.
fs::path annotations_in(const fs::path& source) {
  if (!fs::is_directory(source)) return source;
  std::vector<fs::path> files;
  for (const fs::path& folder : {source, source / "annotations"}) {
    if (!fs::is_directory(folder)) continue;
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == ".json") files.push_back(entry.path());
    }
  }
  if (files.size() == 1) return files.front();
  throw std::runtime_error(source.string() + ": " +
                           (files.empty() ? "no .json of annotations in this folder"
                                          : "several .json in this folder; give one of them"));
}

/// An image that COCO lists.
struct ListedImage {
  std::int64_t id = 0;
  fs::path file;
  std::int64_t width_px = 0, height_px = 0;  ///< 0: not said
};

fs::path folder_of(const fs::path& file) {
  return file.parent_path().empty() ? fs::path(".") : file.parent_path();
}

fs::path image_file(const fs::path& annotations, const JsonNode& name) {
  const fs::path folder = folder_of(annotations);
  const std::string listed = name.text(4096);
  for (const fs::path& below : {folder, folder / "images", folder / "../images"}) {
    if (!fs::is_directory(below)) continue;
    if (const auto found = find_listed_image(below, listed)) return *found;
  }
  name.fail("is in none of " + folder.string() + ", images/ there and images/ beside it");
}

std::vector<ListedImage> images_of(const fs::path& annotations, const JsonNode& root) {
  std::vector<ListedImage> images;
  std::set<std::int64_t> ids;
  for (const JsonNode& node : root["images"].elements(kMostCocoEntries)) {
    ListedImage& image = images.emplace_back();
    image.id = node["id"].integer(0, kMostCocoId);
    if (!ids.insert(image.id).second) node["id"].fail("occurs twice");
    image.file = image_file(annotations, node["file_name"]);
    if (node.has("width")) image.width_px = node["width"].integer(1, 1'000'000);
    if (node.has("height")) image.height_px = node["height"].integer(1, 1'000'000);
  }
  std::sort(images.begin(), images.end(), [](const ListedImage& a, const ListedImage& b) {
    return a.file.filename() < b.file.filename();
  });
  return images;
}

/// Place of each category's number, from 1, in the order of the numbers.
std::map<std::int64_t, int> categories_of(const JsonNode& root, const fs::path& source,
                                          LabelledPhotographs& all) {
  std::map<std::int64_t, std::string> by_id;
  std::set<std::string> known;
  for (const JsonNode& node : root["categories"].elements(10'000)) {
    const std::string name = node["name"].text(256);
    if (!known.insert(name).second) node["name"].fail("occurs twice");
    if (!by_id.emplace(node["id"].integer(0, 1'000'000), name).second)
      node["id"].fail("occurs twice");
  }
  if (by_id.empty()) root["categories"].fail("is empty: labels need categories");
  std::map<std::int64_t, int> place;
  std::vector<std::string> names;
  for (const auto& [id, name] : by_id) {
    names.push_back(name);
    place[id] = static_cast<int>(names.size());
    all.labels.category_ids.push_back(static_cast<int>(id));
  }
  set_categories(source, std::move(names), all);
  return place;
}

/// Labels are of pixels as stored: a file that says another size is of a picture that was turned or
/// scaled since.
void check_listed_size(const ListedImage& image, const Camera& camera) {
  if (image.width_px == 0 || image.height_px == 0 ||
      (image.width_px == camera.width_px && image.height_px == camera.height_px))
    return;
  throw std::runtime_error(image.file.string() + ": " + std::to_string(camera.width_px) + "x" +
                           std::to_string(camera.height_px) + " pixels; its labels are of " +
                           std::to_string(image.width_px) + "x" + std::to_string(image.height_px));
}

std::optional<PlacedMask> mask_of_label(const JsonNode& label, const Eigen::Vector2i& image_px) {
  if (!label.has("segmentation") || label["segmentation"].is_null()) return std::nullopt;
  const JsonNode segmentation = label["segmentation"];
  Eigen::Vector2i own = image_px;
  if (segmentation.is_object()) return mask_of_runs(segmentation, own);
  if (segmentation.size(kMaxOutlinePoints) == 0) return std::nullopt;
  return mask_of_polygons(segmentation, image_px);
}

bool is_crowd(const JsonNode& label) {
  if (!label.has("iscrowd") || label["iscrowd"].is_false()) return false;
  return !label["iscrowd"].is_number() || label["iscrowd"].integer(0, 1) == 1;
}

}  // namespace

LabelledPhotographs import_coco(const fs::path& source) {
  const fs::path annotations = annotations_in(source);
  const std::string text = read_file(annotations, kMostCocoBytes);
  const JsonDocument document(without_bom(text), annotations.string());
  const JsonNode root = document.root();
  const std::vector<ListedImage> images = images_of(annotations, root);
  std::vector<fs::path> files;
  for (const ListedImage& image : images) files.push_back(image.file);
  LabelledPhotographs all = photographs_of(annotations, folder_of(annotations), files);
  std::map<std::int64_t, int> frame_of;
  for (std::size_t i = 0; i < images.size(); ++i) {
    check_listed_size(images[i], all.capture.frames[i].sensors.front().reported);
    all.labels.pictures[i].id = std::to_string(images[i].id);
    frame_of[images[i].id] = static_cast<int>(i);
  }
  const std::map<std::int64_t, int> category_of = categories_of(root, annotations, all);
  LabelCounts counts;
  for (const JsonNode& node : root["annotations"].elements(kMostCocoEntries)) {
    if (is_crowd(node)) {
      ++counts.crowds;
      continue;
    }
    const auto frame = frame_of.find(node["image_id"].integer(0, kMostCocoId));
    if (frame == frame_of.end()) node["image_id"].fail("is no image's id");
    const auto category = category_of.find(node["category_id"].integer(0, kMostCocoId));
    if (category == category_of.end()) node["category_id"].fail("is no category's id");
    const Camera& camera =
        all.capture.frames[static_cast<std::size_t>(frame->second)].sensors.front().reported;
    const Eigen::Vector4d bbox = node["bbox"].vector<4>();
    if (bbox.cwiseAbs().maxCoeff() > kMaxCocoPixel) node["bbox"].fail("is outside [-1e6, 1e6]");
    if (bbox.tail<2>().minCoeff() < 0) node["bbox"].fail("has a negative width or height");
    add_label(annotations,
              {frame->second, category->second, bbox.head<2>(), bbox.tail<2>(),
               mask_of_label(node, {camera.width_px, camera.height_px})},
              all, counts);
  }
  warn_of_labels(annotations, counts, all);
  return all;
}

}  // namespace cousin
