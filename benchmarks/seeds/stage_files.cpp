#include "benchmarks/seeds/stage_files.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "benchmarks/seeds/truth_stages.h"
#include "perception/splats/splat_ply.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/seam_io.h"
#include "sim/process/program_run.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

void call_program(const StageSource& source, const fs::path& input, const fs::path& output) {
  const ProgramOutcome outcome =
      run_program({.words = {source.path.string(), input.string(), output.string()},
                   .time_limit_s = source.time_limit_s});
  if (succeeded(outcome)) return;
  const bool is_late = outcome.end == ProgramEnd::timed_out;
  throw std::runtime_error(outcome.reason + (is_late ? " (--stage-time-limit)" : ""));
}

/// The input of a stage's program could not be written: a full disk, not the program's fault.
class StageInputError : public std::runtime_error {
 public:
  using runtime_error::runtime_error;
};

/// A scratch folder with input/, the capture and the seams before a stage, and an empty output/.
std::unique_ptr<ScratchFolder> stage_folder(const std::string& stage, const Capture& capture,
                                            const SeedsEstimate& so_far, int scene_index) {
  try {
    auto folder = std::make_unique<ScratchFolder>("cousin-stage");
    const fs::path input = folder->path() / "input";
    write_capture(input, capture);
    for (const std::string& earlier : seeds_stage_names()) {
      if (earlier == stage) break;
      write_seam(input, earlier, so_far, scene_index);
    }
    fs::create_directories(folder->path() / "output");
    return folder;
  } catch (const std::runtime_error& error) {
    throw StageInputError("the input of its program could not be written: " +
                          std::string(error.what()));
  }
}

/// A stage that reads its seam with `read(folder, capture)` from files, or from what a program
/// makes of the capture and earlier seams.
template <class Read, class Value = std::invoke_result_t<Read, const fs::path&, const Capture&>>
std::function<Value(const Capture&, const SeedsEstimate&)> sourced(const StageSource& source,
                                                                   int scene_index, Read read) {
  if (source.kind == StageSource::Kind::directory) {
    return [source, scene_index, read](const Capture& capture, const SeedsEstimate&) {
      const fs::path below = source.path / scene_id(scene_index);
      return read(fs::is_directory(below) ? below : source.path, capture);
    };
  }
  return [source, scene_index, read](const Capture& capture, const SeedsEstimate& so_far) {
    const auto folder = stage_folder(source.stage, capture, so_far, scene_index);
    const fs::path output = folder->path() / "output";
    call_program(source, folder->path() / "input", output);
    return read(output, capture);
  };
}

/// Images that masks may be of: the first sensor's.
MaskImages images_of(const Capture& capture, int scene_index) {
  MaskImages images;
  images.scene = scene_index;
  for (const Frame& frame : capture.frames) {
    const Camera& camera = frame.sensors.front().reported;
    images.size_px[frame.id] = {camera.width_px, camera.height_px};
  }
  return images;
}

constexpr const char* kSplatsFile = "splats.ply";  ///< the reference's layout

constexpr const char* kBlendedFile = "splats_blended.csv";

/// How many of the views trained on each Gaussian gives colour to, in the order of the model's
/// file. No file where that is not known.
void write_blended(const fs::path& dir, const SplatModel& model) {
  remove_own(dir / kBlendedFile);  // of another model
  if (model.views_seen.empty() || model.views_seen.size() != model.splats.size()) return;
  std::string text = "views\n";
  for (const int views : model.views_seen) text += std::to_string(views) + "\n";
  write_file(dir / kBlendedFile, text);
}

/// The model, having told `warn` of rows that are no Gaussian.
SplatModel read_splats(const fs::path& dir, const Warn& warn) {
  SplatFile file = read_splat_ply(dir / kSplatsFile);
  const std::size_t left_out = file.not_finite + file.zero_rotations;
  if (warn && left_out > 0) {
    warn((dir / kSplatsFile).string() + ": " + std::to_string(left_out) + " of " +
         std::to_string(left_out + file.model.splats.size()) +
         " rows are left out: " + std::to_string(file.not_finite) + " with NaN or infinity, " +
         std::to_string(file.zero_rotations) + " with a rotation of length zero");
  }
  return std::move(file.model);
}

/// Removes a folder's files that are named by six digits and `ending`, and the folder if that was
/// all: it may be somebody's own.
void remove_numbered(const fs::path& folder, const std::string& ending) {
  if (fs::symlink_status(folder).type() != fs::file_type::directory) return;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool is_numbered = name.find_first_not_of("0123456789") == 6;
    if (is_numbered && name.ends_with(ending)) files.push_back(entry.path());
  }
  for (const fs::path& file : files) remove_own(file);
  std::error_code not_empty;
  fs::remove(folder, not_empty);
}

}  // namespace

std::string scene_id(int scene_index) {
  char text[16];
  std::snprintf(text, sizeof text, "%06d", scene_index);
  return text;
}

std::string to_text(const StageSource& source) {
  return (source.kind == StageSource::Kind::program ? "exec:" : "dir:") + source.path.string();
}

