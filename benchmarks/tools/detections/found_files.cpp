#include "benchmarks/tools/detections/found_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/atomic_file.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
constexpr std::size_t kFileLimit_bytes = std::size_t{1} << 30;
constexpr std::size_t kMostFound = 10'000'000;
constexpr double kMostPixel = 1e6;
constexpr int kDeepest = 16;  ///< that JSON is nested

/// A place in a file for messages.
class Place {
 public:
  Place(const fs::path& file, std::string at) : text_(file.string() + ": " + std::move(at)) {}
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(text_ + " " + what);
  }

 private:
  std::string text_;
};

/// Of scene and frame, or of a file; the others are numbers.
std::string longest_name(const PictureNames& pictures) {
  std::string longest;
  for (const auto& [name, size] : pictures) {
    if (name.size() > longest.size()) longest = name;
  }
  return longest;
}

const PictureSize& picture_of(const PictureNames& pictures, const std::string& name,
                              const Place& place) {
  const std::string plain = name.starts_with("#") ? name.substr(1) : name;
  auto found = pictures.find(name);
  if (found == pictures.end()) found = pictures.find(plain);
  if (found == pictures.end())
    place.fail("is of picture \"" + plain +
               "\", which the dataset has not; its pictures are named as \"" +
               longest_name(pictures) + "\"");
  if (found->second.is_ambiguous)
    place.fail("is of picture \"" + plain + "\", and the dataset has several of this name");
  return found->second;
}

// ---- COCO
// ----------------------------------------------------------------------------------------

double number(const json& value, const char* key, double low, double high, const Place& place) {
  if (!value.contains(key)) place.fail(std::string("has no ") + key);
  const json& entry = value[key];
  if (!entry.is_number()) place.fail(std::string(key) + " = " + entry.dump() + " is no number");
  const double number = entry.get<double>();
  if (!(number >= low && number <= high)) {
    std::ostringstream text;
    text << key << " = " << number << " is outside [" << low << ", " << high << "]";
    place.fail(text.str());
  }
  return number;
}

/// A picture's name without the ending of an image: other dots are of the name itself, as in
/// Roboflow's "a_jpg.rf.1b2c".
std::string without_ending(const std::string& text) {
  const fs::path name = fs::path(text).filename();
  for (const char* ending :
       {".jpg", ".jpeg", ".png", ".JPG", ".JPEG", ".PNG", ".bmp", ".webp", ".tif", ".tiff"}) {
    if (name.extension() == ending) return name.stem().string();
  }
  return name.string();
}

std::string name_of(const json& entry, const Place& place) {
  if (!entry.contains("image_id")) place.fail("has no image_id");
  const json& id = entry["image_id"];
  if (id.is_number_unsigned()) return "#" + std::to_string(id.get<std::uint64_t>());
  if (id.is_string()) return without_ending(id.get<std::string>());
  place.fail("image_id = " + id.dump() + " is neither a number nor a name");
}

std::vector<std::int64_t> runs_of(const json& counts, const Place& place) {
  if (counts.is_string()) return runs_of_coco(counts.get<std::string>());
  if (!counts.is_array()) place.fail("segmentation.counts is neither text nor a list");
  std::vector<std::int64_t> runs;
  for (const json& run : counts) {
    if (!run.is_number_integer()) place.fail("segmentation.counts has " + run.dump());
    runs.push_back(run.get<std::int64_t>());
  }
  return runs;
}

std::vector<std::vector<Eigen::Vector2d>> polygons_of(const json& list, const Place& place) {
  std::vector<std::vector<Eigen::Vector2d>> polygons;
  for (const json& part : list) {
    if (!part.is_array() || part.size() < 6 || part.size() % 2 != 0)
      place.fail("segmentation has a polygon that is not x, y of three points or more");
    std::vector<Eigen::Vector2d>& polygon = polygons.emplace_back();
    for (std::size_t i = 0; i < part.size(); i += 2) {
      if (!part[i].is_number() || !part[i + 1].is_number())
        place.fail("segmentation has a coordinate that is no number");
      polygon.emplace_back(part[i].get<double>(), part[i + 1].get<double>());
      if (!(polygon.back().cwiseAbs().maxCoeff() <= kMostPixel))
        place.fail("segmentation has a coordinate outside [-1e6, 1e6]");
    }
  }
  return polygons;
}

