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

/// A time-of-flight camera of amplitude-modulated light: the lamp sits at the lens, each pixel
/// correlates what comes back with the modulation at four phases, for each of several frequencies
/// [Lange & Seitz, IEEE J. Quantum Electronics 2001]. Numbers of light are electrons of one of the
/// four samples. Presets are TOML with a source for each number.
struct TimeOfFlightConfig {
  int columns = 512, rows = 424;
  double focal_px = 365;
  double depth_unit_m = 0.001;
  double least_depth_m = 0.5, largest_depth_m = 4.5;
  std::vector<double> modulation_hz = {16e6, 80e6, 120e6};
  double contrast = 0.6;           ///< of the modulation, as the pixel sees it
  double signal_e_at_1m = 40000;   ///< from a white surface that faces the lamp, 1 m away
  double ambient_e = 250000;       ///< at ambient radiance 1
  double read_noise_e = 40;        ///< of a sample
  double full_well_e = 300000;     ///< a sample at it is saturated
  double wiggle = 0.02;            ///< third harmonic of the correlation over the first
  double least_amplitude_e = 120;  ///< of the modulation: below, no depth
  double disagreement_m = 0.1;     ///< largest RMS between the frequencies' ranges
  int side = 2;                    ///< rays a pixel along each axis: their light is mixed
  int multipath_columns = 12;      ///< patches that light each other, in a row; 0 = no multipath
};
Fields fields(TimeOfFlightConfig& config);
/// @throws std::invalid_argument naming field, value and limit; frequencies must be 1 to 4 whole
/// megahertz, increasing.
void validate(const TimeOfFlightConfig& config);

Camera depth_camera(const TimeOfFlightConfig& config);
/// Range beyond which all frequencies repeat: c / 2 over their greatest common divisor.
double unambiguous_range_m(const TimeOfFlightConfig& config);

/// Standard deviation of the range from samples of mean `mean_e` and modulation `amplitude_e`
/// (both of one sample), all frequencies together, by first-order propagation of photon and read
/// noise: c / (4 pi f) sqrt((mean + read^2) / 2) / amplitude for one of them.
double time_of_flight_sigma_m(const TimeOfFlightConfig& config, double mean_e, double amplitude_e);

/// What the camera looks at. Images of rays are `side` times as large as the camera's each way, all
/// in the camera's axes.
struct TimeOfFlightInputs {
  Image<float> depth_m;           ///< of rays, along the axis; NaN = no surface
  Image<Eigen::Vector3f> normal;  ///< of rays; unit
  Image<float> albedo;            ///< of rays, at 850 nm
  Image<float> ambient;           ///< of pixels: infrared radiance without the lamp
  Image<float> centre_depth_m;    ///< of pixels' centres
};
TimeOfFlightInputs time_of_flight_inputs(const RayScene& rays, const Scene& scene,
                                         const Pose& camera_from_world,
                                         const TimeOfFlightConfig& config, Rng rng);

/// Light in the pixels, without noise.
struct TimeOfFlightLight {
  Image<float> mean_e;  ///< of a sample: ambient and lamp, direct and by way of other surfaces
  /// Modulation at each frequency: amplitude (electrons of a sample) and phase, x = A cos, y = A
  /// sin. Rays of a pixel and light that came by other surfaces are added: so pixels fly at edges,
  /// and concave corners come out too far.
  std::vector<Image<Eigen::Vector2f>> modulation;
};
/// Surfaces are Lambertian. Multipath is one bounce among patches of the image, without shadows
/// between them: what the camera does not see throws nothing.
/// @throws std::invalid_argument for an invalid configuration or inputs of other sizes.
TimeOfFlightLight time_of_flight_light(const TimeOfFlightInputs& inputs,
                                       const TimeOfFlightConfig& config);

struct TimeOfFlightDepth {
  Image<std::uint16_t> depth;  ///< Z16; 0 = none
  Image<float> range_m;        ///< from the lens, before rounding; NaN = none
  Image<float> amplitude_e;    ///< measured, at the highest frequency
  Image<float> noise_free_depth_m;
  Image<InvalidReason> reason;
};
/// One exposure. Row y draws from rng.fork(y).
TimeOfFlightDepth sense_time_of_flight(const TimeOfFlightInputs& inputs,
                                       const TimeOfFlightLight& light,
                                       const TimeOfFlightConfig& config, const Rng& rng);

}  // namespace cousin
