#pragma once

#include <array>
#include <cstdint>

namespace cousin {

/// How the number of Gaussians changes while they are trained.
enum class SplatGrowth {
  fixed,     ///< it does not
  adaptive,  ///< the reference's clone, split, prune and opacity reset [Kerbl et al. 2023]
  budgeted,  ///< as many as a schedule grants, those of the largest gradients first [the idea:
             ///< Mallick et al., Taming 3DGS, 2024]; each parts along its longest axis
  mcmc       ///< relocation and noise [Kheradmand et al., 3DGS as Markov Chain Monte Carlo, 2024]
};

/// Learning rates of Adam. Those of the reference are 1.6e-4, 1.6e-6, 5e-3, 1e-3, 5e-2, 2.5e-3 and
/// 1.25e-4, made for 30,000 steps; these are fitted to trainings of 1000 steps on the photographs
/// of `cousin bench splats`, by their held-out views.
struct SplatRates {
  double centre_first = 4e-3;  ///< times the scene's extent; falls exponentially
  double centre_last = 1e-5;   ///< to this at the last step
  double log_scale = 2e-2;
  double rotation = 5e-3;
  double opacity = 5e-2;
  double dc = 5e-3;
  double rest = 5e-4;
  double decay = 1;  ///< all but the centre's fall exponentially to this share of themselves
};

/// Rates for a training of that many steps: the defaults up to 1000; beyond, centres and scales go
/// more slowly, a quarter as fast at 7000 steps and geometric between and beyond, since at the
/// defaults many steps keep throwing about what they have placed. `cousin bench seedlings`, D2,
/// tray 2, 7000 steps, 120,000 Gaussians, trained / held out: 35.2 / 24.6 dB at the defaults,
/// 36.2 / 25.9 so, 35.8 / 26.2 at half of these.
SplatRates rates_for(int steps);

/// Defaults that `SplatRates` does not have are fitted likewise.
struct SplatTrainConfig {
  int steps = 2000;  ///< one view each; 1..1,000,000
  int sh_degree = 3;
  int sh_degree_every = 0;  ///< steps between degrees; 0 = steps / 30, as 1000 of 30,000
  std::uint64_t seed = 1;
  int report_every = 50;              ///< steps between points of the curve
  std::array<float, 3> background{};  ///< also of what is behind the scene in the photographs
  /// Another colour at each step, in the photographs too: what is not opaque shows it. Before one
  /// colour alone, a black square may as well be half transparent and of the complement.
  bool any_background = false;
  double ssim_share = 0.2;  ///< of the loss; the rest is the mean absolute difference
  double near = 0.01;       ///< share of the median depth, as in SplatRenderConfig
  /// As in SplatModel, of a whole image. The reference's 0.3 blurs what is learned by half a pixel:
  /// on the neutral set 0.1 gives 0.4 dB more on held-out views, and less than that nothing more.
  double low_pass_px2 = 0.1;
  SplatRates rates;
  int rest_every = 1;  ///< steps between updates of the coefficients beyond the first

  /// Coarse to fine: images of a quarter of the size up to this share of the steps, of half the
  /// size up to the next.
  double quarter_until = 0.15, half_until = 0.4;

  SplatGrowth growth = SplatGrowth::budgeted;
  int most_splats = 30000;       ///< growth makes no more, a start may have; 1..10,000,000
  int grow_every = 50;           ///< steps
  double grow_from = 0.05;       ///< share of the steps
  double grow_until = 0.6;       ///< share of the steps
  double growth_power = 1;       ///< of the schedule between start and `most_splats`
  double gradient_limit = 2e-4;  ///< `adaptive`: mean gradient in an image of width and height 2
  double split_size = 0.01;      ///< share of the extent above which Gaussians split, not clone
  double least_opacity = 0.005;  ///< below it they are pruned, or moved by `mcmc`
  double largest_size = 0.1;     ///< share of the extent; `adaptive` prunes larger ones once
                                 ///< opacities have been reset
  double reset_every = 0;        ///< opacity reset, share of the steps; 0 = never
  /// `mcmc`: times the centre's rate, of covariances in extents. The published 5e5 is times a rate
  /// that the extent is in, of covariances in the scene's unit: 5e5 extents squared, and this is as
  /// much on the neutral set, whose extent is 2.60.
  double noise = 3.4e6;
  double opacity_pull = 0.01;  ///< `mcmc`: weight of the mean opacity in the loss
  double scale_pull = 0.01;    ///< `mcmc`: weight of the mean scale, in extents, in the loss
};

/// The reference's training: 30,000 steps at full size with its rates, schedule and density control
/// [Kerbl et al. 2023, and the settings published with it]. Adam moves only the Gaussians that a
/// view shows, as with the published program's option sparse_adam; without it, moments move the
/// others too.
SplatTrainConfig reference_training();

/// @throws std::invalid_argument naming the field, its value and the limits.
void validate(const SplatTrainConfig& config);

}  // namespace cousin
