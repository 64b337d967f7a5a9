#include "sim/render/cycles/cycles.h"

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/imaging/image_io.h"
#include "sim/process/program_run.h"
#include "sim/render/cycles/cycles_scene.h"
#include "sim/render/cycles/cycles_script.h"

namespace cousin {
namespace {

using nlohmann::json;

void write_text(const std::filesystem::path& file, std::string_view text) {
  std::ofstream out(file, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

void run_blender(const CyclesConfig& config, const json& spec) {
  write_text(config.folder / "scene.json",
             spec.dump(-1, ' ', false, json::error_handler_t::replace));
  write_text(config.folder / "cycles_render.py", kCyclesScript);
  const std::filesystem::path log = config.folder / "blender.log";
  // Blender looks for relative names where the shell was started.
  const std::filesystem::path folder = std::filesystem::absolute(config.folder);
  const ProgramOutcome outcome = run_program(
      {.words = {config.program, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1",
                 "-P", (folder / "cycles_render.py").string(), "--", folder.string()},
       .log = log,
       .time_limit_s = config.time_limit_s});
  if (outcome.end == ProgramEnd::not_started)
    throw std::runtime_error("Cycles: " + outcome.reason + "; is it installed?");
  if (!succeeded(outcome)) {
    throw std::runtime_error("Cycles: " + outcome.reason + "; " + log.string() + " ends with" +
                             last_lines(log));
  }
}

CyclesImage read_run(const std::filesystem::path& file, const Scene& scene, const TrueView& view) {
  const auto c = read_exr_channels(
      file, {"view.Combined.R", "view.Combined.G", "view.Combined.B", "view.Depth.Z",
             "view.Normal.X", "view.Normal.Y", "view.Normal.Z", "view.IndexOB.X"});
  const int width = view.camera.width_px, height = view.camera.height_px;
  if (c[0].width() != width || c[0].height() != height) {
    throw std::runtime_error(file.string() + ": " + std::to_string(c[0].width()) + " x " +
                             std::to_string(c[0].height()) + " pixels, not " +
                             std::to_string(width) + " x " + std::to_string(height));
  }
  const Eigen::Matrix3f camera_from_world =
      view.camera_from_world.rotation.toRotationMatrix().cast<float>();
  CyclesImage image;
  image.radiance = Image<Rgbf>(width, height);
  image.depth_m = Image<float>(width, height, std::numeric_limits<float>::quiet_NaN());
  image.normal = Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero());
  image.instance = Image<std::int32_t>(width, height, -1);
  for (std::size_t i = 0; i < image.radiance.size(); ++i) {
    const auto at = [&](std::size_t k) { return c[k].data()[i]; };
    image.radiance.data()[i] = {at(0), at(1), at(2)};
    const float index = at(7);
    if (!(index >= 0.5F) || index > static_cast<float>(scene.instances.size())) continue;
    image.instance.data()[i] = scene.instances[static_cast<std::size_t>(std::lround(index)) - 1].id;
    image.depth_m.data()[i] = at(3);
    image.normal.data()[i] = camera_from_world * Eigen::Vector3f(at(4), at(5), at(6));
  }
  return image;
}

}  // namespace

bool has_cycles(const std::string& program) {
  return succeeded(
      run_program({.words = {program, "--version"}, .log = "/dev/null", .time_limit_s = 60}));
}

std::vector<CyclesImage> render_with_cycles(const Scene& scene, const TrueView& view,
                                            const CyclesConfig& config,
                                            const std::vector<CyclesRun>& runs) {
  json spec = write_cycles_scene(scene, view, config, config.folder);
  spec["runs"] = json::array();
  for (const CyclesRun& run : runs) {
    spec["runs"].push_back({{"samples", run.samples},
                            {"seed", run.seed},
                            {"noise_threshold", run.noise_threshold},
                            {"filter_width_px", run.filter_width_px}});
  }
  run_blender(config, spec);
  std::ifstream in(config.folder / "times.json");
  const json times = json::parse(in, nullptr, false);
  if (times.is_discarded() || !times.contains("seconds") ||
      times["seconds"].size() != runs.size()) {
    throw std::runtime_error("Cycles: " + (config.folder / "times.json").string() +
                             " does not tell the seconds of each run");
  }
  std::vector<CyclesImage> images;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    images.push_back(read_run(config.folder / ("run_" + std::to_string(i) + ".exr"), scene, view));
    images.back().seconds = times["seconds"][i].get<double>();
  }
  return images;
}

void save_with_blender(const Scene& scene, const TrueView& view, const CyclesConfig& config,
                       SceneFile format, const std::filesystem::path& file) {
  json spec = write_cycles_scene(scene, view, config, config.folder);
  spec["runs"] = json::array();
  const bool is_blend = format == SceneFile::blend;
  const std::string name = is_blend ? "scene.blend" : "scene.glb";
  spec[is_blend ? "blend" : "gltf"] = name;
  run_blender(config, spec);
  const std::filesystem::path made = config.folder / name;
  if (!std::filesystem::exists(made))
    throw std::runtime_error("Cycles: \"" + config.program + "\" wrote no " + made.string());
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  std::filesystem::copy_file(made, file, std::filesystem::copy_options::overwrite_existing);
}

}  // namespace cousin
