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
  for (const TruthRow& row : truth_table()) {
    if (row.show) row.show(run, estimate, scene);
  }
  std::vector<Mesh> truth;
  for (const Instance* object : specimens_of(run.truth.scene))
    truth.push_back(mesh_in_world(run.truth.scene, *object));
  scene.truth = merged(truth);
  return scene;
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
