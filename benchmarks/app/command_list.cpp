// scenes, rigs, methods and doctor: what there is, what is not built in, what this machine lacks.
#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/loop/scene_table.h"
#include "benchmarks/report/javascript_libraries.h"
#include "perception/pipelines/pipeline_table.h"
#include "perception/sfm/colmap_run.h"
#include "sim/process/program_run.h"
#include "sim/sensors/active_stereo.h"
#include "sim/sensors/phone.h"
#include "sim/sensors/range_rig.h"
#include "sim/sensors/rig.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

struct Entry {
  std::string name;
  std::string status;  ///< "built in", "not built in: why", or what backs a preset
  std::string help;
};

void print(const std::vector<Entry>& entries, bool json) {
  if (json) {
    nlohmann::json rows = nlohmann::json::array();
    for (const Entry& e : entries)
      rows.push_back({{"name", e.name}, {"status", e.status}, {"help", e.help}});
    print_json(rows);
    return;
  }
  for (const Entry& e : entries) {
    std::printf("%-20s %-34s %s\n", terminal_text(e.name).c_str(), e.status.c_str(),
                terminal_text(e.help).c_str());
  }
}

std::string built(bool is_built, const char* option) {
  return is_built ? "built in" : std::string("not built in: ") + option + " is OFF";
}

}  // namespace

ExitCode command_scenes(const JobContext& context) {
  std::vector<Entry> entries;
  for (const SceneEntry& scene : scene_table()) {
    const bool only_renders = scene.status == "built in" && !pipeline_of_scene(scene.text.name);
    entries.push_back({scene.name(), scene.status + (only_renders ? "; no pipeline yet" : ""),
                       std::string(scene.text.help)});
  }
  print(entries, context.options.json);
  return ExitCode::done;
}

namespace {

std::string size_text(int width_px, int height_px) {
  return std::to_string(width_px) + " x " + std::to_string(height_px);
}

std::vector<Entry> phone_entries() {
  std::vector<Entry> entries;
  for (const std::string& name : phone_preset_names()) {
    const PhoneConfig config = phone_preset(name);
    entries.push_back(
        {name, "verified (against theory only)",
         "phone video, three photosites a pixel, " + size_text(config.width_px, config.height_px)});
  }
  return entries;
}

std::vector<Entry> camera_entries() {
  std::vector<Entry> entries;
  for (const std::string& name : rig_preset_names()) {
    const RigConfig rig = rig_preset(name);
    const std::string by =
        rig.evidence == Evidence::verified ? "against theory only" : rig.evidence_by;
    std::string help = rig.title;
    for (const RigSensor& sensor : rig.sensors) {
      help += "; " + sensor.name + " " + size_text(sensor.camera.width_px, sensor.camera.height_px);
    }
    entries.push_back({name, std::string(to_string(rig.evidence)) + " (" + by + ")", help});
  }
  return entries;
}

std::vector<Entry> depth_entries() {
  std::vector<Entry> entries;
  for (const std::string& name : active_stereo_preset_names()) {
    const ActiveStereoConfig config = active_stereo_preset(name);
    std::string modes;
    for (const double columns : config.mode_columns) {
      modes += (modes.empty() ? "" : ", ") + std::to_string(static_cast<int>(columns));
    }
    entries.push_back(
        {name, "verified (against theory only; no device)",
         std::string(config.has_projector ? "active stereo" : "stereo, no projector") +
             ", depth modes of " + modes + " columns"});
  }
  return entries;
}

std::vector<Entry> range_entries() {
  std::vector<Entry> entries;
  for (const std::string& name : range_rig_preset_names()) {
    const RangeRigConfig rig = range_rig_preset(name);
    const Camera depth = depth_camera(rig);
    const CameraSensorConfig& color = rig.body.sensors.front().camera;
    entries.push_back(
        {name,
         std::string(to_string(rig.body.evidence)) + " (" +
             (rig.body.evidence == Evidence::verified ? "against theory only; no device"
                                                      : rig.body.evidence_by) +
             ")",
         rig.body.title + ", depth " + size_text(depth.width_px, depth.height_px) + "; rgb " +
             size_text(color.width_px, color.height_px)});
  }
  return entries;
}

/// To add a kind of rig, add a row.
constexpr std::array<std::vector<Entry> (*)(), 4> kRigKinds = {phone_entries, camera_entries,
                                                               depth_entries, range_entries};

}  // namespace

ExitCode command_rigs(const JobContext& context) {
  std::vector<Entry> entries;
  for (const auto& kind : kRigKinds) {
    for (const Entry& entry : kind()) entries.push_back(entry);
  }
  print(entries, context.options.json);
  return ExitCode::done;
}

