#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/config/fields.h"
#include "sim/render/ray_scene.h"
#include "sim/sensors/invalid_reason.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"
#include "sim/types/rng.h"

namespace cousin {

struct Scene;

/// Which measurement the axial noise follows.
enum class AxialNoise {
  nguyen,        ///< sigma over depth and incidence [Nguyen, Izadi & Lovell, 3DIMPVT 2012]
  barron_malik,  ///< noise of the disparity's code alone [Barron & Malik, CVPR 2013]
};

/// A structured-light depth camera: one imager, and a projector of one fixed pattern beside it.
/// Presets are TOML with a source for each number.
struct StructuredLightConfig {
  int columns = 640, rows = 480;
  double focal_px = 585.5;
  double baseline_m = 0.075;  ///< to the projector, at positive x
  double depth_unit_m = 0.001;
  double least_depth_m = 0.4, largest_depth_m = 3;
  double disparity_step_px = 0.125;        ///< disparities are codes of this
  double disparity_noise_steps = 1 / 6.0;  ///< sigma of a code before it is rounded
  AxialNoise axial = AxialNoise::nguyen;
  double axial_floor_m = 0.0012;       ///< sigma at the best depth
  double axial_growth_per_m = 0.0019;  ///< times (z - best)^2
  double axial_best_m = 0.4;
  double axial_tilt = 0.0001;      ///< times theta^2 / (pi/2 - theta)^2 / sqrt(z), m^1.5
  double lateral_px = 0.8;         ///< sigma of an edge's place
  double lateral_tilt_px = 0.035;  ///< times theta / (pi/2 - theta)
  double steepest_rad = 1.396;     ///< incidence beyond which nothing is found
  int window_px = 9;               ///< of the correlation: half of it has no depth at the border
};
Fields fields(StructuredLightConfig& config);
/// @throws std::invalid_argument naming field, value and limit.
void validate(const StructuredLightConfig& config);

Camera depth_camera(const StructuredLightConfig& config);

/// sigma_z = floor + growth (z - best)^2 + tilt theta^2 / (pi/2 - theta)^2 / sqrt(z)  [Nguyen et
/// al., eq. 3]. @param incidence_rad  below pi/2
double axial_sigma_m(const StructuredLightConfig& config, double depth_m, double incidence_rad);
/// sigma_L = lateral + tilt theta / (pi/2 - theta)  [eq. 2].
double lateral_sigma_px(const StructuredLightConfig& config, double incidence_rad);
/// Spread of depth by a code's noise and its rounding: z^2 step / (f b) sqrt(noise^2 + 1/12).
double code_sigma_m(const StructuredLightConfig& config, double depth_m);

struct StructuredLightInputs {
  Image<float> depth_m;           ///< noise-free; NaN = no surface
  Image<Eigen::Vector3f> normal;  ///< unit, in the camera
};
StructuredLightInputs structured_light_inputs(const RayScene& rays, const Scene& scene,
                                              const Pose& camera_from_world,
                                              const StructuredLightConfig& config);

struct StructuredLightDepth {
  Image<std::uint16_t> depth;  ///< Z16; 0 = none
  Image<float> noise_free_depth_m;
  Image<InvalidReason> reason;
};
/// One exposure: edges move by the lateral noise, depth by the axial one, then codes are rounded
/// (code = round(f b / (step z) + noise), as Barron & Malik do; with Nguyen's noise, what rounding
/// adds is taken off first, as it was in what they measured). Shadows of the projector and what
/// grazes have no depth. Row y draws from rng.fork(y).
/// @throws std::invalid_argument for an invalid configuration or inputs of other sizes.
StructuredLightDepth sense_structured_light(const StructuredLightInputs& inputs,
                                            const StructuredLightConfig& config, const Rng& rng);

}  // namespace cousin