PlacedMask mask_of(const json& segmentation, const PictureSize& picture, const Place& place) {
  try {
    if (segmentation.is_array()) {
      if (segmentation.empty()) return {};
      return mask_of_polygons(polygons_of(segmentation, place), picture.width_px,
                              picture.height_px);
    }
    if (!segmentation.is_object() || !segmentation.contains("counts") ||
        !segmentation.contains("size"))
      place.fail("segmentation is neither polygons nor run lengths");
    const json size = {picture.height_px, picture.width_px};
    if (segmentation["size"] != size)
      place.fail("segmentation.size = " + segmentation["size"].dump() +
                 " is not the picture's [height, width] = " + size.dump());
    return mask_of_runs(runs_of(segmentation["counts"], place), picture.width_px,
                        picture.height_px);
  } catch (const std::invalid_argument& error) {
    place.fail(std::string("segmentation ") + error.what());
  }
}

FoundObject object_of(const json& entry, const PictureSize& picture, const Place& place) {
  FoundObject object;
  const double category = number(entry, "category_id", 0, 1e6, place);
  if (category != std::floor(category)) place.fail("category_id is no whole number");
  object.category = static_cast<int>(category);
  object.score = number(entry, "score", 0, 1, place);
  if (entry.contains("segmentation") && !entry["segmentation"].is_null())
    object.mask = mask_of(entry["segmentation"], picture, place);
  if (!entry.contains("bbox")) {
    if (object.mask.mask.empty()) place.fail("has neither bbox nor segmentation");
    object.box = {static_cast<double>(object.mask.x), static_cast<double>(object.mask.y),
                  static_cast<double>(object.mask.mask.width()),
                  static_cast<double>(object.mask.mask.height())};
    return object;
  }
  const json& bbox = entry["bbox"];
  if (!bbox.is_array() || bbox.size() != 4) place.fail("bbox is not [x, y, width, height]");
  std::array<double, 4> values{};
  for (std::size_t i = 0; i < 4; ++i) {
    if (!bbox[i].is_number()) place.fail("bbox has " + bbox[i].dump());
    values[i] = bbox[i].get<double>();
    const double least = i < 2 ? -kMostPixel : 0;
    if (!(values[i] >= least && values[i] <= kMostPixel))
      place.fail("bbox = " + bbox.dump() + " is not within 1e6 pixels, of positive size");
  }
  object.box = {values[0], values[1], values[2], values[3]};
  return object;
}

json parsed(const fs::path& file) {
  const std::string text = read_file(file, kFileLimit_bytes);
  // What nlohmann's values take of a list of small objects.
  check_memory(file, bytes_times(text.size(), 16), "its JSON");
  try {
    return json::parse(text, [&](int depth, json::parse_event_t, json&) {
      if (depth > kDeepest)
        throw std::runtime_error(file.string() + ": its JSON is nested too deep");
      return true;
    });
  } catch (const json::exception& error) {
    throw std::runtime_error(file.string() + ": is not JSON: " + error.what());
  }
}

// ---- YOLO
// ----------------------------------------------------------------------------------------

/// The numbers of a line. @throws through `place`
std::vector<double> numbers_of(const std::string& line, const Place& place) {
  std::vector<double> numbers;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value))
      place.fail("\"" + word + "\" is no number");
    numbers.push_back(value);
  }
  return numbers;
}

