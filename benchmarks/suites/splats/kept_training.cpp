#include "benchmarks/suites/splats/kept_training.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "perception/splats/splat_ply.h"
#include "sim/dataset/seam_io.h"
#include "sim/types/stage_clock.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr int kCheckpointEvery = 1000;  // steps: a second of writing in a minute of training

fs::path model_file(const fs::path& folder, const SplatModel& /*kind*/) {
  return folder / "model.ply";
}
fs::path model_file(const fs::path& folder, const NgpModel& /*kind*/) { return folder / "model"; }
void write_model(const fs::path& file, const SplatModel& model) { write_splat_ply(file, model); }
void write_model(const fs::path& file, const NgpModel& model) { write_ngp(file, model); }
void read_model(const fs::path& file, SplatModel& model) {
  model = read_splat_ply(file, {.invalid = SplatPlyConfig::Invalid::refuse}).model;
}
void read_model(const fs::path& file, NgpModel& model) { model = read_ngp(file); }

/// Point: step, wall_s and cpu_s of a training.
template <class Model, class Point>
void keep(const fs::path& folder, std::vector<Kept<Model>>& in_memory, int step, const Point& point,
          const Model& model) {
  StageTiming seconds = StageClock("training").finish();  // for the memory
  seconds.wall_s = point.wall_s;
  seconds.cpu_s = point.cpu_s;
  if (folder.empty()) {
    in_memory.push_back({step, seconds, model});
    return;
  }
  const fs::path own = folder / std::to_string(step);
  fs::create_directories(own);
  write_timings(own, {seconds});
  write_model(model_file(own, model), model);
}

/// What was kept of a training before is not this one's.
template <class Model>
void forget(const fs::path& folder, std::vector<Kept<Model>>& in_memory) {
  in_memory.clear();
  if (folder.empty() || !fs::exists(folder)) return;
  std::vector<fs::path> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory() && !entry.is_symlink() &&
        name.find_first_not_of("0123456789") == std::string::npos)
      folders.push_back(entry.path());
  }
  for (const fs::path& of_step : folders) remove_own_folder(of_step);
}

template <class Model>
std::vector<Kept<Model>> kept_models(const fs::path& folder,
                                     const std::vector<Kept<Model>>& in_memory,
                                     const std::vector<int>& at) {
  std::vector<Kept<Model>> models;
  fs::path missing;
  for (const int step : at) {
    if (folder.empty()) {
      const auto kept = std::find_if(in_memory.begin(), in_memory.end(),
                                     [&](const Kept<Model>& model) { return model.step == step; });
      if (kept != in_memory.end()) models.push_back(*kept);
      continue;
    }
    const fs::path own = folder / std::to_string(step);
    Kept<Model> kept;
    const fs::path file = model_file(own, kept.model);
    if (!fs::exists(file)) {
      missing = own;
      continue;
    }
    if (!missing.empty()) {
      throw std::runtime_error(missing.string() +
                               ": the model is gone, though the training went on; remove " +
                               folder.string() + " to train again");
    }
    kept.step = step;
    kept.seconds = read_timings(own).at(0);
    read_model(file, kept.model);
    models.push_back(std::move(kept));
  }
  return models;
}

}  // namespace

KeptTraining::KeptTraining(fs::path folder)
    : folder_(std::move(folder)), in_memory_(std::make_shared<std::vector<KeptModel>>()) {}

SplatCheckpoint KeptTraining::checkpoint() const {
  if (folder_.empty()) return {};
  return {folder_ / "training", kCheckpointEvery, true};
}

SplatSnapshots KeptTraining::snapshots(std::vector<int> at) const {
  const auto take = [folder = folder_, kept = in_memory_](const SplatTrainPoint& point,
                                                          const SplatModel& model) {
    keep(folder, *kept, point.step, point, model);
  };
  return {std::move(at), take, [folder = folder_, kept = in_memory_] { forget(folder, *kept); }};
}

std::vector<KeptModel> KeptTraining::models(const std::vector<int>& at) const {
  return kept_models(folder_, *in_memory_, at);
}

KeptFieldTraining::KeptFieldTraining(fs::path folder)
    : folder_(std::move(folder)), in_memory_(std::make_shared<std::vector<KeptField>>()) {}

NgpCheckpoint KeptFieldTraining::checkpoint() const {
  if (folder_.empty()) return {};
  return {folder_ / "training", kCheckpointEvery, true};
}

NgpSnapshots KeptFieldTraining::snapshots(std::vector<int> at) const {
  const auto take = [folder = folder_, kept = in_memory_](const NgpPoint& point,
                                                          const NgpModel& model) {
    keep(folder, *kept, point.iteration, point, model);
  };
  return {std::move(at), take, [folder = folder_, kept = in_memory_] { forget(folder, *kept); }};
}

std::vector<KeptField> KeptFieldTraining::models(const std::vector<int>& at) const {
  return kept_models(folder_, *in_memory_, at);
}

}  // namespace cousin
