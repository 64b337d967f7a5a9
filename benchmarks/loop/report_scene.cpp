#include "benchmarks/loop/report_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "benchmarks/loop/true_outline.h"
#include "benchmarks/loop/truth_stages.h"
#include "perception/splats/splat_ply.h"
#include "sim/dataset/atomic_file.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/image_io.h"
#include "sim/truth/specimens.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr int kJpegQuality = 92;  ///< of photographs; drawings are PNG
constexpr std::size_t kMaxPictures = 64;
constexpr const char* kIndex = "scene.json";

Image<Rgb8> crop(const Image<Rgb8>& image, int x0, int y0, int x1, int y1) {
  x0 = std::clamp(x0, 0, image.width() - 1);
  y0 = std::clamp(y0, 0, image.height() - 1);
  x1 = std::clamp(x1, x0 + 1, image.width());
  y1 = std::clamp(y1, y0 + 1, image.height());
  Image<Rgb8> result(x1 - x0, y1 - y0);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) result(x - x0, y - y0) = image(x, y);
  }
  return result;
}

Image<Rgb8> enlarged(const Image<Rgb8>& image, int factor) {
  Image<Rgb8> result(image.width() * factor, image.height() * factor);
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) result(x, y) = image(x / factor, y / factor);
  }
  return result;
}

/// The view's image about its outlines, enlarged, with the outlines drawn in.
Image<Rgb8> with_outlines(const Image<Rgb8>& image,
                          const std::vector<const Silhouette*>& silhouettes) {
  float left = 1e9F, top = 1e9F, right = -1e9F, bottom = -1e9F;
  for (const Silhouette* s : silhouettes) {
    for (const OutlinePoint& p : s->outline) {
      left = std::min(left, p.pixel_px.x());
      right = std::max(right, p.pixel_px.x());
      top = std::min(top, p.pixel_px.y());
      bottom = std::max(bottom, p.pixel_px.y());
    }
  }
  constexpr int kMargin = 12, kZoom = 3;
  const int x0 = std::max(0, static_cast<int>(left) - kMargin),
            y0 = std::max(0, static_cast<int>(top) - kMargin);
  Image<Rgb8> picture = enlarged(
      crop(image, x0, y0, static_cast<int>(right) + kMargin, static_cast<int>(bottom) + kMargin),
      kZoom);
  for (const Silhouette* s : silhouettes) {
    for (std::size_t i = 0; i < s->outline.size(); ++i) {
      const Eigen::Vector2f a = s->outline[i].pixel_px,
                            b = s->outline[(i + 1) % s->outline.size()].pixel_px;
      const Rgb8 color = s->outline[i].on_object ? Rgb8{255, 0, 160} : Rgb8{0, 200, 255};
      for (int k = 0; k < 12; ++k) {
        const Eigen::Vector2f p = a + (b - a) * (static_cast<float>(k) / 12);
        const int x =
            static_cast<int>(std::lround((p.x() - static_cast<float>(x0) + 0.5F) * kZoom - 0.5F));
        const int y =
            static_cast<int>(std::lround((p.y() - static_cast<float>(y0) + 0.5F) * kZoom - 0.5F));
        if (picture.contains(x, y)) picture(x, y) = color;
      }
    }
  }
  return picture;
}

std::string text_at(const nlohmann::json& json, const char* key, const fs::path& file) {
  if (!json.is_object() || !json.contains(key) || !json.at(key).is_string()) {
    throw std::runtime_error(file.string() + ": \"" + key + "\" must be text");
  }
  return json.at(key).get<std::string>();
}

/// It becomes a folder's name; a dot at the front is for what is not whole yet.
bool is_scene_name(const std::string& name) {
  return !name.empty() && name.front() != '.' &&
         name.find_first_not_of(
             "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") ==
             std::string::npos;
}

