#include <algorithm>
#include <optional>
#include <set>
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
  std::string warning;             ///< "" = none
};

/// A list's item without its quotes. Scalars have lost theirs already.
std::string unquoted(const YamlValues& values, const std::string& item) {
  const auto is_quote = [](char c) { return c == '"' || c == '\''; };
  if (item.empty() || (!is_quote(item.front()) && !is_quote(item.back()))) return item;
  if (item.size() < 2 || item.front() != item.back())
    values.fail(item + ": quotes about a comma are not read; write one name a line, \"0: name\"");
  return item.substr(1, item.size() - 2);
}

std::vector<std::string> list_of(const YamlValues& values, const std::string& key) {
  std::vector<std::string> items;
  for (const std::string& item : values.list(key)) {
    if (item.starts_with("{"))
      values.fail(key + ": \"{\" is not read; write one name a line, \"0: name\"");
    items.push_back(unquoted(values, item));
  }
  return items;
}

/// The names: a list, or a mapping from class to name.
std::vector<std::string> names_of_classes(const YamlValues& values) {
  std::vector<std::string> names;
  if (values.has("names")) {
    names = list_of(values, "names");
  } else {
    const YamlValues below = values.below("names");
    const std::size_t count = below.first_keys().size();
    for (std::size_t i = 0; i < count; ++i) {
      const std::string plain = std::to_string(i);
      std::string key = plain;
      for (const char* quote : {"'", "\""}) {
        if (below.has(quote + plain + quote)) key = quote + plain + quote;
      }
      if (!below.has(key))
        values.fail("names: there is no class " + plain + " among " + std::to_string(count));
      names.push_back(below.text(key));
    }
  }
  if (names.empty()) values.fail("there are no names of classes");
  if (values.has("nc") && values.number("nc") != static_cast<double>(names.size()))
    values.fail("nc = " + values.text("nc") + ", and there are " + std::to_string(names.size()) +
                " names");
  return names;
}

bool is_below(const fs::path& root, const fs::path& path) {
  const fs::path inside = fs::weakly_canonical(path), base = fs::weakly_canonical(root);
  return std::mismatch(base.begin(), base.end(), inside.begin(), inside.end()).first == base.end();
}

/// A folder that the file names, below `root`; Roboflow's "../train/images" is meant from beside
/// the file. Nothing where it is absent.
std::optional<fs::path> image_folder(const YamlValues& values, const fs::path& root,
                                     std::string named) {
  std::replace(named.begin(), named.end(), '\\', '/');
  for (const std::string& text : {named, named.starts_with("../") ? named.substr(3) : named}) {
    const fs::path folder = root / text;
    if (!fs::is_directory(folder)) continue;
    if (is_below(root, folder)) return folder.lexically_normal();
    values.fail("\"" + named + "\" leads out of " + root.string());
  }
  return std::nullopt;
}

/// The folder that train, val and test are below: `path`, if it is there and below the file's.
fs::path root_of(const YamlValues& values, const fs::path& file) {
  const fs::path folder = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  if (!values.has("path")) return folder;
  const fs::path path = folder / fs::path(values.text("path"));
  return fs::is_directory(path) && is_below(folder, path) ? path.lexically_normal() : folder;
}

YoloSet read_set_file(const fs::path& file) {
  YoloSet set;
  set.file = file;
  const std::string text = read_file(file, kMostYamlBytes);
  const YamlValues values(without_bom(text), file.string());
  if (values.has("kpt_shape"))
    values.fail("kpt_shape: labels of keypoints are not read; boxes and polygons are");
  set.root = root_of(values, file);
  set.names = names_of_classes(values);
  std::string absent;
  for (const char* split : {"train", "val", "test"}) {
    if (!values.has(split)) continue;
    for (const std::string& named : list_of(values, split)) {
      if (named.empty()) continue;
      if (named.ends_with(".txt"))
        values.fail(std::string(split) + ": " + named + " is a list; folders of images are read");
      if (const auto folder = image_folder(values, set.root, named))
        set.image_folders.push_back(*folder);
      else
        absent += (absent.empty() ? "" : ", ") + named;
    }
  }
  if (set.image_folders.empty())
    values.fail(absent.empty() ? "there is neither train, val nor test"
                               : absent + ": no such folder below " + set.root.string());
  if (!absent.empty()) set.warning = file.string() + ": absent, and not read: " + absent;
  return set;
}

YoloSet find_set(const fs::path& source) {
  if (!fs::is_directory(source)) return read_set_file(source);
  for (const char* name : {"data.yaml", "dataset.yaml", "data.yml"}) {
    if (fs::exists(source / name)) return read_set_file(source / name);
  }
  if (fs::is_directory(source / "images") && fs::is_directory(source / "labels"))
    return {source, source, {source / "images"}, {}, {}};
  throw std::runtime_error(source.string() + ": neither data.yaml nor images/ and labels/");
}

