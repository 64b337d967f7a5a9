#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/config/fields.h"
#include "sim/sensors/invalid_reason.h"
#include "sim/types/image.h"
#include "sim/types/rng.h"

namespace cousin {

struct ActiveStereoConfig;
struct ActiveStereoUnit;
struct DotProjectorConfig;
class RayScene;
struct Scene;
struct Pose;

/// Numbers of the analytic depth model, fitted to the full one of a device (`fit_depth_model`).
/// Curves are linear between knots in how much better a window's own counterpart is than others
/// (`MatchContrast`) and constant beyond them.
///
/// A matcher compares whole pixels: a window whose disparity lies half-way between two fits both
/// less well than one that lies on a pixel fits its own. Fill, noise and bias therefore go with the
/// fraction of the disparity: a wave is the amplitude of cos(2 pi d). It dies away where a window
/// spans many fractions, as sin(pi s w) / (pi s w) for a slope s and a window w.
///
/// A pixel has a depth if the matcher's score, which spreads normally from window to window, passes
/// its thresholds: the share is the normal distribution's at fill_score.
struct DepthModelConfig {
  double contrast_dots = 0.5;  ///< share of the dots' photon noise in the contrast
  double contrast_spread = 2;  ///< area of a dot as windows see it, over its own
  double reach_px = 16;        ///< the matcher's paths bring what brighter places this far off know
  std::vector<double> contrast = {0, 1, 2, 4};               ///< knots
  std::vector<double> spatial_px = {0.3, 0.15, 0.08, 0.07};  ///< fixed while scene and rig stand
  std::vector<double> spatial_wave = {0, 0, 0, 0};           ///< of it, over its mean
  std::vector<double> temporal_px = {0.2, 0.1, 0.04, 0.02};  ///< drawn anew in each image
  std::vector<double> temporal_wave = {0, 0, 0, 0};          ///< of it, over its mean
  std::vector<double> ripple_px = {0.01, 0.01, 0.01, 0.01};  ///< amplitude of sin(2 pi d)
  std::vector<double> fill_score = {-3, -1, 2, 4};           ///< quantile of the share with a depth
  std::vector<double> fill_wave = {0, 0, 0, 0};              ///< of the score
  double slope_spatial = 3;   ///< spatial sigma that a slope of 1 px/px adds, as its power 1.5
  double slope_temporal = 1;  ///< and temporal
  double slope_fill = 10;     ///< score lost at a slope of 1 px/px, as its square
  double bias_px = 0;         ///< mean error of the disparity
  double fatten_px = 3;       ///< by which near surfaces grow over far ones
  double rim_px = 2;          ///< beyond it far surfaces have no depth: windows hold both
  double band_px = 0;         ///< the left band is as wide as the disparity plus this
  double grain_px = 9;        ///< width over which the noise is alike
};
Fields fields(DepthModelConfig& config);
/// @throws std::invalid_argument naming field, value and limit; knots must increase and lists be of
/// one length.
void validate(const DepthModelConfig& config);

/// What the model needs of a view, all images of the left imager.
struct DepthModelInputs {
  Image<float> depth_m;           ///< noise-free; NaN = no surface
  Image<Eigen::Vector3f> normal;  ///< unit, in the camera; zero = none
  Image<float> albedo;            ///< at 850 nm
  Image<float> ambient;           ///< infrared radiance without the projector
  Image<std::uint8_t> hidden;     ///< bits below
  double texture = 0;             ///< contrast of the surfaces' own pattern over their radiance
};
inline constexpr std::uint8_t kHiddenFromRight = 1, kHiddenFromProjector = 2;
/// @throws std::invalid_argument if an image is not of the camera's size.
void validate(const DepthModelInputs& inputs, const Camera& camera);

/// What the right imager and the projector cannot see of a left depth image (`hidden_along_rows`),
/// in the bits above.
Image<std::uint8_t> stereo_occlusion(const Image<float>& depth_m, const ActiveStereoConfig& config);

/// Renders the inputs: one truth pass and one sample a pixel of ambient infrared.
DepthModelInputs depth_model_inputs(const RayScene& rays, const Scene& scene,
                                    const Pose& rig_from_world, const ActiveStereoConfig& config,
                                    const ActiveStereoUnit& unit, Rng rng);

/// What the matcher has to go by in each pixel, in electrons, at the exposure that the brightest
/// half per cent ask for.
struct PatternLight {
  Image<float> signal_e;   ///< mean projected light, and the texture's; 0 = no surface or no light
  Image<float> ambient_e;  ///< light without the projector
  Image<float> rise;       ///< gradient of log2(signal_e) along the surface, 1/px
  double still_e2 = 0;     ///< variance of read noise and rounding
  double margin_e = 0;     ///< the matcher's margin
};
PatternLight pattern_light(const DepthModelInputs& inputs, const ActiveStereoConfig& config);

/// The signal `reach_px` towards the brighter side, at most four times as much: semi-global paths
/// carry what they know from there, so that a wall that turns away from the light loses its depth
/// later than an even wall as dark.
float signal_in_reach(float signal_e, float rise, float reach_px);

/// Share of the picture that dots would cover if each were as bright as its peak over 2 pi sigma^2:
/// a dot is brighter than a share v of its peak on an area of its part of this times -log(v).
double dot_cover(const DotProjectorConfig& projector, double blur_rad);

/// A curve's value: linear between the knots `x`, constant beyond them.
double at_knots(const std::vector<double>& x, const std::vector<double>& y, double at);

/// What is left of a wave where the window spans several fractions of a pixel, in [0, 1].
float wave_share(float slope, float window_px);

struct ModelDepth {
  Image<float> disparity_px;   ///< in the device's steps; NaN = none
  Image<std::uint16_t> depth;  ///< Z16; 0 = none
  Image<InvalidReason> reason;
};
/// Depth with sigma_Z = Z^2 sigma_d / (f B): fattened edges, ripple, spatial and temporal noise of
/// a grain, holes by fill, band, occlusion, quantisation. Over-exposure is not modelled.
/// @param fixed  of the scene and rig: spatial noise and holes.  @param frame  of this image.
/// @throws std::invalid_argument for an invalid configuration or inputs of different sizes.
ModelDepth model_depth(const DepthModelInputs& inputs, const ActiveStereoConfig& config,
                       const Rng& fixed, const Rng& frame);

}  // namespace cousin