ReportScene read_report_scene(const fs::path& folder) {
  const fs::path index = folder / kIndex;
  const auto json = nlohmann::json::parse(read_file(index), nullptr, false);
  if (json.is_discarded()) throw std::runtime_error(index.string() + ": is not JSON");
  ReportScene scene;
  scene.name = text_at(json, "name", index);
  if (!is_scene_name(scene.name)) {
    throw std::runtime_error(index.string() + ": \"name\": \"" + scene.name +
                             "\" must be of letters, digits, . _ - and not start with a dot");
  }
  if (!json.contains("pictures") || !json.at("pictures").is_array() ||
      json.at("pictures").size() > kMaxPictures) {
    throw std::runtime_error(index.string() + ": \"pictures\" must be a list of at most " +
                             std::to_string(kMaxPictures));
  }
  for (const auto& entry : json.at("pictures")) {
    const fs::path file = text_at(entry, "file", index);
    if (file != file.filename()) {
      throw std::runtime_error(index.string() + ": \"file\": \"" + file.string() +
                               "\" leads out of the folder");
    }
    read_color(folder / file);  // a picture that cannot be decoded would leave a hole in the page
    const std::string bytes = read_file(folder / file);
    scene.pictures.push_back({text_at(entry, "name", index), text_at(entry, "caption", index),
                              std::vector<std::uint8_t>(bytes.begin(), bytes.end())});
  }
  if (fs::exists(folder / "cloud.ply")) scene.cloud = read_cloud_ply(folder / "cloud.ply").cloud;
  if (fs::exists(folder / "measured.ply")) scene.measured = read_mesh(folder / "measured.ply");
  if (fs::exists(folder / "truth.ply")) scene.truth = read_mesh(folder / "truth.ply");
  if (fs::exists(folder / "splats.ply")) scene.splats = read_splat_ply(folder / "splats.ply").model;
  return scene;
}

/// Depth as grey levels between its 2 % and 98 % quantiles, near is bright; black = none.
Image<Rgb8> depth_picture(const Image<std::uint16_t>& depth) {
  std::vector<std::uint16_t> codes;
  std::copy_if(depth.begin(), depth.end(), std::back_inserter(codes),
               [](std::uint16_t code) { return code > 0; });
  std::sort(codes.begin(), codes.end());
  Image<Rgb8> picture(depth.width(), depth.height());
  if (codes.empty()) return picture;
  const double low = codes[codes.size() / 50], high = codes[codes.size() - 1 - codes.size() / 50];
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const double code = depth.data()[i];
    if (code == 0) continue;
    const double share = std::clamp((high - code) / std::max(1.0, high - low), 0.0, 1.0);
    const auto grey = static_cast<std::uint8_t>(40 + 215 * share);
    picture.data()[i] = {grey, grey, grey};
  }
  return picture;
}

Image<Rgb8> grey_picture(const Image<std::uint8_t>& grey) {
  Image<Rgb8> picture(grey.width(), grey.height());
  for (std::size_t i = 0; i < grey.size(); ++i)
    picture.data()[i] = {grey.data()[i], grey.data()[i], grey.data()[i]};
  return picture;
}

constexpr Rgb8 kBoxColor{255, 0, 160}, kPointColor{0, 200, 255};

/// The image with boxes of its first sensor, and a cross where each measured point is seen.
Image<Rgb8> with_boxes(Image<Rgb8> image, int frame, const Camera& camera,
                       const Estimate& estimate) {
  const auto dot = [&](int x, int y, Rgb8 color) {
    if (image.contains(x, y)) image(x, y) = color;
  };
  for (const DetectedBox& box : estimate.boxes) {
    if (box.frame != frame || box.sensor != 0) continue;
    const Eigen::Vector2i low = (box.low_px.array() + 0.5).floor().cast<int>(),
                          high = (box.high_px.array() - 0.5).ceil().cast<int>();
    for (int x = low.x(); x <= high.x(); ++x) {
      dot(x, low.y(), kBoxColor);
      dot(x, high.y(), kBoxColor);
    }
    for (int y = low.y(); y <= high.y(); ++y) {
      dot(low.x(), y, kBoxColor);
      dot(high.x(), y, kBoxColor);
    }
  }
  for (const SpecimenTraits& traits : estimate.traits) {
    if (traits.frame != frame || traits.status != TraitStatus::ok) continue;
    Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
    for (const Trait& trait : traits.traits) {
      for (int k = 0; k < 3; ++k) {
        if (trait.name == std::string("point_") + "xyz"[k]) point_m[k] = trait.value;
      }
    }
    const auto pixel = project(camera, point_m);
    if (!pixel) continue;
    const int x = static_cast<int>(std::lround(pixel->x())),
              y = static_cast<int>(std::lround(pixel->y()));
    for (int k = -4; k <= 4; ++k) {
      dot(x + k, y, kPointColor);
      dot(x, y + k, kPointColor);
    }
  }
  return image;
}

