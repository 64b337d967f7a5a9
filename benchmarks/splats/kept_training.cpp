#include "benchmarks/splats/kept_training.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "perception/splats/splat_ply.h"
#include "sim/dataset/seam_io.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr int kCheckpointEvery = 1000;  // steps: a second of writing in a minute of training

fs::path model_file(const fs::path& folder) { return folder / "model.ply"; }

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
    StageTiming seconds = StageClock("training").finish();  // for the memory
    seconds.wall_s = point.wall_s;
    seconds.cpu_s = point.cpu_s;
    if (folder.empty()) {
      kept->push_back({point.step, seconds, model});
      return;
    }
    const fs::path own = folder / std::to_string(point.step);
    fs::create_directories(own);
    write_timings(own, {seconds});
    write_splat_ply(model_file(own), model);
  };
  return {std::move(at), take};
}

std::vector<KeptModel> KeptTraining::models(const std::vector<int>& at) const {
  std::vector<KeptModel> models;
  fs::path missing;
  for (const int step : at) {
    if (folder_.empty()) {
      const auto kept = std::find_if(in_memory_->begin(), in_memory_->end(),
                                     [&](const KeptModel& model) { return model.step == step; });
      if (kept != in_memory_->end()) models.push_back(*kept);
      continue;
    }
    const fs::path own = folder_ / std::to_string(step);
    if (!fs::exists(model_file(own))) {
      missing = own;
      continue;
    }
    if (!missing.empty()) {
      throw std::runtime_error(missing.string() +
                               ": the model is gone, though the training went on; remove " +
                               folder_.string() + " to train again");
    }
    models.push_back(
        {step, read_timings(own).at(0),
         read_splat_ply(model_file(own), {.invalid = SplatPlyConfig::Invalid::refuse}).model});
  }
  return models;
}

}  // namespace cousin
