// masks.json, COCO results with one key more:
//   [{"image_id": 1,000,000 scene + frame, "category_id": 1, "score": 1.0, "instance_id": 0,
//     "segmentation": [[x0, y0, x1, y1, ...]],
//     "cousin": {"normal": [nx0, ny0, ...], "sigma_px": [...], "on_object": [true, ...],
//                "pixel_px": [x0, y0, ...]}}]
// The segmentation is one closed polygon, or none; COCO counts pixels from the image's corner.
// Each key of "cousin" may be absent: normals are then those of the polygon, sigma is 0.1 px, and
// all points are on the object. "pixel_px" (from pixel centres) is written only where the half
// pixel to COCO's origin would round a float. id, bbox, area and iscrowd are accepted, not used.

#include <cmath>
#include <stdexcept>

#include "sim/dataset/json_interop.h"
#include "sim/dataset/seam_json.h"

namespace cousin {
namespace {

constexpr std::int64_t kFramesPerScene = 1'000'000;
constexpr std::size_t kMaxMasks = 10'000'000;
constexpr std::size_t kMaxPoints = 1'000'000;  ///< of one outline
constexpr double kMaxPixel = 1e6;

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
    if (std::abs(values[i]) > kMaxPixel) node[i].fail("is outside [-1e6, 1e6]");
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
      if (sigmas[i] < 0 || sigmas[i] > kMaxPixel) node["sigma_px"][i].fail("is outside [0, 1e6]");
      outline[i].sigma_px = static_cast<float>(sigmas[i]);
    }
  }
  if (node.has("on_object")) {
    const JsonNode flags = node["on_object"];
    if (flags.size(kMaxPoints) != outline.size())
      flags.fail("does not have one entry for each point");
    for (std::size_t i = 0; i < outline.size(); ++i) outline[i].on_object = flags[i].boolean();
  }
}

Silhouette read_silhouette(const JsonNode& node, std::int64_t& scene) {
  node.expect_keys({"image_id", "instance_id", "segmentation"},
                   {"category_id", "score", "cousin", "id", "bbox", "area", "iscrowd"});
  Silhouette silhouette;
  const std::int64_t image = node["image_id"].integer(0, kFramesPerScene * kFramesPerScene - 1);
  if (scene >= 0 && image / kFramesPerScene != scene)
    node["image_id"].fail("is of another scene than the first entry");
  scene = image / kFramesPerScene;
  silhouette.frame = static_cast<int>(image % kFramesPerScene);
  silhouette.instance = static_cast<int>(node["instance_id"].integer(0, 1'000'000'000));
  const JsonNode segmentation = node["segmentation"];
  if (segmentation.size(1) == 1) {
    const JsonNode polygon = segmentation[std::size_t{0}];
    const std::size_t coordinates = polygon.size(2 * kMaxPoints);
    if (coordinates % 2 != 0) polygon.fail("does not have an even number of coordinates");
    silhouette.outline.resize(coordinates / 2);
    read_vectors(polygon, -0.5, &OutlinePoint::pixel_px, silhouette.outline);
  }
  if (node.has("cousin")) read_outline_details(node["cousin"], silhouette.outline);
  if (!node.has("cousin") || !node["cousin"].has("normal")) set_polygon_normals(silhouette.outline);
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

Silhouettes silhouettes_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  Silhouettes silhouettes;
  std::int64_t scene = -1;
  for (const JsonNode& node : document.root().elements(kMaxMasks)) {
    silhouettes.push_back(read_silhouette(node, scene));
  }
  return silhouettes;
}

}  // namespace cousin