FoundObject object_of(const std::vector<double>& numbers, const PictureSize& picture,
                      const Place& place) {
  constexpr std::size_t kBox = 6, kLeastPolygon = 8;
  if (numbers.size() == kBox - 1) place.fail("has no confidence: it is a label, not a detection");
  if (numbers.size() != kBox && (numbers.size() < kLeastPolygon || numbers.size() % 2 != 0))
    place.fail("has " + std::to_string(numbers.size()) +
               " numbers; a box has 6 with its confidence, a polygon 8, 10, ...");
  FoundObject object;
  if (numbers[0] < 0 || numbers[0] > 1e6 || numbers[0] != std::floor(numbers[0]))
    place.fail("has a class that is no whole number");
  object.category = static_cast<int>(numbers[0]);
  object.score = numbers.back();
  if (object.score < 0 || object.score > 1) place.fail("has a confidence outside [0, 1]");
  for (std::size_t i = 1; i + 1 < numbers.size(); ++i) {
    if (std::abs(numbers[i]) > 10) place.fail("has a share that is not near [0, 1]");
  }
  const double w = picture.width_px, h = picture.height_px;
  if (numbers.size() == kBox) {
    if (numbers[3] < 0 || numbers[4] < 0) place.fail("has a negative width or height");
    object.box = {(numbers[1] - 0.5 * numbers[3]) * w, (numbers[2] - 0.5 * numbers[4]) * h,
                  numbers[3] * w, numbers[4] * h};
    return object;
  }
  std::vector<Eigen::Vector2d> polygon;
  for (std::size_t i = 1; i + 1 < numbers.size(); i += 2)
    polygon.emplace_back(numbers[i] * w, numbers[i + 1] * h);
  Eigen::Vector2d low = polygon[0], high = polygon[0];
  for (const Eigen::Vector2d& point : polygon)
    low = low.cwiseMin(point), high = high.cwiseMax(point);
  object.box = {low.x(), low.y(), high.x() - low.x(), high.y() - low.y()};
  try {
    object.mask = mask_of_polygons({polygon}, picture.width_px, picture.height_px);
  } catch (const std::invalid_argument& error) {
    place.fail(error.what());
  }
  return object;
}

/// Counts what is kept, and bounds it.
void keep(const fs::path& file, std::size_t picture, FoundObject object, std::uint64_t& pixels,
          FoundFile& found) {
  pixels += object.mask.mask.size();
  found.has_masks = found.has_masks || !object.mask.mask.empty();
  if (++found.count > kMostFound)
    throw std::runtime_error(file.string() + ": more than " + std::to_string(kMostFound) +
                             " detections, which is the limit");
  check_memory(file, pixels + found.count * sizeof(FoundObject), "the detections and their masks");
  found.of_picture[picture].push_back(std::move(object));
}

}  // namespace

FoundFile read_coco_results(const fs::path& file, const PictureNames& pictures) {
  const json root = parsed(file);
  if (root.is_object() && root.contains("annotations"))
    throw std::runtime_error(file.string() +
                             ": is a file of COCO annotations; detections are COCO results, a list "
                             "with scores");
  if (!root.is_array()) throw std::runtime_error(file.string() + ": is not a list of COCO results");
  FoundFile found;
  std::uint64_t pixels = 0;
  for (std::size_t i = 0; i < root.size(); ++i) {
    const Place place(file, "/" + std::to_string(i));
    if (!root[i].is_object()) place.fail("is no object");
    const PictureSize& picture = picture_of(pictures, name_of(root[i], place), place);
    keep(file, picture.place, object_of(root[i], picture, place), pixels, found);
  }
  return found;
}

FoundFile read_yolo_results(const fs::path& folder, const PictureNames& pictures) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".txt" && entry.is_regular_file())
      files.push_back(entry.path());
  }
  if (files.empty())
    throw std::runtime_error(folder.string() + ": holds no text file of detections (STEM.txt)");
  std::sort(files.begin(), files.end());
  FoundFile found;
  std::uint64_t pixels = 0;
  for (const fs::path& file : files) {
    std::istringstream lines(read_file(file, kFileLimit_bytes));
    const PictureSize& picture =
        picture_of(pictures, file.stem().string(), Place(file, "the file"));
    int at = 0;
    for (std::string line; std::getline(lines, line);) {
      const Place place(file, "line " + std::to_string(++at));
      const std::vector<double> numbers = numbers_of(line, place);
      if (numbers.empty()) continue;
      keep(file, picture.place, object_of(numbers, picture, place), pixels, found);
    }
  }
  return found;
}

FoundFile read_found(const fs::path& path, const PictureNames& pictures) {
  if (fs::is_directory(path)) {
    const fs::path labels = path / "labels";  // as Ultralytics lays a run
    return read_yolo_results(fs::is_directory(labels) ? labels : path, pictures);
  }
  if (!fs::is_regular_file(path))
    throw std::runtime_error(path.string() + ": is no file or folder");
  return read_coco_results(path, pictures);
}

}  // namespace cousin