/// Digits of 3 by 5 dots, a bit each, rows from above.
constexpr std::array<std::array<int, 5>, 10> kDigits = {{{7, 5, 5, 5, 7},
                                                         {2, 6, 2, 2, 7},
                                                         {7, 1, 7, 4, 7},
                                                         {7, 1, 7, 1, 7},
                                                         {5, 5, 7, 1, 1},
                                                         {7, 4, 7, 1, 7},
                                                         {7, 4, 7, 5, 7},
                                                         {7, 1, 1, 2, 2},
                                                         {7, 5, 7, 5, 7},
                                                         {7, 5, 7, 1, 7}}};

/// White digits on black about a pixel.
void write_number(Image<Rgb8>& image, int number, const Eigen::Vector2d& at_px, int dot_px) {
  const std::string text = std::to_string(std::max(0, number));
  const int width = dot_px * (4 * static_cast<int>(text.size()) + 1), height = dot_px * 7;
  const int x0 = static_cast<int>(std::lround(at_px.x())) - width / 2,
            y0 = static_cast<int>(std::lround(at_px.y())) - height / 2;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!image.contains(x0 + x, y0 + y)) continue;
      const int column = x / dot_px - 1, row = y / dot_px - 1;
      const bool is_inside = column >= 0 && column % 4 < 3 && row >= 0 && row < 5;
      const auto digit =
          static_cast<std::size_t>(text[static_cast<std::size_t>(std::max(0, column) / 4)] - '0');
      const bool is_dot =
          is_inside && (kDigits[digit][static_cast<std::size_t>(row)] >> (2 - column % 4) & 1) != 0;
      image(x0 + x, y0 + y) = is_dot ? Rgb8{255, 255, 255} : Rgb8{0, 0, 0};
    }
  }
}

/// The image with each specimen's number at its middle, as specimens.csv has it.
Image<Rgb8> with_numbers(Image<Rgb8> image, const SceneTruth& truth, const TrueView& view) {
  const int dot_px = std::max(1, image.width() / 480);
  for (const Instance* object : specimens_of(truth.scene)) {
    const Mesh mesh = mesh_in_world(truth.scene, *object);
    if (mesh.triangles.empty()) continue;
    const auto pixel = project_rolling(view, mass_properties(mesh).centroid_m);
    if (pixel && image.contains(static_cast<int>(pixel->x()), static_cast<int>(pixel->y())))
      write_number(image, object->id, *pixel, dot_px);
  }
  return image;
}

/// What the rig hands over at one instant.
void add_views(const Frame& frame, const std::vector<SensorReport>& rig,
               std::vector<ReportPicture>& pictures) {
  const std::string name = "View " + std::to_string(frame.id);
  for (std::size_t s = 0; s < frame.sensors.size(); ++s) {
    const SensorFrame& sensor = frame.sensors[s];
    const std::string of = rig.size() > 1 ? name + ", " + rig[s].name : name;
    if (!sensor.color.empty()) {
      pictures.push_back(
          {of, rig.size() > 1 ? "as the rig hands it over" : "as the phone hands it over",
           encode_jpeg(sensor.color, kJpegQuality)});
    }
    if (!sensor.grey.empty())
      pictures.push_back(
          {of, "infrared, linear", encode_jpeg(grey_picture(sensor.grey), kJpegQuality)});
    if (!sensor.depth.empty()) {
      pictures.push_back({of, "the sensor's depth, near is bright, black = none",
                          encode_png(depth_picture(sensor.depth))});
    }
  }
}

}  // namespace

