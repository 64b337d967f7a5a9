#pragma once

#include <array>
#include <vector>

#include "perception/mvs/bilinear.h"
#include "perception/mvs/mvs_view.h"

namespace cousin {

/// The surface around a pixel in ray coordinates (see ReferenceDepth).
struct SurfacePatch {
  float inverse_depth = 0;
  float slope_x = 0, slope_y = 0;
  float bend_xx = 0, bend_xy = 0, bend_yy = 0;
};

/// Scores surface patches at one pixel at a time, with a window weighted by likeness of colour: a
/// window on a seed's edge does not listen to the board [Yoon & Kweon, TPAMI 2006]. Images differ
/// in gain, offset and sharpness (distance, focus, resampling). All three are taken out: to a
/// slanted window a blurred edge looks just like a stretched one.
class PatchScorer {
 public:
  PatchScorer(const std::vector<MvsView>& views, int reference, const std::vector<int>& neighbours,
              int window_px);

  /// Moves to a pixel at least the window's radius inside the rectangle.
  void move_to(int x, int y);
  /// Weighted variance of the reference window, squared codes, less what a change of blur explains;
  /// zero on a rim.
  float texture() const { return variance_; }
  /// Mean of the better half of the neighbours' correlations, -1..1.
  float score(const SurfacePatch& patch) const;

  /// Gauss-Newton on depth and slopes; bends stay. The residuals are those left after a gain, an
  /// offset and a change of blur for each of the better half of the neighbours. Slopes have a prior
  /// at where they started, `slope_sigma` times the inverse depth wide (1 is a turn of 45 degrees):
  /// a lone edge leaves the depth beside it uncertain, not wild.
  struct Fit {
    SurfacePatch patch;
    float sigma = 0;  ///< standard deviation of inverse_depth, slopes marginalised
    bool ok = false;
  };
  Fit fit(const SurfacePatch& start, float slope_sigma, int iterations) const;

  /// Pixels of disparity for a change of inverse depth by one, in the neighbour that moves most.
  float disparity_per_inverse_depth(float inverse_depth) const;
  /// Ray coordinates across one pixel.
  float ray_step() const { return ray_step_; }
  /// Weights of the window's pixels, row by row, summing to one.
  const float* weights() const { return weight_.data(); }

 private:
  static constexpr int kLanes = 8;
  static constexpr int kMostTaps = 448;  ///< 21 x 21, rounded up to whole lanes
  static constexpr int kMostNeighbours = 32;
  using Taps = std::array<float, kMostTaps>;
  using LookUp = BilinearLookUp<kMostTaps>;
  struct Neighbour {
    Warp warp;
    const Image<float>* image;
  };
  struct NormalEquations;
  template <bool kSlopes>
  void place(const Neighbour& neighbour, const SurfacePatch& patch, LookUp& look_up, float* d_x,
             float* d_y) const;
  float correlation(const Neighbour& neighbour, const SurfacePatch& patch) const;
  float weighted_sum(const Taps& a) const;
  float weighted_dot(const Taps& a, const Taps& b) const;
  void add_equations(const Neighbour& neighbour, const SurfacePatch& patch,
                     NormalEquations& sum) const;

  const MvsView& view_;
  std::vector<Neighbour> neighbours_;
  int radius_;
  int taps_;  ///< padded
  int counted_;
  float ray_step_;
  std::vector<float> distance_weight_;
  alignas(32) Taps ray_x_{}, ray_y_{}, dx_{}, dy_{}, value_{}, detail_{}, likeness_{}, weight_{};
  float centre_x_ = 0, centre_y_ = 0;
  float mean_ = 0, variance_ = 0, effective_samples_ = 1;
  float inverse_detail_ = 0;  ///< 1 / variance of the detail
};

}  // namespace cousin
