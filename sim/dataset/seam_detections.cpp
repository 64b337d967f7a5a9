// boxes.json, COCO results: a list of
//   {"image_id": 1,000,000 scene + frame, "sensor": 0, "id": 0, "category_id": 1, "score": 1.0,
//    "instance_id": -1, "bbox": [x, y, width, height], "segmentation": ...}
// "sensor" (of the rig), "id" (the place in the list), "score" (1), "instance_id" (-1, not known)
// and "segmentation" may be absent. The segmentation is polygons or run lengths, as in masks.json;
// we write run lengths. COCO counts pixels from the image's corner.
// keypoints.json, COCO results: the same keys, and "keypoints" [x, y, v, ...] in place of "bbox",
// which may stand beside them. COCO's x and y are of pixels, whose centres are integers; v is 0
// missing (x = y = 0), 1 hidden, 2 seen. "cousin": {"sigma_px": [number or null, ...]}, one a
// point, may be absent.
// "area", "iscrowd" (0 alone), "num_keypoints", "visible_fraction", "instance_name", "attributes"
// and "ignore" are passed over: they say nothing of where a thing is. Any other key is an error.

#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/dataset/coco_entries.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/mask_codes.h"
#include "sim/dataset/seam_json.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxDetections = 10'000'000;
constexpr std::size_t kMaxPointsOfOne = 10'000;

/// The keys that both seams have.
Json entry_of(const Detection& detection, int scene_index) {
  return {{"image_id", image_id_of(scene_index, detection.frame)},
          {"sensor", detection.sensor},
          {"id", detection.id},
          {"category_id", detection.category},
          {"score", detection.score},
          {"instance_id", detection.instance}};
}

/// The scene and the ids of earlier entries.
struct Before {
  std::int64_t scene = -1;
  std::set<int> ids;
};