StageSource parse_stage_source(const std::string& text, double time_limit_s) {
  const auto fail = [&](const std::string& why) {
    throw std::invalid_argument("--stage \"" + text + "\": " + why +
                                "; write NAME=dir:PATH or NAME=exec:PROGRAM");
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) fail("there is no '='");
  StageSource source;
  source.time_limit_s = time_limit_s;
  source.stage = text.substr(0, equals);
  bool known = false;
  std::string names;
  for (const std::string& stage : seeds_stage_names()) {
    known = known || stage == source.stage;
    names += (names.empty() ? "" : ", ") + stage;
  }
  if (!known) fail("stage \"" + source.stage + "\" is not one of " + names);
  const std::string rest = text.substr(equals + 1);
  if (rest.starts_with("dir:")) {
    source.path = rest.substr(4);
    if (!fs::is_directory(source.path))
      fail("folder \"" + source.path.string() + "\" does not exist");
  } else if (rest.starts_with("exec:")) {
    source.kind = StageSource::Kind::program;
    source.path = rest.substr(5);
    if (source.path.empty()) fail("no program is named");
    if (find_program(source.path.string()).empty()) {
      fail("program \"" + source.path.string() + "\" does not exist or may not be executed");
    }
  } else {
    fail("the source is neither dir: nor exec:");
  }
  return source;
}

bool replaces(const std::vector<StageSource>& sources, std::string_view stage) {
  return std::any_of(sources.begin(), sources.end(),
                     [&](const StageSource& source) { return source.stage == stage; });
}

bool is_fault_of_input(const StageError& error, const std::vector<std::string>& stages) {
  const std::string name = error.stage + "=";
  const auto given = std::find_if(stages.rbegin(), stages.rend(),
                                  [&](const std::string& text) { return text.starts_with(name); });
  if (given == stages.rend()) return false;
  if (given->starts_with(name + "dir:")) return true;
  try {
    std::rethrow_if_nested(error);
  } catch (const StageInputError&) {
    return true;
  } catch (const std::exception&) {
  }
  return false;
}

SeedsStages with_stage_sources(SeedsStages base, const std::vector<StageSource>& sources,
                               int scene_index, const Warn& warn) {
  const auto splats = [warn](const fs::path& dir, const Capture&) {
    return read_splats(dir, warn);
  };
  const auto masks = [scene_index](const fs::path& dir, const Capture& capture) {
    return read_silhouettes(dir, images_of(capture, scene_index));
  };
  for (const StageSource& source : sources) {
    const auto files = [&](auto read) {
      return sourced(source, scene_index,
                     [read](const fs::path& dir, const Capture&) { return read(dir); });
    };
    if (source.stage == "corners") base.corners = files(read_corners);
    if (source.stage == "poses") base.poses = files(read_poses);
    if (source.stage == "splats") base.splats = sourced(source, scene_index, splats);
    if (source.stage == "depth") base.depth = files(read_depths);
    if (source.stage == "cloud") base.cloud = files(read_cloud);
    if (source.stage == "clusters") base.clusters = files(read_clusters);
    if (source.stage == "masks") base.masks = sourced(source, scene_index, masks);
    if (source.stage == "surfaces") base.surfaces = files(read_surfaces);
    if (source.stage == "traits") base.traits = files(read_traits);
  }
  return base;
}

std::vector<std::string> estimate_names(const fs::path& scene) {
  std::vector<std::string> names;
  for (const char* name : {"config.toml",
                           "corners.json",
                           "poses.json",
                           kSplatsFile,
                           kBlendedFile,
                           "depth/frames.json",
                           "depth/######.exr",
                           "depth_sigma/######.exr",
                           "depth_normal/######.exr",
                           "cloud.ply",
                           "clusters.ply",
                           "masks.json",
                           "surfaces.json",
                           "meshes/######*.ply",
                           "traits.json",
                           "timings.json",
                           "scores.csv",
                           "splats_seen.csv",
                           "exposures.csv",
                           "pictures/######.png",
                           "splats.unfinished",
                           "splats.unfinished.colmap"})
    names.push_back((scene / name).generic_string());
  return names;
}

void remove_seam(const fs::path& dir, const std::string& stage) {
  if (stage == "corners") remove_own(dir / "corners.json");
  if (stage == "poses") remove_own(dir / "poses.json");
  if (stage == "splats") {
    remove_own(dir / kSplatsFile);
    remove_own(dir / kBlendedFile);
  }
  if (stage == "depth") {
    remove_own(dir / "depth" / "frames.json");
    remove_numbered(dir / "depth", ".exr");
    remove_numbered(dir / "depth_sigma", ".exr");
    remove_numbered(dir / "depth_normal", ".exr");
  }
  if (stage == "cloud") remove_own(dir / "cloud.ply");
  if (stage == "clusters") remove_own(dir / "clusters.ply");
  if (stage == "masks") remove_own(dir / "masks.json");
  if (stage == "surfaces") {
    remove_own(dir / "surfaces.json");
    remove_numbered(dir / "meshes", ".ply");
  }
  if (stage == "traits") remove_own(dir / "traits.json");
}

void write_seam(const fs::path& dir, const std::string& stage, const SeedsEstimate& estimate,
                int scene_index) {
  if (stage == "corners") write_corners(dir, estimate.corners);
  if (stage == "poses") write_poses(dir, estimate.poses);
  if (stage == "splats") {
    write_splat_ply(dir / kSplatsFile, estimate.splats);
    write_blended(dir, estimate.splats);
  }
  if (stage == "depth") write_depths(dir, estimate.depths);
  if (stage == "cloud") write_cloud(dir, estimate.cloud);
  if (stage == "clusters") write_clusters(dir, estimate.clusters);
  if (stage == "masks" && !estimate.silhouettes.empty()) {
    write_silhouettes(dir, estimate.silhouettes, scene_index);
  }
  if (stage == "surfaces") write_surfaces(dir, estimate.surfaces);
  if (stage == "traits") write_traits(dir, estimate.traits);
}

}  // namespace cousin
