#include "sim/dataset/labelled_frames.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "sim/dataset/categories.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/import_images.h"
#include "sim/imaging/image_io.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

Camera camera_of_picture(const Image<Rgb8>& color) {
  constexpr double kFocal = 0.85;  // of the larger side: phones, and cameras of middle zoom
  const double focal_px = kFocal * std::max(color.width(), color.height());
  return {.width_px = color.width(),
          .height_px = color.height(),
          .fx_px = focal_px,
          .fy_px = focal_px,
          .cx_px = 0.5 * (color.width() - 1),
          .cy_px = 0.5 * (color.height() - 1)};
}

}  // namespace

LabelledPhotographs photographs_of(const fs::path& source, const fs::path& root,
                                   const std::vector<fs::path>& images) {
  if (images.empty()) throw std::runtime_error(source.string() + ": it names no image");
  std::set<fs::path> known;
  for (const fs::path& image : images) {
    if (!known.insert(image.lexically_normal()).second)
      throw std::runtime_error(source.string() + ": names " + image.string() + " twice");
  }
  check_images_memory(source, images);
  LabelledPhotographs all;
  Capture& capture = all.capture;
  capture.frames.resize(images.size());
  for_each_frame(images.size(), [&](std::size_t i) {
    Frame& frame = capture.frames[i];
    frame.id = static_cast<int>(i);
    frame.time_s = static_cast<double>(i);
    frame.sensors.resize(1);
    SensorFrame& sensor = frame.sensors.front();
    sensor.color = read_color(images[i]);
    sensor.reported = camera_of_picture(sensor.color);
  });
  for (std::size_t i = 0; i < images.size(); ++i) {
    fs::path name = fs::proximate(images[i], root);
    if (name.empty() || *name.begin() == "..") name = images[i].filename();
    all.labels.pictures.push_back({static_cast<int>(i), name.generic_string(), ""});
  }
  capture.rig.push_back({.camera = capture.frames.front().sensors.front().reported});
  warn_of_orientation(images, capture);
  return all;
}

void set_categories(const fs::path& source, std::vector<std::string> names,
                    LabelledPhotographs& all) {
  all.categories = categories_from_json(categories_to_json(names), source.string() + ": names");
}

std::string_view without_bom(std::string_view text) {
  return text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
}

void add_label(const fs::path& source, GivenLabel label, LabelledPhotographs& all,
               LabelCounts& counts) {
  const Camera& camera =
      all.capture.frames.at(static_cast<std::size_t>(label.frame)).sensors.front().reported;
  const Eigen::Vector2d image_px(camera.width_px, camera.height_px);
  const Eigen::Vector2d low = label.corner_px.cwiseMax(0.0),
                        high = (label.corner_px + label.size_px).cwiseMin(image_px);
  if ((high - low).minCoeff() <= 0) {
    ++counts.outside;
    return;
  }
  DetectedBox box;
  box.frame = label.frame;
  box.id = static_cast<int>(all.labels.boxes.size());
  box.category = label.category;
  box.low_px = low.array() - 0.5;
  box.high_px = high.array() - 0.5;
  if (label.mask) {
    PlacedMask& mask = *label.mask;
    if (mask.mask.empty()) {
      const Eigen::Vector2d middle = 0.5 * (low + high);
      mask = {static_cast<int>(middle.x()), static_cast<int>(middle.y()),
              Image<std::uint8_t>(1, 1, 255)};
    }
    counts.mask_bytes += mask.mask.size();
    check_memory(source, counts.mask_bytes, "its masks");
    box.image_px = image_px.cast<int>();
    box.mask_at_px = {mask.x, mask.y};
    box.mask = std::move(mask.mask);
  }
  all.labels.boxes.push_back(std::move(box));
}

void warn_of_labels(const fs::path& source, const LabelCounts& counts, LabelledPhotographs& all) {
  const auto warn = [&](int count, const char* what) {
    if (count > 0)
      all.capture.warnings.push_back(source.string() + ": " + std::to_string(count) + what);
  };
  warn(counts.outside, " labels are left out: nothing of them is in their image");
  warn(counts.crowds,
       " regions that mark a crowd are left out: what a detector finds there counts as nothing");
  if (all.labels.boxes.empty())
    all.capture.warnings.push_back(source.string() + ": there is no label in any picture");
}

}  // namespace cousin
