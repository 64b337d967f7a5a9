#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "perception/splats/splat_model.h"
#include "perception/splats/splat_train_config.h"
#include "perception/splats/splat_views.h"

namespace cousin {

enum class SplatTrainStatus {
  ok,
  no_views,          ///< none given
  no_start,          ///< no Gaussian with finite parameters
  nothing_to_learn,  ///< no pixel has weight
  nothing_seen,      ///< no view shows any Gaussian: poses or start are wrong
  nothing_left,      ///< none that was shown is still: photographs of the background alone
  not_finite,        ///< the loss was not a number
  too_many_pairs,  ///< Gaussians cover more tiles of one view than can be listed, see TooManyPairs
  stopped          ///< `progress` said so
};
std::string to_string(SplatTrainStatus status);
/// The status and what it means, for people: "nothing_seen: no view shows any Gaussian, ...".
std::string explained(SplatTrainStatus status);

struct SplatTrainPoint {
  int step = 0;
  /// Since training began, in steps alone: this run's and those it goes on from. CPU is of all
  /// threads of the process.
  double wall_s = 0, cpu_s = 0;
  double loss = 0;  ///< mean since the point before
  int splats = 0;
};

/// Seconds of wall time in each stage.
struct SplatTrainSeconds {
  double draw = 0, loss = 0, gradients = 0, update = 0, grow = 0, total = 0;
  double total_cpu = 0;  ///< of all threads of the process
  double kept = 0,
         kept_cpu = 0;  ///< of snapshots, checkpoints and `views_seen`, in none of the others
};

struct SplatTraining {
  SplatTrainStatus status = SplatTrainStatus::no_views;
  /// With `views_seen`, unless a view has too many pairs; as far as training came where status is
  /// not ok, with `too_many_pairs` after the growth that went too far.
  SplatModel model;
  std::vector<SplatTrainPoint> curve;
  SplatTrainSeconds seconds;
};

/// Where a training keeps itself, so that one that was stopped goes on and ends in the same bytes.
struct SplatCheckpoint {
  std::filesystem::path file;  ///< empty = none. If it exists, training goes on from it
  int every = 500;             ///< steps
  /// A file that is of another training, or that is damaged, is begun anew in place of an error.
  bool replaces_other = false;
  /// One of more steps is of another training, which was not left so early; 0: none is.
  int most_steps = 0;
};

/// Called at every point of the curve; false stops training. One that goes on from a point calls it
/// there first, so that a training that was left for good takes no more steps.
using SplatProgress = std::function<bool(const SplatTrainPoint& point)>;

/// Called after each of `at` steps with what has been learned so far. It changes no byte of the
/// training.
struct SplatSnapshots {
  std::vector<int> at;
  /// @param point  its loss is of this step alone; seconds are without those that snapshots take
  /// @param model  without `views_seen`
  std::function<void(const SplatTrainPoint& point, const SplatModel& model)> take;
  /// Called where a training begins that does not go on from a checkpoint: what was taken before is
  /// another's. May be empty.
  std::function<void()> begin;
};

/// Fits Gaussians to photographs with known poses [Kerbl et al., ACM TOG 42(4), 2023]. The same
/// views, start and configuration give the same model, byte for byte, on any number of threads,
/// whether it was interrupted or not.
/// @param start  its origin stays; degree is the configuration's
/// @throws std::invalid_argument if the configuration, a camera, or an image's size is invalid
/// @throws std::runtime_error if the checkpoint cannot be read or written, or is of another
/// training and not to be replaced
SplatTraining train_splats(std::span<const SplatView> views, const SplatModel& start,
                           const SplatTrainConfig& config, const SplatProgress& progress = {},
                           const SplatCheckpoint& checkpoint = {},
                           const SplatSnapshots& snapshots = {});

}  // namespace cousin
