// render and verify: datasets on disk.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/render_plan.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/scene_table.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/loop/stage_files.h"
#include "benchmarks/loop/truth_choice.h"
#include "benchmarks/study/shard.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/categories.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/output_folder.h"
#include "sim/dataset/seam_io.h"
#include "sim/dataset/truth_format.h"
#include "sim/dataset/truth_io.h"
#include "sim/dataset/verify_progress.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr const char* kOfAnotherRun =
    " belongs to another configuration, seed or choice of truth or of its format, or to another "
    "version of the program; choose another --out";

using OwnFiles = std::vector<std::pair<std::string, std::string>>;

/// Files that manifests in the folder list, those of shards too.
/// @throws std::invalid_argument naming a manifest of another configuration
OwnFiles listed_by_manifests(const fs::path& dataset, const std::string& hash) {
  OwnFiles own;
  if (!fs::is_directory(dataset)) return own;
  for (const auto& entry : fs::directory_iterator(dataset)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("manifest.") || !name.ends_with(".json") || entry.is_symlink()) continue;
    Manifest manifest;
    try {
      manifest = read_manifest_file(entry.path());
    } catch (const std::runtime_error&) {
      continue;  // no manifest of ours: the check of the folder names it
    }
    if (manifest.config_hash != hash)
      throw std::invalid_argument(entry.path().string() + kOfAnotherRun + " (SHA-256 " +
                                  manifest.config_hash + " there, " + hash + " here)");
    own.insert(own.end(), manifest.files.begin(), manifest.files.end());
    own.emplace_back(name, sha256_hex_of_file(entry.path()));
  }
  if (!own.empty()) own.emplace_back("timings.json", "*");  // beside the hashes
  return own;
}

FolderClaim render_claim(const std::string& hash) {
  return {.verb = "render",
          .version = COUSIN_VERSION,
          .config = hash,
          .names = {"######", kCategoriesFile, "manifest.json", "manifest.*.json", "timings.json"},
          .other_config = FolderClaim::OtherConfig::refuse,
          .sharing = FolderClaim::Sharing::shards};
}

/// Files that the manifest lists: this command wrote them, and they are there.
std::vector<fs::path> dataset_files(const fs::path& dataset, const OutputFolder& folder) {
  std::vector<fs::path> files;
  for (const std::string& file : folder.files()) {
    if (fs::is_regular_file(fs::symlink_status(dataset / file))) files.emplace_back(file);
  }
  return files;
}

/// What a dataset holds of each scene.
struct Contents {
  Streams streams;
  TruthNeeds truth;
  TruthFormat format = TruthFormat::npy;
};

/// Whether images are written that differ from one format to another.
bool has_float_images(const TruthNeeds& t) {
  return t.depth || t.normal || t.position || t.coverage || t.shares || t.flow || t.disparity ||
         t.noise_free_depth;
}

/// What the folder belongs to: the program's version, configuration and seed, the truth where it is
/// not the default, and the format of its images where it is not EXR.
std::string owner_hash(const std::string& config_hash, const Contents& contents) {
  const std::string names = to_string(contents.truth);
  const bool is_exr = contents.format == TruthFormat::exr || !has_float_images(contents.truth);
  return sha256_hex(std::string(COUSIN_VERSION) + "\n" + config_hash +
                    (names == "visibility" ? "" : "\ntruth = " + names) +
                    (is_exr ? "" : "\ntruth_format = " + to_string(contents.format)) + "\n");
}

/// Files below the scene's folder that come with one frame: its images and what is true of its
/// depth.
std::vector<fs::path> frame_files(const Simulation& built, int frame, const Contents& contents) {
  Capture one = built.capture_header();
  one.frames.push_back(built.rig().outline(frame, contents.streams));
  std::vector<fs::path> files = frame_image_files(one, 0);
  char name[16];
  std::snprintf(name, sizeof name, "%06d", frame);
  if (contents.truth.noise_free_depth) {
    const std::string stem = std::string("truth/noise_free_depth/") + name;
    for (const std::string& file : depth_files(stem, contents.format)) files.emplace_back(file);
  }
  if (contents.truth.invalid_reason)
    files.push_back(fs::path("truth/invalid_reason") / (std::string(name) + ".png"));
  return files;
}

/// Frames of one scene whose images are not there yet.
std::vector<int> absent_frames(const Simulation& built, const fs::path& scene_dir, int first,
                               int end, const Contents& contents) {
  std::vector<int> absent;
  for (int frame = first; frame < end; ++frame) {
    const std::vector<fs::path> files = frame_files(built, frame, contents);
    const auto is_there = [&](const fs::path& file) { return fs::exists(scene_dir / file); };
    if (!std::all_of(files.begin(), files.end(), is_there)) absent.push_back(frame);
  }
  return absent;
}

