#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/suites/seedlings/view_sets.h"
#include "perception/mvs/plane_sweep.h"
#include "perception/splats/splat_start.h"
#include "perception/splats/splat_views.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// One tray under one light. The same number is the same tray, seen from the same places, under
/// each light.
struct SeedlingsSample {
  std::string light = "D1";
  int number = 0;
  double day = 6;  ///< since sowing
  int views = 30;  ///< of a set that is not a part: those trained on
  int width_px = 400, height_px = 300;
  int pixel_samples = 16;  ///< paths
};

/// The scene's keys of a sample, key=value.
std::vector<std::string> assignments(const SeedlingsSample& sample);

/// The scene that a sample is of. Its rig is the scene's phone with pixels that average so many of
/// its own that the picture has the sample's width.
RunConfig sample_config(const SeedlingsSample& sample);

/// `phone` with a picture of another size: a pixel is the mean of (width / new width)^2 of the
/// preset's, so its well is that much deeper and its noise smaller in proportion. The field of view
/// keeps its width, and the blur its share of a pixel, as a lens of the smaller picture's class.
PhoneConfig with_picture(PhoneConfig phone, int width_px, int height_px);

/// A photograph and what is true of it, all as a pinhole camera sees them.
struct SampleView {
  SplatView photograph;               ///< with its exact pose and lens
  Image<std::uint8_t> shown;          ///< 255 where the photograph shows something
  Image<float> depth_m;               ///< along the axis; NaN = no surface
  Image<Eigen::Vector3f> position_m;  ///< in the world; NaN = none
  Image<std::uint8_t> seedlings;      ///< 255 on plants, where the photograph shows something
};

/// Where a sample is photographed from.
enum class SamplePlan {
  whole_tray,  ///< planned_views(views) places, evenly all around and over the tray
  one_side     ///< `views` places on kOneSideShare of the azimuths and of the tray
};

struct SampleCapture {
  std::vector<SampleView> views;
  /// Mean over `noise_views` of the views: PSNR between two captures from the same places with the
  /// same camera, whose paths and noise were drawn anew.
  double noise_psnr_db = 0;
  int noise_views = 0;
  double noise_seedlings_db = 0;  ///< over plants alone, of these views with any
  int noise_views_of_seedlings = 0;
  double wall_s = 0;  ///< of all
};

/// Photographs of a sample. @param noise_views  of those that are not held out, evenly spread; 0 =
/// the noise is not measured
SampleCapture photograph_sample(const SeedlingsSample& sample, SamplePlan plan, int noise_views,
                                std::uint64_t seed);

/// What Gaussians begin from: grey points, two thirds spread evenly over the space of the tray and
/// its plants, a third over a layer of the bench about it. Exact poses come without the points that
/// a reconstruction of poses makes; where the reference has none, it begins at random points too.
std::vector<StartPoint> sample_start(const SeedlingsSample& sample, int points, Rng rng);
/// What a sweep does not find, beside `points` on surfaces: a third as many, nearly opaque, over
/// the layer just under the bench, which has no texture, and three fifths, nearly transparent, over
/// the space of the tray and its plants, whose stems are thin. Were all as opaque, the points in
/// the air would show the bench and be fog before held-out views.
std::vector<StartPoint> unswept_start(const SeedlingsSample& sample, int points, const Rng& rng);
/// The space of the tray and its plants with a rim of the bench: where surfaces are swept.
SweepVolume sample_volume(const SeedlingsSample& sample);

}  // namespace cousin
