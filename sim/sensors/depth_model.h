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
class RayScene;
struct Scene;
struct Pose;

/// Numbers of the analytic depth model, fitted to the full one of a device (`fit_depth_model`).
/// Noise and fill are functions of the signal-to-noise ratio of the pattern, linear between knots
/// in its logarithm to base 2 and constant beyond them.
struct DepthModelConfig {
  std::vector<double> log2_snr = {-2, 0, 2, 4};
  std::vector<double> spatial_px = {0.3, 0.15, 0.08, 0.07};  ///< fixed while scene and rig stand
  std::vector<double> temporal_px = {0.2, 0.1, 0.04, 0.02};  ///< drawn anew in each image
  std::vector<double> fill = {0, 0.3, 0.95, 1};              ///< share of pixels with a depth
  double margin_weight = 0.25;  ///< of the matcher's margin among the noise
  double slope_noise = 3;       ///< spatial sigma that a disparity slope of 1 px/px adds, as its
                                ///< square
  double slope_loss = 0.3;      ///< share of fill lost at a disparity slope of 1 px/px, linear
  double ripple_px = 0.01;      ///< amplitude of d + A sin(2 pi d)
  double bias_px = 0;           ///< mean error of the disparity
  double fatten_px = 3;         ///< by which near surfaces grow over far ones
  double rim_px = 2;            ///< beyond it far surfaces have no depth: windows hold both
  double band_px = 0;           ///< the left band is as wide as the disparity plus this
  double grain_px = 9;          ///< width over which the noise is alike
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

/// What the right imager and the projector cannot see of a left depth image, row by row: a pixel is
/// hidden if a surface to its right (for a device at negative x: left) lies before it there.
/// Surfaces that only the device sees are unknown to the image and hide nothing.
Image<std::uint8_t> stereo_occlusion(const Image<float>& depth_m, const ActiveStereoConfig& config);

/// Renders the inputs: one truth pass and one sample a pixel of ambient infrared.
DepthModelInputs depth_model_inputs(const RayScene& rays, const Scene& scene,
                                    const Pose& rig_from_world, const ActiveStereoConfig& config,
                                    const ActiveStereoUnit& unit, Rng rng);

/// What the matcher has to go by in each pixel, in electrons, at the exposure that the brightest
/// half per cent ask for.
struct PatternLight {
  Image<float> signal_e;  ///< mean projected light, and the texture's; 0 = no surface or no light
  Image<float> light_e;   ///< light between the dots: the variance of shot noise
  double still_e2 = 0;    ///< variance of read noise and rounding
  double margin_e = 0;    ///< the matcher's margin
};
PatternLight pattern_light(const DepthModelInputs& inputs, const ActiveStereoConfig& config);

/// Signal-to-noise ratio of the pattern: signal over the root of all variances and of
/// margin_weight * margin^2.
Image<float> pattern_snr(const PatternLight& light, double margin_weight);

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
