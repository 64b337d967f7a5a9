// masks.json, COCO results with one key more:
//   [{"image_id": 1,000,000 scene + frame, "category_id": 1, "score": 1.0, "instance_id": 0,
//     "segmentation": [[x0, y0, x1, y1, ...]],
//     "cousin": {"normal": [nx0, ny0, ...], "sigma_px": [...], "on_object": [true, ...],
//                "pixel_px": [x0, y0, ...]}}]
// The segmentation is [] (nothing), one closed polygon, several polygons, or run lengths
//     {"size": [height, width], "counts": "compressed text" or [runs of 0 and 1 in turn]}
// COCO counts pixels from the image's corner. One polygon is kept as it is. Several, and run
// lengths, are a mask of whole pixels, the polygons' as pycocotools fills them (all together, each
// by the even-odd rule): its outline runs through the middles of its pixels' edges with a sigma of
// 1 / sqrt(12) px, and where the image's border cuts it, it is not on the object.
// "cousin" comes beside one polygon alone. Each key of it may be absent: normals are then those of
// the polygon, sigma is 0.1 px, and all points are on the object. "pixel_px" (from pixel centres)
// is written only where the half pixel to COCO's origin would round a float.
// Keys of COCO that say nothing of an outline are on a list (check_entry_keys); iscrowd and
// "sensor" may be 0 alone. Any other key is an error.

#include <cmath>
#include <stdexcept>

#include "sim/dataset/coco_entries.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/mask_codes.h"
#include "sim/dataset/seam_json.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxMasks = 10'000'000;
constexpr float kPixelSigma_px = 0.288675F;  ///< of a border that was rounded to whole pixels

Json floats(const std::vector<OutlinePoint>& outline, const Eigen::Vector2f OutlinePoint::*member,
            double add) {
  Json array = Json::array();
  for (const OutlinePoint& point : outline) {
    array.push_back(static_cast<double>((point.*member).x()) + add);
    array.push_back(static_cast<double>((point.*member).y()) + add);
  }
  return array;
}

bool survives_half_pixel(float value) {
  return static_cast<float>((static_cast<double>(value) + 0.5) - 0.5) == value;
}

/// Outward unit normals of a closed polygon: at each point, square to the chord between its
/// neighbours.
void set_polygon_normals(std::vector<OutlinePoint>& outline) {
  const std::size_t n = outline.size();
  double doubled_area = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d a = outline[i].pixel_px.cast<double>();
    const Eigen::Vector2d b = outline[(i + 1) % n].pixel_px.cast<double>();
    doubled_area += a.x() * b.y() - a.y() * b.x();
  }
  const float side = doubled_area >= 0 ? 1.0F : -1.0F;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2f chord = outline[(i + 1) % n].pixel_px - outline[(i + n - 1) % n].pixel_px;
    const float length = chord.norm();
    outline[i].normal = length > 0
                            ? Eigen::Vector2f(side * chord.y() / length, -side * chord.x() / length)
                            : Eigen::Vector2f(1, 0);
  }
}

/// Coordinates [x0, y0, ...], `shift` added, into `member`.
void read_vectors(const JsonNode& node, double shift, Eigen::Vector2f OutlinePoint::*member,
                  std::vector<OutlinePoint>& outline) {
  const std::vector<double> values = node.numbers(2 * outline.size(), 2 * outline.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::abs(values[i]) > kMaxCocoPixel) node[i].fail("is outside [-1e6, 1e6]");
    (outline[i / 2].*member)[static_cast<Eigen::Index>(i % 2)] =
        static_cast<float>(values[i] + shift);
  }
}

void read_outline_details(const JsonNode& node, std::vector<OutlinePoint>& outline) {
  node.expect_keys({}, {"normal", "sigma_px", "on_object", "pixel_px"});
  if (node.has("pixel_px")) read_vectors(node["pixel_px"], 0, &OutlinePoint::pixel_px, outline);
  if (node.has("normal")) {
    read_vectors(node["normal"], 0, &OutlinePoint::normal, outline);
    for (std::size_t i = 0; i < outline.size(); ++i) {
      if (!(std::abs(outline[i].normal.norm() - 1) < 1e-3F)) {
        node["normal"].fail("has no unit vector at point " + std::to_string(i));
      }
    }
  }
  if (node.has("sigma_px")) {
    const std::vector<double> sigmas = node["sigma_px"].numbers(outline.size(), outline.size());
    for (std::size_t i = 0; i < sigmas.size(); ++i) {
      if (sigmas[i] < 0 || sigmas[i] > kMaxCocoPixel)
        node["sigma_px"][i].fail("is outside [0, 1e6]");
      outline[i].sigma_px = static_cast<float>(sigmas[i]);
    }
  }
  if (node.has("on_object")) {
    const JsonNode flags = node["on_object"];
    if (flags.size(kMaxOutlinePoints) != outline.size())
      flags.fail("does not have one entry for each point");
    for (std::size_t i = 0; i < outline.size(); ++i) outline[i].on_object = flags[i].boolean();
  }
}