/// @param place  in the list
void read_entry(const JsonNode& node, std::size_t place, const DetectionImages& images,
                Before& before, Detection& detection) {
  detection.frame = image_of(node["image_id"], images.scene, before.scene).frame;
  if (node.has("sensor")) detection.sensor = static_cast<int>(node["sensor"].integer(0, 999));
  detection.id = static_cast<int>(place);
  if (node.has("id")) detection.id = static_cast<int>(node["id"].integer(0, 2'000'000'000));
  if (!before.ids.insert(detection.id).second) node.fail("has an id that occurs twice");
  detection.category = static_cast<int>(node["category_id"].integer(0, 1'000'000));
  if (node.has("score")) detection.score = node["score"].number(0, 1);
  if (node.has("instance_id"))
    detection.instance = static_cast<int>(node["instance_id"].integer(-1, 1'000'000'000));
  if (node.has("iscrowd") && node["iscrowd"].integer(0, 1) != 0)
    node["iscrowd"].fail("marks a crowd; a detection is of one object");
  if (images.size_px.empty() || images.size_px.contains({detection.frame, detection.sensor}))
    return;
  node["image_id"].fail("is of frame " + std::to_string(detection.frame) + ", sensor " +
                        std::to_string(detection.sensor) +
                        ", of which the capture has no colour image");
}

Eigen::Vector2i size_of(const DetectionImages& images, const Detection& detection) {
  const auto known = images.size_px.find({detection.frame, detection.sensor});
  return known == images.size_px.end() ? Eigen::Vector2i(0, 0) : known->second;
}

void read_segmentation(const JsonNode& node, const DetectionImages& images, DetectedBox& box) {
  const JsonNode segmentation = node["segmentation"];
  box.image_px = size_of(images, box);
  const bool is_runs = segmentation.is_object();
  if (!is_runs && segmentation.size(kMaxOutlinePoints) == 0) return;
  PlacedMask placed = is_runs ? mask_of_runs(segmentation, box.image_px)
                              : mask_of_polygons(segmentation, box.image_px);
  if (placed.mask.empty()) return;
  if (box.image_px.x() == 0) {  // polygons of an image that nobody knows end with it
    box.image_px = {placed.x + placed.mask.width(), placed.y + placed.mask.height()};
  }
  box.mask_at_px = {placed.x, placed.y};
  box.mask = std::move(placed.mask);
}

Json segmentation_of(const DetectedBox& box) {
  return {{"size", {box.image_px.y(), box.image_px.x()}},
          {"counts", coco_run_lengths(box.mask, box.mask_at_px.x(), box.mask_at_px.y(),
                                      box.image_px.x(), box.image_px.y())}};
}

constexpr double kHalf = 0.5;  ///< from the image's corner to the first pixel's centre

void read_box(const JsonNode& node, DetectedBox& box) {
  const Eigen::Vector4d bbox = node.vector<4>();
  if (bbox.cwiseAbs().maxCoeff() > kMaxCocoPixel) node.fail("is outside [-1e6, 1e6]");
  if (bbox[2] < 0 || bbox[3] < 0) node.fail("has a negative width or height");
  box.low_px = bbox.head<2>().array() - kHalf;
  box.high_px = box.low_px + bbox.tail<2>();
}

DetectedKeypoint read_point(const JsonNode& node, double x, double y, double v) {
  DetectedKeypoint point;
  if (v != 0 && v != 1 && v != 2) node.fail("has a visibility that is not 0, 1 or 2");
  point.status = static_cast<KeypointStatus>(static_cast<int>(v));
  if (point.status == KeypointStatus::missing) return point;
  if (std::max(std::abs(x), std::abs(y)) > kMaxCocoPixel) node.fail("is outside [-1e6, 1e6]");
  point.pixel_px = {x, y};
  return point;
}

void read_points(const JsonNode& node, KeypointDetection& detection) {
  const JsonNode keypoints = node["keypoints"];
  const std::vector<double> values = keypoints.numbers(0, 3 * kMaxPointsOfOne);
  if (values.size() % 3 != 0) keypoints.fail("is not x, y, v for each point");
  for (std::size_t i = 0; i < values.size(); i += 3)
    detection.points.push_back(read_point(keypoints, values[i], values[i + 1], values[i + 2]));
  if (!node.has("cousin")) return;
  node["cousin"].expect_keys({"sigma_px"});
  const JsonNode sigmas = node["cousin"]["sigma_px"];
  if (sigmas.size(kMaxPointsOfOne) != detection.points.size())
    sigmas.fail("does not have one entry for each point");
  for (std::size_t i = 0; i < detection.points.size(); ++i) {
    detection.points[i].sigma_px = sigmas[i].number_or_nan();
    if (detection.points[i].sigma_px < 0) sigmas[i].fail("is negative");
  }
}

/// The list, which a file of annotations is not.
std::vector<JsonNode> entries_of(const JsonNode& root, const char* what) {
  if (root.is_object() && root.has("annotations"))
    root.fail(std::string("is a file of COCO annotations; ") + what +
              " are COCO results, the list \"annotations\" alone");
  return root.elements(kMaxDetections);
}

}  // namespace

std::string boxes_to_json(const Boxes& boxes, int scene_index) {
  Json root = Json::array();
  for (const DetectedBox& box : boxes) {
    Json entry = entry_of(box, scene_index);
    const Eigen::Vector2d size_px = box.high_px - box.low_px;
    entry["bbox"] = {box.low_px.x() + kHalf, box.low_px.y() + kHalf, size_px.x(), size_px.y()};
    if (!box.mask.empty()) entry["segmentation"] = segmentation_of(box);
    root.push_back(std::move(entry));
  }
  return to_text(root);
}

Boxes boxes_from_json(std::string_view text, const std::string& name,
                      const DetectionImages& images) {
  const JsonDocument document(text, name);
  Boxes boxes;
  Before before;
  std::uint64_t pixels = 0;
  for (const JsonNode& node : entries_of(document.root(), "boxes")) {
    node.expect_keys(
        {"image_id", "category_id", "bbox"},
        {"sensor", "id", "score", "instance_id", "segmentation", "area", "iscrowd", "num_keypoints",
         "visible_fraction", "instance_name", "attributes", "ignore"});
    DetectedBox& box = boxes.emplace_back();
    read_entry(node, boxes.size() - 1, images, before, box);
    read_box(node["bbox"], box);
    if (node.has("segmentation")) read_segmentation(node, images, box);
    pixels += box.mask.size();
    check_memory(name, pixels + boxes.size() * sizeof(DetectedBox), "the boxes and their masks");
  }
  return boxes;
}

std::string keypoints_to_json(const Keypoints& keypoints, int scene_index) {
  Json root = Json::array();
  for (const KeypointDetection& detection : keypoints) {
    Json entry = entry_of(detection, scene_index);
    Json points = Json::array(), sigmas = Json::array();
    bool has_sigma = false;
    for (const DetectedKeypoint& point : detection.points) {
      const bool is_there = point.status != KeypointStatus::missing;
      points.push_back(is_there ? point.pixel_px.x() : 0.0);
      points.push_back(is_there ? point.pixel_px.y() : 0.0);
      points.push_back(static_cast<int>(point.status));
      sigmas.push_back(nan_to_null(point.sigma_px));
      has_sigma = has_sigma || !std::isnan(point.sigma_px);
    }
    entry["keypoints"] = points;
    if (has_sigma) entry["cousin"]["sigma_px"] = sigmas;
    root.push_back(std::move(entry));
  }
  return to_text(root);
}

Keypoints keypoints_from_json(std::string_view text, const std::string& name,
                              const DetectionImages& images) {
  const JsonDocument document(text, name);
  Keypoints keypoints;
  Before before;
  std::uint64_t points = 0;
  for (const JsonNode& node : entries_of(document.root(), "keypoints")) {
    node.expect_keys(
        {"image_id", "category_id", "keypoints"},
        {"sensor", "id", "score", "instance_id", "bbox", "segmentation", "area", "iscrowd",
         "num_keypoints", "visible_fraction", "instance_name", "attributes", "ignore", "cousin"});
    KeypointDetection& detection = keypoints.emplace_back();
    read_entry(node, keypoints.size() - 1, images, before, detection);
    read_points(node, detection);
    points += detection.points.size();
    check_memory(name, points * sizeof(DetectedKeypoint), "the keypoints");
  }
  return keypoints;
}

}  // namespace cousin
