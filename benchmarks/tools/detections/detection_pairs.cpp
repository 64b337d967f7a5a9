#include "benchmarks/tools/detections/detection_pairs.h"

#include <algorithm>
#include <stdexcept>

#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

std::int64_t pixels_of(const PlacedMask& mask) {
  return std::count_if(mask.mask.data(), mask.mask.data() + mask.mask.size(),
                       [](std::uint8_t v) { return v != 0; });
}

/// Pixels that two masks share over those of either, whose own pixels are counted already.
double mask_overlap(const PlacedMask& a, std::int64_t pixels_a, const PlacedMask& b,
                    std::int64_t pixels_b) {
  std::int64_t shared = 0;
  const int left = std::max(a.x, b.x), top = std::max(a.y, b.y);
  const int right = std::min(a.x + a.mask.width(), b.x + b.mask.width());
  const int bottom = std::min(a.y + a.mask.height(), b.y + b.mask.height());
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x)
      shared += a.mask(x - a.x, y - a.y) != 0 && b.mask(x - b.x, y - b.y) != 0;
  }
  const std::int64_t either = pixels_a + pixels_b - shared;
  return either > 0 ? static_cast<double>(shared) / static_cast<double>(either) : 0;
}

/// Place of a name in the list, which grows by names that it has not.
int place_of(const std::string& name, std::vector<std::string>& classes) {
  const auto found = std::find(classes.begin(), classes.end(), name);
  if (found != classes.end()) return static_cast<int>(found - classes.begin());
  classes.push_back(name);
  return static_cast<int>(classes.size()) - 1;
}

std::string list_of(const std::vector<std::string>& names, int first) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i > 0 ? ", " : "") + std::to_string(static_cast<int>(i) + first) + " " + names[i];
  return text;
}

/// Place of a class of the file. A class that `classes` names and the dataset has not is kept as
/// one of its own: it is found nowhere.
int class_of(int category, const DetectionScoreConfig& config, std::size_t known,
             std::vector<std::string>& classes) {
  if (const auto named = config.classes.find(category); named != config.classes.end())
    return place_of(named->second, classes);
  const int first = config.is_from_zero ? 0 : 1;
  if (!config.classes.empty() || category < first || category >= first + static_cast<int>(known)) {
    classes.resize(known);
    throw std::invalid_argument(
        "class " + std::to_string(category) + " of the detections is none of the dataset's (" +
        list_of(classes, first) + "); name the file's classes with --class-map, such as 0=" +
        (classes.empty() ? "fruit" : classes.front()));
  }
  return category - first;
}

/// What the overlaps of all detections with all objects of their pictures take.
void check_overlap_memory(const TruePictures& truth, const FoundFile& found) {
  const std::uint64_t kinds = found.has_masks ? 2 : 1;
  std::uint64_t bytes = 0;
  for (const auto& [picture, objects] : found.of_picture) {
    // Again for the matching of one class, and of all.
    const std::uint64_t overlaps =
        bytes_times(objects.size(), truth.pictures[picture].objects.size());
    bytes = bytes_plus(bytes, bytes_times(overlaps, (kinds + 1) * sizeof(double)));
  }
  check_memory("detections", bytes, "their overlaps with the objects of their pictures");
}

}  // namespace

std::vector<PicturePair> pairs_of(const TruePictures& truth, const FoundFile& found,
                                  const DetectionScoreConfig& config,
                                  std::vector<std::string>& classes) {
  check_overlap_memory(truth, found);
  const std::size_t known = classes.size();
  std::vector<PicturePair> pairs;
  for (std::size_t i = 0; i < truth.pictures.size(); ++i) {
    PicturePair& pair = pairs.emplace_back();
    pair.picture = &truth.pictures[i];
    if (const auto of = found.of_picture.find(i); of != found.of_picture.end())
      pair.found = of->second;
    std::vector<std::int64_t> pixels;
    for (const TrueObject& object : pair.picture->objects) {
      pair.object_class.push_back(place_of(object.category, classes));
      pixels.push_back(pixels_of(object.mask));
    }
    for (const FoundObject& object : pair.found) {
      pair.found_class.push_back(class_of(object.category, config, known, classes));
      std::vector<double>& box = pair.box.emplace_back();
      for (const TrueObject& is : pair.picture->objects)
        box.push_back(box_overlap(object.box, is.box));
      if (!found.has_masks) continue;
      std::vector<double>& mask = pair.mask.emplace_back();
      const std::int64_t own = pixels_of(object.mask);
      for (std::size_t o = 0; o < pixels.size(); ++o)
        mask.push_back(mask_overlap(object.mask, own, pair.picture->objects[o].mask, pixels[o]));
    }
  }
  return pairs;
}

DetectedImage image_of(const PicturePair& pair, std::optional<int> only,
                       const std::vector<std::vector<double>>& overlap) {
  DetectedImage image;
  std::vector<std::size_t> objects;
  for (std::size_t o = 0; o < pair.object_class.size(); ++o) {
    if (!only || pair.object_class[o] == *only) objects.push_back(o);
  }
  image.is_object_ignored.assign(objects.size(), 0);
  image.is_crowd.assign(objects.size(), 0);
  for (std::size_t d = 0; d < pair.found.size(); ++d) {
    if (only && pair.found_class[d] != *only) continue;
    image.score.push_back(pair.found[d].score);
    image.is_detection_ignored.push_back(0);
    std::vector<double>& row = image.overlap.emplace_back();
    for (const std::size_t o : objects) row.push_back(overlap[d][o]);
  }
  return image;
}

}  // namespace cousin