// ---- masks of whole pixels ----------------------------------------------------------------------

/// The middles of a ring's pixel edges, with the normals of its neighbourhood.
std::vector<OutlinePoint> points_of(const PixelRing& ring, const Eigen::Vector2i& image_px) {
  constexpr std::ptrdiff_t kReach = 3;  ///< edges to each side that a normal is of
  std::vector<OutlinePoint> points;
  std::vector<Eigen::Vector2f> normals;
  for (std::size_t i = 0; i < ring.line.size(); ++i) {
    const Eigen::Vector2i &a = ring.line[i], &b = ring.line[(i + 1) % ring.line.size()];
    const Eigen::Vector2i step = (b - a).cwiseSign();
    const bool at_border =
        step.x() == 0 ? a.x() == 0 || a.x() == image_px.x() : a.y() == 0 || a.y() == image_px.y();
    for (Eigen::Vector2i corner = a; corner != b; corner += step) {
      OutlinePoint point;
      point.pixel_px = corner.cast<float>() + 0.5F * step.cast<float>() -
                       Eigen::Vector2f(0.5F, 0.5F);  // COCO's origin is the image's corner
      point.sigma_px = kPixelSigma_px;
      point.on_object = !at_border;
      points.push_back(point);
      normals.emplace_back(static_cast<float>(step.y()), static_cast<float>(-step.x()));
    }
  }
  const auto count = static_cast<std::ptrdiff_t>(points.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    for (std::ptrdiff_t k = -kReach; k <= kReach; ++k)
      sum += normals[static_cast<std::size_t>(((i + k) % count + count) % count)];
    const auto place = static_cast<std::size_t>(i);
    points[place].normal = sum.norm() > 0.1F ? sum.normalized() : normals[place];
  }
  return points;
}

/// All rings as one closed line: from the first point to each further ring and back. Points that
/// are there for this alone are not on the object.
std::vector<OutlinePoint> outline_of(const PlacedMask& placed, const Eigen::Vector2i& image_px) {
  std::vector<OutlinePoint> outline;
  const auto add_joint = [&](OutlinePoint point) {
    point.on_object = false;
    outline.push_back(point);
  };
  for (const PixelRing& ring : rings_of(placed.mask, placed.x, placed.y, kMaxOutlinePoints)) {
    const std::vector<OutlinePoint> points = points_of(ring, image_px);
    const bool is_first = outline.empty();
    outline.insert(outline.end(), points.begin(), points.end());
    add_joint(points.front());
    if (!is_first) add_joint(outline.front());
  }
  return outline;
}

void read_one_polygon(const JsonNode& node, bool is_ours, std::vector<OutlinePoint>& outline) {
  const std::size_t coordinates = node.size(2 * kMaxOutlinePoints);
  if (coordinates % 2 != 0) node.fail("does not have an even number of coordinates");
  if (coordinates < 6 && !is_ours) node.fail("has fewer than 3 points");
  outline.resize(coordinates / 2);
  read_vectors(node, -0.5, &OutlinePoint::pixel_px, outline);
}

/// Fills the outline from any of COCO's codes.
void read_segmentation(const JsonNode& node, const Eigen::Vector2i& image_px, Silhouette& result) {
  const JsonNode segmentation = node["segmentation"];
  const bool is_ours = node.has("cousin");
  const bool is_runs = segmentation.is_object();
  const std::size_t polygons = is_runs ? 0 : segmentation.size(kMaxOutlinePoints);
  if (is_ours && (is_runs || polygons > 1))
    node["cousin"].fail("comes beside a segmentation that is not one polygon");
  if (polygons == 1) {
    read_one_polygon(segmentation[std::size_t{0}], is_ours, result.outline);
    if (is_ours) read_outline_details(node["cousin"], result.outline);
    if (!is_ours || !node["cousin"].has("normal")) set_polygon_normals(result.outline);
    return;
  }
  if (is_ours) read_outline_details(node["cousin"], result.outline);
  Eigen::Vector2i size = image_px;
  const PlacedMask mask =
      is_runs ? mask_of_runs(segmentation, size) : mask_of_polygons(segmentation, image_px);
  if (mask.mask.empty()) return;
  // The mask, its edges twice, and the part of each pixel.
  constexpr std::uint64_t kPixelBytes = 3 + sizeof(int);
  check_memory(node.file(), kPixelBytes * mask.mask.size(), "the outline of a mask");
  try {
    result.outline = outline_of(mask, size);
  } catch (const std::invalid_argument& error) {
    segmentation.fail(error.what());
  }
  if (result.outline.size() > kMaxOutlinePoints) {
    segmentation.fail("has an outline of " + std::to_string(result.outline.size()) +
                      " points; the limit is " + std::to_string(kMaxOutlinePoints));
  }
}

