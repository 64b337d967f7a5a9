// score: from a dataset and estimates, ours or anybody's, to numbers.
#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/dataset_check.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/perceive_places.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/score_boxes.h"
#include "benchmarks/loop/score_depths.h"
#include "benchmarks/loop/score_views.h"
#include "benchmarks/study/shard.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/links.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/output_folder.h"
#include "sim/dataset/seam_io.h"
#include "sim/dataset/truth_io.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// What the files of an estimate are scored as.
enum class ScoredAs {
  traits,  ///< of specimens, boxes or plants
  scene,   ///< a scene as a whole
  depths   ///< depth images alone
};

/// An estimate without traits.json told no specimens apart; one with what only chains write that do
/// was left before its end.
ScoredAs scored_as(const fs::path& estimate_dir) {
  const auto has = [&](std::initializer_list<const char*> files) {
    return std::any_of(files.begin(), files.end(),
                       [&](const char* file) { return fs::exists(estimate_dir / file); });
  };
  if (has({"traits.json", "corners.json", "clusters.ply", "masks.json", "boxes.json",
           "keypoints.json", "fits.json", "tracks.json"}))
    return ScoredAs::traits;
  if (has({"poses.json", "surfaces.json", "splats.ply"})) return ScoredAs::scene;
  if (has({"depth"})) return ScoredAs::depths;
  return has({"cloud.ply"}) ? ScoredAs::scene : ScoredAs::traits;
}

/// Colour images of all sensors.
DetectionImages images_of(const fs::path& dir, const SceneTruth& truth) {
  DetectionImages images;
  images.scene = scene_index_of(dir);
  const auto add = [&](const std::vector<TrueView>& views, int sensor) {
    for (const TrueView& view : views)
      images.size_px[{view.frame, sensor}] = {view.camera.width_px, view.camera.height_px};
  };
  add(truth.views, 0);
  for (std::size_t s = 0; s < truth.other_sensors.size(); ++s)
    add(truth.other_sensors[s].views, static_cast<int>(s) + 1);
  return images;
}

/// The seams that scores are of.
Estimate read_estimate(const fs::path& dir, const SceneTruth& truth, ScoredAs as) {
  Estimate estimate;
  if (as == ScoredAs::traits) estimate.traits = read_traits(dir);
  if (as == ScoredAs::depths) estimate.depths = read_depths(dir);
  if (as == ScoredAs::scene && fs::exists(dir / "cloud.ply")) estimate.cloud = read_cloud(dir);
  if (fs::exists(dir / "poses.json")) estimate.poses = read_poses(dir);
  if (fs::exists(dir / "clusters.ply")) estimate.clusters = read_clusters(dir);
  if (fs::exists(dir / "surfaces.json")) estimate.surfaces = read_surfaces(dir);
  if (fs::exists(dir / "masks.json")) {
    MaskImages images;
    images.scene = scene_index_of(dir);
    for (const TrueView& view : truth.views)
      images.size_px[view.frame] = {view.camera.width_px, view.camera.height_px};
    estimate.silhouettes = read_silhouettes(dir, images);
  }
  if (fs::exists(dir / "boxes.json")) estimate.boxes = read_boxes(dir, images_of(dir, truth));
  if (fs::exists(dir / "fits.json")) estimate.fits = read_fits(dir);
  if (fs::exists(dir / "timings.json")) estimate.timings = read_timings(dir);
  return estimate;
}

/// A file, or a folder of text files without one of a scene: what a detector writes.
bool is_detections(const fs::path& path, const fs::path& dataset) {
  if (fs::is_regular_file(path)) return true;
  if (!fs::is_directory(path)) return path.extension() == ".json";
  for (const fs::path& scene : scene_folders(dataset)) {
    if (fs::exists(path / scene.filename())) return false;
  }
  if (fs::is_directory(path / "labels")) return true;
  for (const auto& entry : fs::directory_iterator(path)) {
    if (entry.path().extension() == ".txt") return true;
  }
  return false;
}

void check_alignment(const Options& o, const fs::path& estimate_dir) {
  if (!o.align) return;
  if (scored_as(estimate_dir) == ScoredAs::depths)
    throw std::invalid_argument("--align: " + estimate_dir.string() +
                                " holds depth alone, which is metres before each camera");
  if (!fs::exists(estimate_dir / "traits.json")) return;
  throw std::invalid_argument("--align: " + estimate_dir.string() +
                              " has traits.json, whose lengths are metres in the board's frame");
}