ReportScene report_scene(const std::string& name, const SimulatedRun& run,
                         const Estimate& estimate) {
  ReportScene scene;
  scene.name = name;
  const auto& frames = run.capture.frames;
  const std::size_t count = frames.size();
  for (const std::size_t i : std::set{count / 6, count / 2, 5 * count / 6}) {
    if (i < count) add_views(frames[i], run.capture.rig, scene.pictures);
  }
  std::map<int, std::vector<const Silhouette*>> by_frame;
  for (const Silhouette& s : estimate.silhouettes) {
    if (!s.outline.empty()) by_frame[s.frame].push_back(&s);
  }
  for (const std::size_t i : std::set{count / 6, 5 * count / 6}) {
    if (i >= count || !by_frame.contains(frames[i].id)) continue;
    if (frames[i].sensors[0].color.empty()) continue;
    scene.pictures.push_back(
        {"Outlines found in view " + std::to_string(frames[i].id),
         "magenta; blue where something else cuts them; 3 times enlarged",
         encode_png(with_outlines(frames[i].sensors[0].color, by_frame[frames[i].id]))});
  }
  for (const std::size_t i : std::set{count / 6, count / 2, 5 * count / 6}) {
    if (i >= count || estimate.boxes.empty() || frames[i].sensors[0].color.empty()) continue;
    const SensorFrame& seen = frames[i].sensors[0];
    scene.pictures.push_back(
        {"Boxes in view " + std::to_string(frames[i].id),
         "magenta: boxes; blue crosses: where the measured points are seen",
         encode_png(enlarged(with_boxes(seen.color, frames[i].id, seen.reported, estimate), 2))});
  }
  const std::size_t middle = count / 2;
  if (middle < count && middle < run.truth.views.size() &&
      !frames[middle].sensors[0].color.empty() && !specimens_of(run.truth.scene).empty())
    scene.pictures.push_back(
        {"Specimens by number, view " + std::to_string(frames[middle].id),
         "the numbers of specimens.csv (instance), each at its specimen's true middle",
         encode_jpeg(
             with_numbers(frames[middle].sensors[0].color, run.truth, run.truth.views[middle]),
             kJpegQuality)});
  scene.cloud = estimate.cloud;
  std::vector<Mesh> measured, truth;
  for (const Surface& surface : estimate.surfaces) {
    if (!surface.mesh.triangles.empty()) measured.push_back(surface.mesh);
  }
  for (const Instance* object : specimens_of(run.truth.scene)) {
    truth.push_back(mesh_in_world(run.truth.scene, *object));
  }
  scene.measured = merged(measured);
  scene.truth = merged(truth);
  scene.splats = without_directions(estimate.splats);
  return scene;
}

SplatModel without_directions(SplatModel model) {
  model.sh_degree = 0;
  for (Splat& splat : model.splats) splat.sh_rest = {};
  return model;
}

void write_report_scene(const fs::path& folder, const ReportScene& scene) {
  if (!is_scene_name(scene.name)) {
    throw std::invalid_argument("the report's scene \"" + scene.name +
                                "\" must be named by letters, digits, . _ - and no dot first");
  }
  PartFolder part(folder / scene.name);  // nothing of an earlier scene may stay
  const fs::path& own = part.path();
  nlohmann::ordered_json pictures = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < scene.pictures.size(); ++i) {
    const ReportPicture& picture = scene.pictures[i];
    const bool is_jpeg = picture.file.size() > 1 && picture.file[1] == 0xd8;
    const std::string name = "picture_" + std::to_string(i) + (is_jpeg ? ".jpg" : ".png");
    write_file(own / name, std::string(picture.file.begin(), picture.file.end()));
    pictures.push_back({{"file", name}, {"name", picture.name}, {"caption", picture.caption}});
  }
  if (!scene.cloud.empty()) write_ply(own / "cloud.ply", scene.cloud);
  if (!scene.measured.triangles.empty()) write_ply(own / "measured.ply", scene.measured);
  if (!scene.truth.triangles.empty()) write_ply(own / "truth.ply", scene.truth);
  if (!scene.splats.splats.empty()) write_splat_ply(own / "splats.ply", scene.splats);
  write_file(own / kIndex,
             nlohmann::ordered_json{{"name", scene.name}, {"pictures", pictures}}.dump(
                 2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
                 "\n");
  part.replace();
}

std::vector<ReportScene> read_report_scenes(const fs::path& folder, const WantedScene& wanted) {
  std::set<std::string> names;
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (is_scene_name(name) && (!wanted || wanted(name))) names.insert(name);
    }
  }
  std::vector<ReportScene> scenes;
  for (const std::string& name : names) {
    // Another process may be replacing the scene since it was listed.
    if (fs::exists(folder / name / kIndex)) scenes.push_back(read_report_scene(folder / name));
  }
  return scenes;
}

}  // namespace cousin