namespace {

/// Options of the build, and whether they are ON.
constexpr std::pair<std::string_view, bool> kOptions[] = {{"CERES", COUSIN_WITH_CERES},
                                                          {"PCL", COUSIN_WITH_PCL}};

/// "built in", or which option is missing.
std::string method_status(const MethodRow& method) {
  for (const std::string_view wanted : method.options) {
    for (const auto& [option, is_on] : kOptions) {
      if (option == wanted && !is_on) return built(false, ("WITH_" + std::string(option)).c_str());
    }
  }
  return built(true, "");
}

}  // namespace

ExitCode command_methods(const JobContext& context) {
  std::vector<Entry> entries;
  for (const PipelineRow* pipeline : pipeline_table()) {
    for (const MethodRow& method : pipeline->methods)
      entries.push_back({std::string(pipeline->name) + "/" + std::string(method.name),
                         method_status(method), std::string(method.help)});
  }
  print(entries, context.options.json);
  return ExitCode::done;
}

namespace {

/// A row of `cousin doctor`: something that a verb wants and this machine may lack.
struct Want {
  Entry entry;
  std::string package;  ///< of Debian that brings it; empty = it is there, or no package does
};

Want found_or_missing(const char* name, const std::string& found, const char* package,
                      const char* help) {
  const bool is_missing = found.empty();
  return {{name, is_missing ? std::string("missing: apt install ") + package : found, help},
          is_missing ? package : ""};
}

/// A program that is started, never linked.
Want program(const char* name, const char* help) {
  return found_or_missing(name, find_program(name).empty() ? "" : "found", name, help);
}

/// A library that the build was made with or without.
Want library(const char* name, bool is_built, const char* option, const char* package,
             const char* help) {
  std::string status = built(is_built, option);
  if (!is_built) status += std::string("; ") + package + " is what it needs";
  return {{name, status, help}, ""};
}

std::string colmap_status() {
  const std::string version = colmap_version();
  if (!version.empty()) return "found, " + version;
  return find_program("colmap").empty() ? "" : "found, does not say its version";
}

std::vector<Want> wants() {
  const JavascriptLibraries libraries = load_javascript_libraries({});
  const bool has_real = std::filesystem::is_directory(COUSIN_REAL_DATA);
  return {
      {{"threads", std::to_string(std::thread::hardware_concurrency()),
        "cores that this machine offers"},
       ""},
      library("mujoco", COUSIN_WITH_MUJOCO, "WITH_MUJOCO", "libmujoco-dev",
              "physics: without it seeds cannot be dropped"),
      library("pcl", COUSIN_WITH_PCL, "WITH_PCL", "libpcl-dev",
              "the papers' point-cloud steps (methods paper and splats_paper)"),
      library("ceres", COUSIN_WITH_CERES, "WITH_CERES", "libceres-dev",
              "refinement of board poses, calibrate --solver ceres"),
      library("mrcal", COUSIN_WITH_MRCAL, "WITH_MRCAL", "libmrcal-dev", "calibrate --solver mrcal"),
      library("torch", COUSIN_WITH_TORCH, "WITH_TORCH", "libtorch-dev",
              "images scored by a network of yours (--lpips)"),
      found_or_missing(
          "colmap", colmap_status(), "colmap",
          "poses without a board (perceive --pipeline scene, bench sfm; splats.poses=sfm or "
          "adjusted of the methods splats and splats_paper); tested with 3.8"),
      program("blender", "scenes for others (export --format gltf or blend), bench light"),
      found_or_missing(
          "ffmpeg",
          find_program("ffmpeg").empty() || find_program("ffprobe").empty() ? "" : "found",
          "ffmpeg", "import --format video"),
      found_or_missing("vega", libraries.vega.empty() ? "" : "found", "libjs-vega",
                       "plots of the report"),
      found_or_missing("three.js", libraries.three.empty() ? "" : "found", "libjs-three",
                       "3D view of the report"),
      program("chromium", "tests of the report; no verb needs it"),
      {{"real data", has_real ? "found" : "missing",
        std::string("real captures at ") + COUSIN_REAL_DATA +
            " (CMake: COUSIN_REAL_DATA); bench real"},
       ""},
  };
}

}  // namespace

ExitCode command_doctor(const JobContext& context) {
  std::vector<Entry> entries;
  std::string packages;
  for (const Want& want : wants()) {
    entries.push_back(want.entry);
    if (!want.package.empty()) packages += " " + want.package;
  }
  print(entries, context.options.json);
  if (!context.options.json && !packages.empty())
    std::printf("All that is missing, on Debian 12: apt install%s\n", packages.c_str());
  return ExitCode::done;
}

}  // namespace cousin
