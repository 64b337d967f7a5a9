#include "sim/dataset/coco_entries.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace cousin {
namespace {

/// What a mask's codes hold; errors of theirs become the node's.
template <class Decode>
auto decoded(const JsonNode& node, const Decode& decode) {
  try {
    return decode();
  } catch (const std::invalid_argument& error) {
    node.fail(error.what());
  }
}

std::vector<Eigen::Vector2d> read_polygon(const JsonNode& node) {
  const std::vector<double> values = node.numbers(6, 2 * kMaxOutlinePoints);
  if (values.size() % 2 != 0) node.fail("does not have an even number of coordinates");
  std::vector<Eigen::Vector2d> polygon;
  for (std::size_t i = 0; i < values.size(); i += 2) {
    if (std::abs(values[i]) > kMaxCocoPixel) node[i].fail("is outside [-1e6, 1e6]");
    if (std::abs(values[i + 1]) > kMaxCocoPixel) node[i + 1].fail("is outside [-1e6, 1e6]");
    polygon.emplace_back(values[i], values[i + 1]);
  }
  return polygon;
}

}  // namespace

CocoImage image_of(const JsonNode& image_id, int wanted, std::int64_t& first) {
  const std::int64_t image = image_id.integer(0, kFramesPerScene * kFramesPerScene - 1);
  const std::int64_t scene = image / kFramesPerScene;
  if (first >= 0 && scene != first) image_id.fail("is of another scene than the first entry");
  if (wanted >= 0 && scene != wanted) {
    image_id.fail("is of scene " + std::to_string(scene) + ", not of scene " +
                  std::to_string(wanted) + "; image_id is 1000000 scene + frame");
  }
  first = scene;
  return {static_cast<int>(scene), static_cast<int>(image % kFramesPerScene)};
}

std::int64_t image_id_of(int scene_index, int frame) {
  if (scene_index < 0 || scene_index >= kFramesPerScene) {
    throw std::invalid_argument("scene index " + std::to_string(scene_index) +
                                " is outside 0..999999");
  }
  return kFramesPerScene * scene_index + frame;
}

PlacedMask mask_of_runs(const JsonNode& node, Eigen::Vector2i& image_px) {
  node.expect_keys({"size", "counts"});
  const JsonNode size = node["size"], counts = node["counts"];
  if (size.size(2) != 2) size.fail("is not [height, width]");
  const Eigen::Vector2i own_px(static_cast<int>(size[1].integer(1, 65535)),
                               static_cast<int>(size[std::size_t{0}].integer(1, 65535)));
  if (image_px.x() > 0 && own_px != image_px) {
    size.fail("[" + std::to_string(own_px.y()) + ", " + std::to_string(own_px.x()) +
              "] is not the image's [height, width] = [" + std::to_string(image_px.y()) + ", " +
              std::to_string(image_px.x()) + "]");
  }
  image_px = own_px;
  std::vector<std::int64_t> runs;
  if (counts.is_array()) {
    for (const JsonNode& run : counts.elements(std::size_t{1} << 26))
      runs.push_back(run.integer(0, std::int64_t{65535} * 65535));
  } else {
    const std::string text = counts.text(std::size_t{1} << 28);
    runs = decoded(counts, [&] { return runs_of_coco(text); });
  }
  return decoded(counts, [&] { return mask_of_runs(runs, own_px.x(), own_px.y()); });
}

PlacedMask mask_of_polygons(const JsonNode& node, const Eigen::Vector2i& image_px) {
  std::vector<std::vector<Eigen::Vector2d>> polygons;
  Eigen::Vector2d high(1, 1);
  for (const JsonNode& part : node.elements(kMaxOutlinePoints)) {
    polygons.push_back(read_polygon(part));
    for (const Eigen::Vector2d& point : polygons.back()) high = high.cwiseMax(point);
  }
  const Eigen::Vector2i size =
      image_px.x() > 0 ? image_px
                       : Eigen::Vector2i(high.array().ceil().min(65535).matrix().cast<int>());
  return decoded(node, [&] { return mask_of_polygons(polygons, size.x(), size.y()); });
}

}  // namespace cousin
