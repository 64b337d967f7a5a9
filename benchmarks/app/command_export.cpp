// export: a dataset's scenes for other programs.
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/scenes/scene_table.h"
#include "benchmarks/seeds/result_folder.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/truth_io.h"
#include "sim/render/cycles/cycles.h"
#include "sim/render/cycles/plain_scene.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

SceneFile scene_file_of(const std::string& format) {
  if (format == "blend") return SceneFile::blend;
  if (format == "gltf") return SceneFile::gltf;
  throw std::invalid_argument("--format \"" + format + "\" is not one of blend, gltf");
}

bool same_places(const Scene& a, const Scene& b) {
  if (a.instances.size() != b.instances.size()) return false;
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    const Pose &p = a.instances[i].world_from_object, &q = b.instances[i].world_from_object;
    if (a.instances[i].name != b.instances[i].name) return false;
    if ((p.translation_m - q.translation_m).norm() > 1e-9) return false;
    if (angle_rad(p.rotation * q.rotation.conjugate()) > 1e-6) return false;
  }
  return true;
}

/// The scene with its vertex colours and normals, which files do not keep: made again from the
/// configuration and seed, and compared with the files.
Scene shaded_scene(const SceneTruth& truth, const fs::path& scene_dir, ProgressPrinter& progress) {
  std::string why;
  try {
    const SceneJob job =
        scene_entry(truth.scene.name).configure({}, scene_dir / "truth" / "config.toml");
    const int index = std::stoi(scene_dir.filename().string());
    Scene made = *job.build(truth.seed, index).scene;
    if (same_places(made, truth.scene)) return made;
    why = "this version of the program makes another scene of its configuration";
  } catch (const std::exception& error) {
    why = error.what();
  }
  progress.line("warning: " + scene_dir.string() + ": without vertex colours and normals (" + why +
                ")");
  return truth.scene;
}

}  // namespace

ExitCode command_export(const JobContext& context) {
  const Options& o = context.options;
  const SceneFile format = scene_file_of(o.format);
  const fs::path dataset = o.arguments.at(0);
  const std::vector<fs::path> scenes = scene_folders(dataset);
  if (scenes.empty())
    throw std::runtime_error(dataset.string() + ": holds no scene (000000/rig.json)");
  for (const fs::path& scene_dir : scenes) {
    if (!fs::is_directory(scene_dir / "truth")) {
      throw std::runtime_error(scene_dir.string() +
                               ": there is no truth/, which holds the scene; " + o.format +
                               " needs a simulated dataset with its truth");
    }
  }
  CyclesConfig cycles;
  if (!has_cycles(cycles.program)) {
    throw std::runtime_error("--format " + o.format + " is written by Blender, and \"" +
                             cycles.program +
                             "\" cannot be started: install Blender 3.4 (apt install blender)");
  }
  const fs::path out =
      o.out.empty() ? fs::path(dataset.string() + "_" + o.format) : fs::path(o.out);
  require_writable(out);
  nlohmann::json files = nlohmann::json::array();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::string id = scenes[i].filename().string();
    context.progress("export " + id, static_cast<int>(i), static_cast<int>(scenes.size()));
    const SceneTruth truth = read_truth(scenes[i]);
    if (truth.views.empty())
      throw std::runtime_error((scenes[i] / "truth/camera.json").string() + ": has no view");
    const PlainScene plain =
        plain_scene(shaded_scene(truth, scenes[i], context.progress), truth.views.front());
    for (const std::string& change : plain.changes) context.progress.line(id + ": " + change);
    const fs::path file = out / (id + (format == SceneFile::blend ? ".blend" : ".glb"));
    cycles.folder = out / ("." + id + ".part");
    save_with_blender(plain.scene, plain.view, cycles, format, file);
    fs::remove_all(cycles.folder);
    files.push_back(file.string());
    context.progress.line(file.string());
  }
  if (o.json) std::printf("%s\n", nlohmann::json{{"files", files}}.dump(2).c_str());
  return ExitCode::done;
}

}  // namespace cousin
