#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "benchmarks/score/image_fidelity.h"
#include "benchmarks/score/learned/learned_distance.h"
#include "benchmarks/suites/seedlings/sample_capture.h"

namespace cousin {

/// A model's image as the view's camera shows it; its exposure is the view's where the model knows
/// that, else the mean of those that it was trained on.
using FieldRenderer = std::function<FidelityPlanes(const SplatView&)>;

/// How a model's images look beside photographs: means over the views, NaN where no pixel counts.
struct ViewScores {
  std::int64_t views = 0;
  double psnr_db = kNaN, ssim = kNaN, flip = kNaN;  ///< over what the photograph shows
  /// Over the plants alone, of views with any.
  double psnr_seedlings_db = kNaN, ssim_seedlings = kNaN, flip_seedlings = kNaN;
  double psnr_exposed_db = kNaN;  ///< after the factor on light that fits each photograph best
  double learned = kNaN;          ///< by a network of the user's, if there is one
  std::int64_t views_of_seedlings = 0;
};

/// A model after some of its training.
struct FieldScores {
  int steps = 0;
  double wall_s = 0, cpu_s = 0;  ///< of training
  std::int64_t gaussians = 0;    ///< 0: it has none
  ViewScores train, held_out;
  /// PSNR over all pixels of the held-out views together, over those whose surface is seen by
  /// enough of the views that were trained on, and over the others. The first lies between the
  /// others; the mean of the views' PSNR lies above it where views differ.
  double pooled_db = kNaN, covered_db = kNaN, uncovered_db = kNaN;
};

/// Views that number and cover.
inline constexpr int kEnoughViews = 3;

/// What a model is trained on and scored by.
struct FieldViews {
  std::vector<const SampleView*> train, held_out;
  /// By how many of `train` the surface of each held-out pixel is seen.
  std::vector<Image<std::uint16_t>> seen;
  std::shared_ptr<const LearnedDistance> learned = {};  ///< whole images are scored by it too
};
/// @param train  any of the capture's; `held_out`: those of the plan that are held out
FieldViews field_views(std::vector<const SampleView*> train,
                       std::vector<const SampleView*> held_out);

/// A radiance field takes seconds to show a view, so of many views trained on these are scored:
/// evenly spread, all where they are few.
inline constexpr std::size_t kScoredViews = 10;
std::vector<std::size_t> scored_views(std::size_t trained);

/// Scores `render` on both; steps, seconds and the number of Gaussians are the caller's.
FieldScores score_field(const FieldRenderer& render, const FieldViews& views);

}  // namespace cousin
