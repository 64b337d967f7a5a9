#pragma once

#include "perception/splats/photometric_loss.h"
#include "perception/splats/splat_frame.h"
#include "perception/splats/splat_train_state.h"
#include "perception/splats/train_splats.h"

namespace cousin {

/// One training: takes its state from step to step. What it holds beside the state follows from
/// views and configuration, or is scratch.
class SplatTrainer {
 public:
  /// @param views  must outlive this
  SplatTrainer(std::span<const SplatView> views, const SplatTrainConfig& config,
               SplatTrainState state);

  const SplatTrainState& state() const { return state_; }
  const SplatTrainSeconds& seconds() const { return seconds_; }

  struct Step {
    double loss;
    std::size_t shown;  ///< Gaussians in the view
  };
  /// Growth and resets that are due after a step are the next one's beginning, as the reference has
  /// its images scored before them: a state is never that of Gaussians just parted or reset.
  Step step();
  /// In how many of the views each Gaussian covers at least one pixel.
  std::vector<int> views_seen();

 private:
  /// @param halvings  of the photograph, 0 = as it is
  SplatCamera camera_of(std::size_t view, int halvings);
  int halvings_now() const;
  /// The photographs of this size, in place of those of another.
  void make_small(int halvings);
  std::array<float, 3> background_now() const;
  /// The level's colours with `background` where it shows what is behind the scene.
  const ColorPlanes& photograph_before(const SplatViewLevel& level,
                                       const std::array<float, 3>& background);
  void update(double progress);
  void grow_if_due();

  SplatTrainConfig config_;
  SplatTrainState state_;
  std::span<const SplatView> views_;
  const SplatKernels& kernels_;
  PhotometricLoss loss_;
  std::vector<SplatViewLevel> small_;  ///< of each view while training is coarse; else empty
  int halvings_ = 0;                   ///< of `small_`
  ColorPlanes photograph_;             ///< of this step, where its background is not black
  SplatFrame frame_;
  std::vector<std::size_t> order_;  ///< of the views in this epoch
  SplatTrainSeconds seconds_;
};

}  // namespace cousin
