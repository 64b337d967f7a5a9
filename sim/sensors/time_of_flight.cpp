#include "sim/sensors/time_of_flight.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr double kLight_m_per_s = 299792458;

}  // namespace

Fields fields(TimeOfFlightConfig& c) {
  return {
      {"columns", &c.columns, "columns of the image", 16, 4096},
      {"rows", &c.rows, "rows of the image", 16, 4096},
      {"focal_px", &c.focal_px, "focal length", 10, 1e5},
      {"depth_unit_m", &c.depth_unit_m, "of the 16-bit depth", 1e-6, 1},
      {"least_depth_m", &c.least_depth_m, "nearer, no depth is given", 0, 1e3},
      {"largest_depth_m", &c.largest_depth_m, "farther, no depth is given", 1e-3, 1e4},
      {"modulation_hz", &c.modulation_hz, "1 to 4 frequencies, whole megahertz, rising", 1e6, 1e9},
      {"contrast", &c.contrast, "of the modulation", 0.01, 1},
      {"signal_e_at_1m", &c.signal_e_at_1m, "electrons of a sample, white wall at 1 m", 1, 1e9},
      {"ambient_e", &c.ambient_e, "electrons of a sample at ambient radiance 1", 0, 1e9},
      {"read_noise_e", &c.read_noise_e, "sigma of a sample", 0, 1e4},
      {"full_well_e", &c.full_well_e, "saturation of a sample", 100, 1e9},
      {"wiggle", &c.wiggle, "third harmonic over the first", 0, 0.3},
      {"least_amplitude_e", &c.least_amplitude_e, "modulation below which no depth is given", 0,
       1e9},
      {"disagreement_m", &c.disagreement_m, "largest RMS between the frequencies' ranges", 1e-6,
       1e3},
      {"side", &c.side, "rays a pixel along each axis", 1, 8},
      {"multipath_columns", &c.multipath_columns, "patches in a row that light each other", 0, 64},
  };
}

void validate(const TimeOfFlightConfig& config) {
  TimeOfFlightConfig copy = config;
  check_limits(fields(copy), "time of flight");
  const auto reject = [](const std::string& what) {
    throw std::invalid_argument("time of flight: " + what);
  };
  const auto& hz = config.modulation_hz;
  if (hz.empty() || hz.size() > 4)
    reject("modulation_hz has " + std::to_string(hz.size()) + " numbers; 1 to 4 are possible");
  for (std::size_t i = 0; i < hz.size(); ++i) {
    if (std::fmod(hz[i], 1e6) != 0)
      reject("modulation_hz = " + std::to_string(hz[i]) + " is not a whole number of megahertz");
    if (i > 0 && !(hz[i] > hz[i - 1])) reject("modulation_hz must increase");
  }
  if (!(config.least_depth_m < config.largest_depth_m))
    reject("least_depth_m = " + std::to_string(config.least_depth_m) +
           " is not below largest_depth_m = " + std::to_string(config.largest_depth_m));
}

Camera depth_camera(const TimeOfFlightConfig& config) {
  Camera camera;
  camera.width_px = config.columns;
  camera.height_px = config.rows;
  camera.fx_px = camera.fy_px = config.focal_px;
  camera.cx_px = 0.5 * (config.columns - 1);
  camera.cy_px = 0.5 * (config.rows - 1);
  return camera;
}

double unambiguous_range_m(const TimeOfFlightConfig& config) {
  std::uint64_t divisor = 0;
  for (const double hz : config.modulation_hz)
    divisor = std::gcd(divisor, static_cast<std::uint64_t>(std::llround(hz)));
  return 0.5 * kLight_m_per_s / static_cast<double>(divisor);
}

double time_of_flight_sigma_m(const TimeOfFlightConfig& config, double mean_e, double amplitude_e) {
  const double phase_rad =
      std::sqrt(0.5 * (mean_e + config.read_noise_e * config.read_noise_e)) / amplitude_e;
  double weights = 0;
  for (const double hz : config.modulation_hz) {
    const double sigma_m = kLight_m_per_s / (4 * std::numbers::pi * hz) * phase_rad;
    weights += 1 / (sigma_m * sigma_m);
  }
  return 1 / std::sqrt(weights);
}

}  // namespace cousin