// ---- entries ------------------------------------------------------------------------------------

void check_entry_keys(const JsonNode& node) {
  node.expect_keys(
      {"image_id", "instance_id", "segmentation"},
      {"cousin", "iscrowd", "sensor", "category_id", "score", "id", "bbox", "area", "keypoints",
       "num_keypoints", "visible_fraction", "instance_name", "attributes", "ignore"});
  if (node.has("iscrowd") && node["iscrowd"].integer(0, 1) != 0)
    node["iscrowd"].fail("marks a crowd; an outline is of one object");
  if (node.has("sensor")) node["sensor"].integer(0, 0);
}

Silhouette read_silhouette(const JsonNode& node, const MaskImages& images, std::int64_t& scene) {
  check_entry_keys(node);
  Silhouette silhouette;
  const CocoImage image = image_of(node["image_id"], images.scene, scene);
  silhouette.frame = image.frame;
  silhouette.instance = static_cast<int>(node["instance_id"].integer(0, 1'000'000'000));
  Eigen::Vector2i image_px(0, 0);
  if (!images.size_px.empty()) {
    const auto known = images.size_px.find(silhouette.frame);
    if (known == images.size_px.end())
      node["image_id"].fail("is of frame " + std::to_string(silhouette.frame) +
                            ", which the capture does not have");
    image_px = known->second;
  }
  read_segmentation(node, image_px, silhouette);
  return silhouette;
}

}  // namespace

std::string silhouettes_to_json(const Silhouettes& silhouettes, int scene_index) {
  if (scene_index < 0 || scene_index >= kFramesPerScene) {
    throw std::invalid_argument("scene index " + std::to_string(scene_index) +
                                " is outside 0..999999");
  }
  Json root = Json::array();
  for (const Silhouette& silhouette : silhouettes) {
    Json sigma = Json::array();
    Json on_object = Json::array();
    bool exact = true;
    for (const OutlinePoint& point : silhouette.outline) {
      sigma.push_back(static_cast<double>(point.sigma_px));
      on_object.push_back(point.on_object);
      exact = exact && survives_half_pixel(point.pixel_px.x()) &&
              survives_half_pixel(point.pixel_px.y());
    }
    Json details = {{"normal", floats(silhouette.outline, &OutlinePoint::normal, 0)},
                    {"sigma_px", sigma},
                    {"on_object", on_object}};
    if (!exact) details["pixel_px"] = floats(silhouette.outline, &OutlinePoint::pixel_px, 0);
    Json segmentation = Json::array();
    if (!silhouette.outline.empty())
      segmentation.push_back(floats(silhouette.outline, &OutlinePoint::pixel_px, 0.5));
    root.push_back({{"image_id", kFramesPerScene * scene_index + silhouette.frame},
                    {"category_id", 1},
                    {"score", 1.0},
                    {"instance_id", silhouette.instance},
                    {"segmentation", segmentation},
                    {"cousin", details}});
  }
  return to_text(root);
}

Silhouettes silhouettes_from_json(std::string_view text, const std::string& name,
                                  const MaskImages& images) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  if (root.is_object() && root.has("annotations")) {
    root.fail(
        "is a file of COCO annotations; masks are COCO results, the list \"annotations\" "
        "alone");
  }
  Silhouettes silhouettes;
  std::int64_t scene = -1;
  std::uint64_t points = 0;
  for (const JsonNode& node : root.elements(kMaxMasks)) {
    silhouettes.push_back(read_silhouette(node, images, scene));
    points += silhouettes.back().outline.size();
    check_memory(name, points * sizeof(OutlinePoint), "the outlines of the masks");
  }
  return silhouettes;
}

}  // namespace cousin