ScoreFile score_scene(const Options& o, const SceneTruth& truth, const fs::path& estimate_dir,
                      const SeedsScoreLabels& labels, ProgressPrinter& progress) {
  const ScoredAs as = scored_as(estimate_dir);
  const Estimate estimate = read_estimate(estimate_dir, truth, as);
  ScoreFile file;
  if (as == ScoredAs::depths)
    progress.line(estimate_dir.string() + ": depth alone: scored against the first surfaces" +
                  (fs::exists(estimate_dir / "cloud.ply") ? "; cloud.ply is not scored" : ""));
  if (as == ScoredAs::scene)
    progress.line(estimate_dir.string() + ": no traits.json: scored as a scene as a whole");
  try {
    if (as == ScoredAs::depths) {
      file.scores = score_depths(truth, estimate, labels);
    } else if (as == ScoredAs::scene) {
      file.scores =
          score_views(truth, estimate, o.align ? PoseAlignment::similarity : PoseAlignment::none,
                      fs::exists(estimate_dir / "cloud.ply"), labelled_row(labels));
    } else {
      SeedsScores scores = score_estimate(traits_of_estimate(estimate), truth, estimate, labels);
      file.scores = std::move(scores.rows);
      file.specimens = std::move(scores.specimens);
    }
  } catch (const std::invalid_argument& error) {  // of what the files hold
    throw std::runtime_error(estimate_dir.string() + ": " + error.what());
  }
  return file;
}

ScoreFile file_of_dataset(const fs::path& dataset, const std::optional<Manifest>& manifest) {
  ScoreFile file;
  file.header.program_version = COUSIN_VERSION;
  file.header.machine = machine_text();
  if (manifest) {
    file.header.dataset_hash = sha256_hex_of_file(dataset / "manifest.json");
    file.header.config_hash = manifest->config_hash;
  }
  return file;
}

/// How many scenes were scored, and why others could not be.
struct ScoredScenes {
  int scored = 0;
  std::vector<std::string> failures;
};

ScoredScenes add_scene_scores(const JobContext& context, const std::optional<Manifest>& manifest,
                              SeedsScoreLabels& labels, ScoreFile& file) {
  const Options& o = context.options;
  const fs::path dataset = o.arguments.at(0);
  const fs::path estimates = o.arguments.at(1);
  ScoredScenes result;
  const std::vector<fs::path> scenes = scene_folders(dataset);
  refuse_links_out(dataset, "manifest.json");
  for (const fs::path& scene_dir : scenes) {
    refuse_links_out(dataset, scene_dir.filename());
    refuse_links_out(estimates, scene_dir.filename());
  }
  for (const fs::path& scene_dir : scenes) check_alignment(o, estimates / scene_dir.filename());
  for (const fs::path& scene_dir : scenes) {
    const fs::path estimate_dir = estimates / scene_dir.filename();
    if (!fs::is_directory(estimate_dir)) {
      context.progress.line("no estimate of " + scene_dir.filename().string());
      continue;
    }
    labels.scene = labels.run = scene_dir.filename().string();
    try {
      if (!fs::is_directory(scene_dir / "truth"))
        throw std::runtime_error(scene_dir.string() + ": there is no truth/ to score against");
      if (manifest) check_unchanged(dataset, *manifest, scene_dir.filename());
      const SceneTruth truth = read_truth(scene_dir);
      labels.seed = truth.seed;
      append(score_scene(o, truth, estimate_dir, labels, context.progress), file);
      ++result.scored;
    } catch (const std::runtime_error& error) {  // of its files; the others' scores are kept
      result.failures.emplace_back(error.what());
    }
  }
  return result;
}

}  // namespace

ExitCode command_score(const JobContext& context) {
  const Options& o = context.options;
  const fs::path dataset = o.arguments.at(0);
  const fs::path estimates = o.arguments.at(1);
  if (is_detections(estimates, dataset)) return command_score_detections(context);
  refuse_given(o, {"--class-map", "--category", "--confidence"}, "is of a detector's results");
  for (const std::string& gate : o.gates) parse_gate(gate);
  const fs::path out = o.out.empty() ? estimates : fs::path(o.out);
  const FolderClaim claim{
      .verb = "score", .version = COUSIN_VERSION, .config = {}, .names = result_names()};
  check_output_folder(out, claim);
  const std::optional<Manifest> manifest = read_manifest(dataset);
  ScoreFile file = file_of_dataset(dataset, manifest);
  SeedsScoreLabels labels;
  labels.suite = dataset.filename().string();
  labels.method = "estimate";
  const auto [scored, failures] = add_scene_scores(context, manifest, labels, file);
  if (scored == 0 && !failures.empty()) throw std::runtime_error(failures.front());
  if (scored == 0)
    throw std::runtime_error(estimates.string() + ": holds no estimate of any scene of " +
                             dataset.string());
  labels.scene = "pooled";
  for (ScoreRow& row : pooled_rows(file.specimens, labels)) file.scores.push_back(std::move(row));
  {
    const OutputFolder folder(out, claim);
    write_result_tables(out, file);
  }
  print_result(o, file);
  context.progress.line("scores: " + (out / "scores.csv").string());
  if (!failures.empty()) {
    for (const std::string& failure : failures) print_message("cousin: " + failure);
    throw std::runtime_error(std::to_string(failures.size()) + " of " +
                             std::to_string(failures.size() + static_cast<std::size_t>(scored)) +
                             " scenes could not be scored; the others' scores are written");
  }
  return check_gates(o, file.scores);
}

}  // namespace cousin