/// Images of the frames of one scene that are not there yet; the files are final or absent.
void render_frames(const Simulation& built, const fs::path& scene_dir, int first, int end,
                   const Contents& contents, ProgressPrinter& progress) {
  const std::vector<int> absent = absent_frames(built, scene_dir, first, end, contents);
  const int views = end - first, there = views - static_cast<int>(absent.size());
  const std::string scene = scene_dir.filename().string();
  if (there > 0)
    progress.line("scene " + scene + ": " + std::to_string(there) + " of " + std::to_string(views) +
                  " views are there already");
  int done = there;
  for (const int frame : absent) {
    progress("render " + scene, done++, views);
    RigFrame taken = built.take(frame, contents.streams);
    Capture one = built.capture_header();
    one.frames.push_back(std::move(taken.frame));
    write_frame_images(scene_dir, one, 0);
    TruthImages of_depth;
    if (contents.truth.noise_free_depth)
      of_depth.noise_free_depth_m = std::move(taken.noise_free_depth_m);
    if (contents.truth.invalid_reason) of_depth.invalid_reason = std::move(taken.invalid_reason);
    write_truth_images(scene_dir, built.scene(), frame, of_depth, contents.format);
  }
}

/// Truth images of one sensor, each written as it is made: those of all views together need
/// gigabytes. What write_truth needs of them is kept.
std::vector<TruthImages> write_sensor_truth(const Simulation& built, const fs::path& scene_dir,
                                            const Contents& contents, std::size_t sensor) {
  const std::vector<TrueView>& views = built.rig().views().at(sensor).views;
  const std::string name = sensor == 0 ? "" : built.rig().views()[sensor].sensor;
  std::vector<TruthImages> kept(views.size());
  for_each_frame(views.size(), [&](std::size_t i) {
    TruthImages images = built.truth(views[i].frame, contents.truth, sensor);
    write_truth_images(scene_dir, built.scene(), views[i].frame, images, contents.format, name);
    kept[i].visibility = std::move(images.visibility);
    kept[i].keypoints = std::move(images.keypoints);
    kept[i].leaf_areas = std::move(images.leaf_areas);
  });
  return kept;
}

/// Index and truth of a scene: both are pure functions of configuration and seed, whichever shard
/// rendered the images.
void write_index(const Simulation& built, const fs::path& scene_dir, const Contents& contents) {
  Capture capture = built.capture_header();
  SceneTruth truth = built.scene_truth();
  // Pixels stand for the images: the index names them, whichever shard writes them and when.
  for (const TrueView& view : built.views())
    capture.frames.push_back(built.rig().outline(view.frame, contents.streams));
  if (to_string(contents.truth) != "none") {
    truth.images = write_sensor_truth(built, scene_dir, contents, 0);
    for (const std::size_t s : other_true_sensors(built.rig(), contents.streams, contents.truth))
      truth.other_sensors.at(s - 1).images = write_sensor_truth(built, scene_dir, contents, s);
  }
  write_capture_index(scene_dir, capture);
  write_truth(scene_dir, truth);
}

/// Files of a scene's index and truth, but those that come with a frame.
std::vector<fs::path> index_files(const fs::path& scene_dir) {
  std::vector<fs::path> files = {"rig.json", "scene_camera.json"};
  for (const auto& entry : fs::recursive_directory_iterator(scene_dir / "truth")) {
    const std::string folder = entry.path().parent_path().filename();
    if (folder == "noise_free_depth" || folder == "invalid_reason") continue;
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), scene_dir));
  }
  return files;
}

RunConfig render_config(const Options& o, const SceneEntry& entry) {
  std::vector<KeyOption> keys;
  if (o.frames > 0) keys.push_back({"--frames", "views", std::to_string(o.frames)});
  if (!o.streams.empty()) keys.push_back({"--streams", "streams", o.streams});
  return read_config(
      o, keys, [&] { return run_config(built_row(entry), assignments_of(o, keys), o.config); });
}

Contents contents_of(const Options& o, const SceneEntry& entry, const RunConfig& config) {
  Contents contents;
  contents.streams = planned_streams(config);
  contents.truth = o.truth.empty() ? default_truth(contents.streams)
                                   : truth_needs_from_string(
                                         o.truth, truth_there_is(config.rig, contents.streams));
  if (o.truth.empty() && entry.text.has_points) contents.truth.keypoints = true;
  if (!o.truth_for.empty()) contents.truth = truth_needs_for(o.truth_for, contents.truth);
  contents.format = truth_format_from_string(o.truth_format);
  return contents;
}

/// Adds the files below the dataset that a shard writes of a scene's frames.
void add_shard_files(const Simulation& built, const fs::path& scene_dir, int from, int to,
                     const Contents& contents, std::vector<fs::path>& written) {
  const auto add = [&](const std::vector<fs::path>& files) {
    for (const fs::path& file : files) written.push_back(scene_dir.filename() / file);
  };
  for (int frame = from; frame < to; ++frame) add(frame_files(built, frame, contents));
  if (from == 0) add(index_files(scene_dir));
}

