#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "perception/ngp/ngp.h"

namespace cousin {

namespace ngp {
inline constexpr int kMostRays = 65536;  ///< of an iteration
}

/// What a training holds beside its model.
struct NgpTrainState {
  int iteration = 0;  ///< done
  /// Adam's moments, as many as there are numbers in the model's table and weights.
  std::vector<float> table_first, table_second, weights_first, weights_second;
  int rays = 0;              ///< of the next iteration
  std::int64_t samples = 0;  ///< that passed the networks
};

/// What a training needs to go on.
struct SavedNgpTraining {
  std::string fingerprint;  ///< of views and configuration
  NgpModel model;
  NgpTrainState state;
  std::vector<NgpPoint> curve;
  double wall_s = 0, cpu_s = 0;  ///< of all iterations, as in NgpPoint
  double loss_sum = 0;           ///< since the curve's last point
  int loss_count = 0;
};

/// A hash of all that decides a training's bytes on one kind of processor.
std::string ngp_fingerprint(std::span<const NgpView> views, const NgpConfig& config);

/// @throws std::runtime_error naming the file
void write_ngp_training(const std::filesystem::path& file, const SavedNgpTraining& saved);
/// @throws std::runtime_error naming the file and what is wrong: not a checkpoint, cut off,
/// altered, or of other sizes than its configuration asks for
SavedNgpTraining read_ngp_training(const std::filesystem::path& file);

}  // namespace cousin
