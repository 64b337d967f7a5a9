#include "benchmarks/loop/render_plan.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "benchmarks/loop/truth_choice.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

// Bytes a pixel of the PNG files that the simulated sensors give: noise hardly packs.
constexpr double kColorBytes = 1.9, kRawBytes = 1.4, kInfraredBytes = 0.8, kDepthBytes = 1.0;

PlannedPicture picture(const std::string& name, int width_px, int height_px, double bytes_a_pixel) {
  return {name, width_px, height_px,
          bytes_a_pixel * static_cast<double>(width_px) * static_cast<double>(height_px)};
}

/// Colour or grey cameras, with raw images where they are handed over.
void add_cameras(const RigConfig& rig, const Streams& streams, std::vector<PlannedPicture>& all) {
  for (const RigSensor& sensor : rig.sensors) {
    const int width = sensor.camera.width_px, height = sensor.camera.height_px;
    if (streams.color) all.push_back(picture(sensor.name, width, height, kColorBytes));
    if (streams.raw) all.push_back(picture(sensor.name + " raw", width, height, kRawBytes));
  }
}

struct PicturesOf {
  const Streams& streams;
  std::vector<PlannedPicture>& all;

  void operator()(const PhoneConfig& phone) const {
    if (streams.color) all.push_back(picture("rgb", phone.width_px, phone.height_px, kColorBytes));
    if (streams.raw) all.push_back(picture("rgb raw", phone.width_px, phone.height_px, kRawBytes));
  }
  void operator()(const RigConfig& rig) const { add_cameras(rig, streams, all); }
  void operator()(const ActiveStereoConfig& device) const {
    const Camera depth = depth_camera(device);
    if (streams.color)
      all.push_back(picture("rgb", device.color_columns, device.color_rows, kColorBytes));
    if (streams.raw)
      all.push_back(picture("rgb raw", device.color_columns, device.color_rows, kRawBytes));
    for (const char* name : {"ir_left", "ir_right"}) {
      if (streams.infrared)
        all.push_back(picture(name, depth.width_px, depth.height_px, kInfraredBytes));
    }
    if (streams.depth)
      all.push_back(picture("depth", depth.width_px, depth.height_px, kDepthBytes));
  }
  void operator()(const RangeRigConfig& device) const {
    add_cameras(device.body, streams, all);
    const Camera depth = depth_camera(device);
    if (streams.depth)
      all.push_back(picture("depth", depth.width_px, depth.height_px, kDepthBytes));
  }
};

std::string bytes_text(double bytes) {
  char text[32];
  if (bytes >= 1e9)
    std::snprintf(text, sizeof text, "%.1f GB", bytes / 1e9);
  else
    std::snprintf(text, sizeof text, bytes >= 1e7 ? "%.0f MB" : "%.1f MB", bytes / 1e6);
  return text;
}

std::string count_of(int count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

std::vector<PlannedPicture> planned_pictures(const DeviceConfig& rig, const Streams& streams) {
  std::vector<PlannedPicture> pictures;
  std::visit(PicturesOf{streams, pictures}, rig);
  return pictures;
}

RenderPlan render_plan(const RunConfig& config, const TruthNeeds& truth, int scenes, int views,
                       const std::filesystem::path& dataset) {
  RenderPlan plan;
  plan.scenes = scenes;
  plan.views = views;
  plan.views_of_all = scenes * config.scene.views();
  plan.dataset = dataset;
  const Streams streams = planned_streams(config);
  plan.pictures = planned_pictures(config.rig, streams);
  for (const PlannedPicture& each : plan.pictures) plan.picture_bytes += each.bytes * views;
  plan.passes = simulator_plan(config);
  const auto there_is = truth_names(truth_there_is(config.rig, streams));
  const auto chosen = truth_names(truth);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const auto& [name, is_chosen] = chosen[i];
    plan.passes.push_back({"truth: " + name, is_chosen,
                           is_chosen            ? "written below truth/"
                           : there_is[i].second ? "--truth " + name + " writes it"
                                                : "this capture has none"});
  }
  plan.passes.push_back({"perceive", false, "`cousin perceive` reads the dataset"});
  plan.passes.push_back({"score", false, "`cousin score` reads both"});
  return plan;
}

std::string describe(const RenderPlan& plan) {
  std::string text = "renders: " + count_of(plan.views, "view");
  if (plan.views != plan.views_of_all)
    text += " of " + std::to_string(plan.views_of_all) + ", this shard's";
  text += " of " + count_of(plan.scenes, "scene") + "\n";
  for (const PlannedPicture& each : plan.pictures) {
    char line[128];
    std::snprintf(line, sizeof line, "  %-12s %d x %d\n", each.name.c_str(), each.width_px,
                  each.height_px);
    text += line;
  }
  return text + "writes: " + plan.dataset.string() + ", about " + bytes_text(plan.picture_bytes) +
         " of pictures, truth apart\n" + describe(plan.passes);
}

std::string to_json(const RenderPlan& plan) {
  nlohmann::json pictures = nlohmann::json::array(), passes = nlohmann::json::array();
  for (const PlannedPicture& each : plan.pictures)
    pictures.push_back(
        {{"name", each.name}, {"width_px", each.width_px}, {"height_px", each.height_px}});
  for (const PlanEntry& entry : plan.passes)
    passes.push_back({{"pass", entry.pass}, {"runs", entry.runs}, {"why", entry.why}});
  return nlohmann::json{{"dataset", readable_utf8(plan.dataset.string())},
                        {"scenes", plan.scenes},
                        {"views", plan.views},
                        {"views_of_all", plan.views_of_all},
                        {"pictures", pictures},
                        {"picture_bytes", plan.picture_bytes},
                        {"passes", passes}}
             .dump(2) +
         "\n";
}

}  // namespace cousin