/// The shard's manifest, or the dataset's where there are no shards.
/// @return whether the dataset is complete
bool write_manifests(const fs::path& dataset, const Manifest& header, const Shard& shard,
                     const std::vector<fs::path>& written, const OutputFolder& folder) {
  if (shard.count > 1) write_shard_manifest(dataset, header, shard.index, shard.count, written);
  const bool is_complete = shard.count <= 1 || fs::exists(dataset / "manifest.json");
  if (shard.count <= 1) write_manifest(dataset, header, dataset_files(dataset, folder));
  return is_complete;
}

void print_dataset(const fs::path& dataset, bool is_complete,
                   const std::vector<StageTiming>& timings,
                   const std::vector<std::string>& warnings) {
  nlohmann::json seconds = nlohmann::json::object();
  for (const StageTiming& timing : timings) seconds[timing.stage] = timing.wall_s;
  print_json({{"dataset", dataset.string()},
              {"complete", is_complete},
              {"seconds", seconds},
              {"warnings", warnings}});
}

}  // namespace

ExitCode command_render(const JobContext& context) {
  const Options& o = context.options;
  const SceneEntry& entry = scene_entry(o.arguments.at(0));
  const RunConfig config = render_config(o, entry);
  if (o.keys) {
    std::printf("%s", keys_text(config).c_str());
    return ExitCode::done;
  }
  const Shard shard = parse_shard(o.shard);
  const fs::path dataset =
      o.out.empty() ? fs::path("out") / (entry.name() + "_dataset") : fs::path(o.out);
  const Contents contents = contents_of(o, entry, config);
  const int frames = config.scene.views();
  const auto [first, end] = shard_range(shard, o.scenes * frames);
  if (o.plan) {
    const RenderPlan plan = render_plan(config, contents.truth, o.scenes, end - first, dataset);
    std::printf("%s", (o.json ? to_json(plan) : describe(plan)).c_str());
    return ExitCode::done;
  }
  const std::string hash = owner_hash(config_hash(config, o.seed), contents);
  require_writable(dataset);
  FolderClaim claim = render_claim(hash);
  check_output_folder(dataset, claim, listed_by_manifests(dataset, hash));
  claim.check_bytes = false;  // they have been, now
  std::optional<OutputFolder> folder;
  const auto take_folder = [&] {
    if (!folder) folder.emplace(dataset, claim, listed_by_manifests(dataset, hash));
  };
  const std::vector<std::string> warnings = user_mesh_warnings(config);
  for (const std::string& warning : warnings) context.progress.line("warning: " + warning);

  std::vector<fs::path> written;
  std::vector<StageTiming> timings;
  for (int scene = first / frames; scene * frames < end; ++scene) {
    const StageClock build_clock("build " + scene_id(scene));
    const Simulation built(config, o.seed, scene);
    timings.push_back(build_clock.finish());
    const StageClock clock("render " + scene_id(scene));
    take_folder();  // not before: a scene that cannot be built leaves no trace
    const fs::path scene_dir = dataset / scene_id(scene);
    const int from = std::max(0, first - scene * frames);
    const int to = std::min(frames, end - scene * frames);
    render_frames(built, scene_dir, from, to, contents, context.progress);
    // The shard that renders a scene's first frame writes its index and truth.
    if (from == 0) write_index(built, scene_dir, contents);
    if (shard.count > 1) add_shard_files(built, scene_dir, from, to, contents, written);
    timings.push_back(clock.finish());
  }
  take_folder();  // a shard may have nothing to render
  if (const auto names = specimen_categories(config.scene); first == 0 && !names.empty()) {
    write_categories(dataset, names);
    written.emplace_back(kCategoriesFile);
  }
  Manifest header;
  header.program_version = COUSIN_VERSION;
  header.config_hash = hash;
  header.pipeline = entry.name();
  const bool complete = write_manifests(dataset, header, shard, written, *folder);
  write_timings(dataset, timings);
  if (complete) folder->release();  // last: the folder is never without an owner
  if (o.json) print_dataset(dataset, complete, timings, warnings);
  context.progress.line((complete ? "dataset: " : "shard of dataset: ") + dataset.string());
  return ExitCode::done;
}

ExitCode command_verify(const JobContext& context) {
  const fs::path dataset = context.options.arguments.at(0);
  const std::vector<VerifyProblem> problems =
      verify(dataset, [&](int done, int total) { context.progress("verify", done, total); });
  if (context.options.json) {
    nlohmann::json rows = nlohmann::json::array();
    for (const VerifyProblem& problem : problems)
      rows.push_back({{"path", problem.path}, {"what", problem.what}});
    print_json({{"dataset", dataset.string()}, {"problems", rows}});
  } else {
    for (const VerifyProblem& problem : problems) {
      print_result_line(problem.path + ": " + problem.what);
    }
    if (problems.empty()) print_result_line(dataset.string() + ": no problems");
  }
  return problems.empty() ? ExitCode::done : ExitCode::bad_input;
}

}  // namespace cousin