/// The pictures of the set's folders and of all folders below them, by their paths.
std::vector<fs::path> images_of(const YoloSet& set, std::vector<std::string>& warnings) {
  constexpr std::size_t kMostFolders = 100'000;
  std::set<fs::path> folders;
  for (const fs::path& top : set.image_folders) {
    folders.insert(top);
    for (const auto& entry : fs::recursive_directory_iterator(top)) {
      if (entry.is_directory() && !entry.is_symlink()) folders.insert(entry.path());
      if (folders.size() > kMostFolders)
        throw std::runtime_error(top.string() + ": more than 100000 folders");
    }
  }
  std::set<fs::path> images;
  for (const fs::path& folder : folders) {
    const PictureList list = list_pictures(folder, {".png", ".jpg", ".jpeg"});
    images.insert(list.files.begin(), list.files.end());
    if (!list.not_read.empty()) warnings.push_back(folder.string() + ": " + list.not_read);
  }
  return {images.begin(), images.end()};
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

/// One line of a label file. @param most_class  in and out: the largest class so far
void add_line(const fs::path& source, const TextLine& line, int frame,
              const Eigen::Vector2d& image_px, int& most_class, LabelledPhotographs& all,
              LabelCounts& counts) {
  const std::size_t n = line.size();
  constexpr std::size_t kBox = 5, kLeastPolygon = 7;
  if (n != kBox && (n < kLeastPolygon || n % 2 == 0))
    line.fail("has " + std::to_string(n) +
              " numbers; a box has 5, a polygon 7, 9, ...: six are a detection's, with confidence");
  const int category = static_cast<int>(line.integer(0, 0, kMostClass));
  most_class = std::max(most_class, category);
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 1; i + 1 < n; i += 2)
    points.push_back(
        Eigen::Vector2d(line.number_within(i, kMostShare), line.number_within(i + 1, kMostShare))
            .cwiseProduct(image_px));
  if (n == kBox) {
    if (points[1].minCoeff() < 0) line.fail("has a negative width or height");
    add_label(source, {frame, category + 1, points[0] - 0.5 * points[1], points[1], std::nullopt},
              all, counts);
    return;
  }
  Eigen::Vector2d low = points[0], high = points[0];
  for (const Eigen::Vector2d& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  try {
    add_label(source,
              {frame, category + 1, low, high - low,
               mask_of_polygons({points}, static_cast<int>(image_px.x()),
                                static_cast<int>(image_px.y()))},
              all, counts);
  } catch (const std::invalid_argument& error) {
    line.fail(error.what());
  }
}

/// All lines of a label file. @throws as import_yolo
void add_lines(const fs::path& file, int frame, int& most_class, LabelledPhotographs& all,
               LabelCounts& counts) {
  const Camera& camera =
      all.capture.frames[static_cast<std::size_t>(frame)].sensors.front().reported;
  const std::string content = read_file(file, kMostLabelBytes), name = file.string();
  const std::string_view text = without_bom(content);
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const TextLine line(text.substr(at, end - at), name, ++number);
    if (line.size() > 0)
      add_line(file, line, frame, Eigen::Vector2d(camera.width_px, camera.height_px), most_class,
               all, counts);
    at = end + 1;
  }
}

}  // namespace

LabelledPhotographs import_yolo(const fs::path& source) {
  YoloSet set = find_set(source);
  std::vector<std::string> warnings;
  if (!set.warning.empty()) warnings.push_back(set.warning);
  const std::vector<fs::path> images = images_of(set, warnings);
  LabelledPhotographs all = photographs_of(set.file, set.root, images);
  all.capture.warnings.insert(all.capture.warnings.begin(), warnings.begin(), warnings.end());
  LabelCounts counts;
  int most_class = -1;
  std::size_t with_file = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const fs::path file = label_file(images[i]);
    if (!fs::exists(file)) continue;
    if (!is_below(set.root, file))
      throw std::runtime_error(file.string() + ": a link that leads out of " + set.root.string());
    ++with_file;
    add_lines(file, static_cast<int>(i), most_class, all, counts);
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
    for (int k = 0; k <= std::max(0, most_class); ++k)
      set.names.push_back("class " + std::to_string(k));
  } else if (most_class >= named) {
    throw std::runtime_error(set.file.string() + ": class " + std::to_string(most_class) +
                             " of a label is none of the " + std::to_string(named) + " names");
  }
  set_categories(set.file, std::move(set.names), all);
  warn_of_labels(set.file, counts, all);
  return all;
}

}  // namespace cousin
