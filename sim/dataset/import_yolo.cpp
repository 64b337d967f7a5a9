#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/import_labels.h"
#include "sim/dataset/labelled_frames.h"
#include "sim/dataset/picture_list.h"
#include "sim/dataset/text_fields.h"
#include "sim/dataset/yaml_values.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostYamlBytes = std::size_t{1} << 24;
constexpr std::size_t kMostLabelBytes = std::size_t{1} << 26;
constexpr int kMostClass = 9'999;
constexpr double kMostShare = 1000;  ///< of an image's side; more is no share

/// A set's folders and names.
struct YoloSet {
  fs::path root, file;
  std::vector<fs::path> image_folders;
  std::vector<std::string> names;  ///< by class
};

/// The names: a list, or a mapping from class to name.
std::vector<std::string> names_of_classes(const YamlValues& values) {
  if (values.has("names")) return values.list("names");
  const YamlValues below = values.below("names");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < below.first_keys().size(); ++i) {
    if (!below.has(std::to_string(i)))
      values.fail("names: there is no class " + std::to_string(i) + " among " +
                  std::to_string(below.first_keys().size()));
    names.push_back(below.text(std::to_string(i)));
  }
  if (names.empty()) values.fail("there are no names of classes");
  return names;
}

/// A folder that the file names; Roboflow's "../train/images" is meant from beside the file.
fs::path image_folder(const YamlValues& values, const fs::path& root, const std::string& named) {
  for (const std::string& text : {named, named.starts_with("../") ? named.substr(3) : named}) {
    const fs::path folder = root / text;
    if (!fs::is_directory(folder)) continue;
    const fs::path inside = fs::weakly_canonical(folder), base = fs::weakly_canonical(root);
    const auto [end, rest] = std::mismatch(base.begin(), base.end(), inside.begin(), inside.end());
    if (end == base.end()) return inside;
  }
  values.fail("\"" + named + "\" is no folder below " + root.string());
}

YoloSet read_set_file(const fs::path& file) {
  YoloSet set;
  set.file = file;
  const YamlValues values(read_file(file, kMostYamlBytes), file.string());
  if (values.has("kpt_shape"))
    values.fail("kpt_shape: labels of keypoints are not read; boxes and polygons are");
  set.root = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  if (values.has("path")) {
    const fs::path path = values.text("path");
    if (path.is_relative() && fs::is_directory(set.root / path)) set.root /= path;
  }
  set.names = names_of_classes(values);
  for (const char* split : {"train", "val", "test"}) {
    if (!values.has(split)) continue;
    for (const std::string& named : values.list(split)) {
      if (named.empty()) continue;
      if (named.ends_with(".txt"))
        values.fail(std::string(split) + ": " + named + " is a list; folders of images are read");
      set.image_folders.push_back(image_folder(values, set.root, named));
    }
  }
  std::sort(set.image_folders.begin(), set.image_folders.end());
  set.image_folders.erase(std::unique(set.image_folders.begin(), set.image_folders.end()),
                          set.image_folders.end());
  if (set.image_folders.empty()) values.fail("there is neither train, val nor test");
  return set;
}

YoloSet find_set(const fs::path& source) {
  if (!fs::is_directory(source)) return read_set_file(source);
  for (const char* name : {"data.yaml", "dataset.yaml", "data.yml"}) {
    if (fs::exists(source / name)) return read_set_file(source / name);
  }
  if (fs::is_directory(source / "images") && fs::is_directory(source / "labels"))
    return {source, source, {source / "images"}, {}};
  throw std::runtime_error(source.string() + ": neither data.yaml nor images/ and labels/");
}

/// Where an image's labels are: "images" nearest to it becomes "labels".
fs::path label_file(const fs::path& image) {
  fs::path folder = image.parent_path(), behind;
  while (!folder.empty() && folder.filename() != "images" && folder != folder.parent_path()) {
    behind = folder.filename() / behind;
    folder = folder.parent_path();
  }
  const std::string name = image.stem().string() + ".txt";
  if (folder.filename() != "images") return image.parent_path() / name;
  return folder.parent_path() / "labels" / behind / name;
}

