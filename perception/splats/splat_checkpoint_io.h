#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "perception/splats/splat_train_state.h"
#include "perception/splats/train_splats.h"

namespace cousin {

/// What a training needs to go on.
struct SavedTraining {
  std::string fingerprint;  ///< of views, start and configuration
  SplatTrainState state;
  std::vector<SplatTrainPoint> curve;
  double wall_s = 0, cpu_s = 0;  ///< of all steps, as in SplatTrainPoint
  double loss_sum = 0;           ///< since the curve's last point
  int loss_count = 0;
  int blind = 0;  ///< steps without a Gaussian in the view since the last that showed one
};

/// A hash of all that decides a training's bytes.
std::string training_fingerprint(std::span<const SplatView> views, const SplatModel& start,
                                 const SplatTrainConfig& config);

/// Little-endian, with a hash of itself at the end; written beside and renamed.
/// @throws std::runtime_error naming the file
void write_training(const std::filesystem::path& file, const SavedTraining& saved);
/// @throws std::runtime_error naming the file and what is wrong: not a checkpoint, cut off,
/// altered, or larger than `most_splats` allows
SavedTraining read_training(const std::filesystem::path& file, int most_splats);

}  // namespace cousin