/// One line of a label file. @param most_class  out: the largest class so far
void add_line(const TextLine& line, int frame, const Eigen::Vector2d& image_px, int& most_class,
              LabelledPhotographs& all, LabelCounts& counts) {
  const std::size_t n = line.size();
  constexpr std::size_t kBox = 5, kLeastPolygon = 7;
  if (n != kBox && (n < kLeastPolygon || n % 2 == 0))
    line.fail("has " + std::to_string(n) +
              " numbers; a box has 5, a polygon 7, 9, ...: six are a detection's, with confidence");
  const int category = static_cast<int>(line.integer(0, 0, kMostClass));
  most_class = std::max(most_class, category);
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 1; i + 1 < n; i += 2)
    points.emplace_back(line.number_within(i, kMostShare), line.number_within(i + 1, kMostShare));
  if (n == kBox) {
    const Eigen::Vector2d size = points[1].cwiseProduct(image_px);
    if (size.minCoeff() < 0) line.fail("has a negative width or height");
    add_label(frame, category + 1, points[0].cwiseProduct(image_px) - 0.5 * size, size, {}, all,
              counts);
    return;
  }
  Eigen::Vector2d low = image_px * kMostShare, high = -low;
  for (Eigen::Vector2d& point : points) {
    point = point.cwiseProduct(image_px);
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  PlacedMask mask;
  try {
    mask =
        mask_of_polygons({points}, static_cast<int>(image_px.x()), static_cast<int>(image_px.y()));
  } catch (const std::invalid_argument& error) {
    line.fail(error.what());
  }
  add_label(frame, category + 1, low, high - low, std::move(mask), all, counts);
}

}  // namespace

LabelledPhotographs import_yolo(const fs::path& source) {
  YoloSet set = find_set(source);
  std::vector<fs::path> images;
  std::string not_read;
  for (const fs::path& folder : set.image_folders) {
    PictureList list = list_pictures(folder, {".png", ".jpg", ".jpeg"});
    images.insert(images.end(), list.files.begin(), list.files.end());
    if (!list.not_read.empty()) not_read = folder.string() + ": " + list.not_read;
  }
  LabelledPhotographs all = photographs_of(set.file, images);
  if (!not_read.empty()) all.capture.warnings.push_back(not_read);
  LabelCounts counts;
  int most_class = -1;
  std::size_t with_file = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const fs::path file = label_file(images[i]);
    if (!fs::exists(file)) continue;
    ++with_file;
    const Camera& camera = all.capture.frames[i].sensors.front().reported;
    const std::string text = read_file(file, kMostLabelBytes), name = file.string();
    int number = 0;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      const TextLine line(std::string_view(text).substr(at, end - at), name, ++number);
      if (line.size() > 0)
        add_line(line, static_cast<int>(i), Eigen::Vector2d(camera.width_px, camera.height_px),
                 most_class, all, counts);
      at = end + 1;
    }
  }
  if (with_file == 0)
    throw std::runtime_error(set.file.string() + ": none of " + std::to_string(images.size()) +
                             " images has a label file, as " + label_file(images[0]).string());
  if (with_file < images.size())
    all.capture.warnings.push_back(set.file.string() + ": " +
                                   std::to_string(images.size() - with_file) +
                                   " images have no label file: they show nothing");
  const auto named = static_cast<int>(set.names.size());
  if (set.names.empty()) {
    for (int k = 0; k <= most_class; ++k) set.names.push_back("class " + std::to_string(k));
  } else if (most_class >= named) {
    throw std::runtime_error(set.file.string() + ": class " + std::to_string(most_class) +
                             " of a label is none of the " + std::to_string(named) + " names");
  }
  all.categories = set.names;
  warn_of_labels(set.file, counts, all);
  return all;
}

}  // namespace cousin
