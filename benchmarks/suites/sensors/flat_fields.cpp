#include "benchmarks/suites/sensors/flat_fields.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/sensors/optics.h"

namespace cousin {
namespace {

constexpr double kElectronsAtUnit = 1000;

bool is_green(const CameraSensorConfig& config, int x, int y) {
  return bayer_channel(config.photosites.mosaic, x, y) == 1;
}

/// Green photosites of a flat field that gives them `electrons`, less the black level.
std::vector<double> green_codes(const CameraSensorConfig& flat, const CameraUnit& unit,
                                double electrons, std::uint64_t seed) {
  const auto radiance = static_cast<float>(electrons / kElectronsAtUnit);
  const Image<std::uint16_t> raw =
      expose(Image<Rgbf>(flat.width_px, flat.height_px, {radiance, radiance, radiance}), flat, unit,
             unit.lens.at_infinity, Rng(seed));
  std::vector<double> codes;
  codes.reserve(raw.size());
  for (int y = 0; y < raw.height(); ++y) {
    for (int x = 0; x < raw.width(); ++x) {
      if (is_green(flat, x, y)) codes.push_back(raw(x, y) - flat.photosites.black_level);
    }
  }
  return codes;
}

std::vector<double> green_values(const CameraSensorConfig& flat, const Image<float>& map) {
  std::vector<double> values;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (is_green(flat, x, y)) values.push_back(static_cast<double>(map(x, y)));
    }
  }
  return values;
}

double mean_of(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return sum / static_cast<double>(v.size());
}

double variance_of(const std::vector<double>& v) {
  const double mean = mean_of(v);
  double sum = 0;
  for (const double x : v) sum += (x - mean) * (x - mean);
  return sum / static_cast<double>(v.size() - 1);
}

/// Mean over frames of each photosite, and the temporal variance that is left in it.
struct Stack {
  std::vector<double> mean;
  double left_variance = 0;
};
Stack stack(const CameraSensorConfig& flat, const CameraUnit& unit, double electrons, int frames,
            std::uint64_t seed) {
  Stack result;
  std::vector<double> squares;
  for (int f = 0; f < frames; ++f) {
    const std::vector<double> one =
        green_codes(flat, unit, electrons, seed + static_cast<std::uint64_t>(f));
    result.mean.resize(one.size());
    squares.resize(one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      result.mean[i] += one[i] / frames;
      squares[i] += one[i] * one[i] / frames;
    }
  }
  double temporal = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    temporal += squares[i] - result.mean[i] * result.mean[i];
  }
  // (n - 1) / n of the variance shows in a stack of n; its n-th part is left in the mean.
  result.left_variance = temporal / static_cast<double>(squares.size()) / (frames - 1);
  return result;
}

/// Light at which the shot noise spans 0.7 codes, 10 electrons at least.
double lowest_electrons(const PhotositesConfig& photosites) {
  const double k = codes_per_electron(photosites);
  return std::max(10.0, 0.49 / (k * k));
}

}  // namespace

CameraSensorConfig flat_camera(const CameraSensorConfig& config) {
  CameraSensorConfig flat = config;
  flat.width_px = 640;
  flat.height_px = 480;
  flat.lens = {};
  flat.lens.model = LensModel::pinhole;
  flat.photosites.electrons_at_unit_radiance = kElectronsAtUnit;
  flat.photosites.srgb_from_camera.clear();
  return flat;
}

PhotonTransfer photon_transfer(const CameraSensorConfig& flat, const CameraUnit& unit,
                               int exposures, std::uint64_t seed) {
  const double first_e = lowest_electrons(flat.photosites);
  const double last_e = 0.8 * flat.photosites.full_well_e;
  PhotonTransfer result;
  double sw = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int i = 0; i < exposures; ++i) {
    const double electrons =
        first_e * std::pow(last_e / first_e, static_cast<double>(i) / (exposures - 1));
    const std::uint64_t pair = seed + 2 * static_cast<std::uint64_t>(i);
    std::vector<double> a = green_codes(flat, unit, electrons, pair);
    const std::vector<double> b = green_codes(flat, unit, electrons, pair + 1);
    const double mean = 0.5 * (mean_of(a) + mean_of(b));
    for (std::size_t j = 0; j < a.size(); ++j) a[j] -= b[j];
    const double variance = 0.5 * variance_of(a);
    result.points.push_back({mean, variance});
    const double w = 1 / (variance * variance);
    sw += w;
    sx += w * mean;
    sy += w * variance;
    sxx += w * mean * mean;
    sxy += w * mean * variance;
    result.photosites = static_cast<std::int64_t>(a.size());
  }
  result.slope = (sw * sxy - sx * sy) / (sw * sxx - sx * sx);
  result.intercept = (sy - result.slope * sx) / sw;
  return result;
}

double expected_intercept(const PhotositesConfig& p) {
  const double k = codes_per_electron(p);
  return k * k * (p.read_noise_e * p.read_noise_e + p.row_noise_e * p.row_noise_e) + 1.0 / 12;
}

FixedPattern fixed_pattern(const CameraSensorConfig& flat, const CameraUnit& unit, int frames,
                           std::uint64_t seed) {
  const double k = codes_per_electron(flat.photosites);
  struct Level {
    double electrons, spatial_e2, sigma_e2;
  };
  const auto level = [&](double electrons, std::uint64_t from) {
    const Stack s = stack(flat, unit, electrons, frames, from);
    const double left = s.left_variance / (k * k);
    const double spatial = variance_of(s.mean) / (k * k) - left;
    // The variance of (map + noise) over n photosites, the map given: noise squared, and map times
    // noise.
    const double sigma =
        std::sqrt((2 * left * left + 4 * spatial * left) / static_cast<double>(s.mean.size()));
    return Level{mean_of(s.mean) / k - dark_electrons(flat.photosites), spatial, sigma};
  };
  const Level low = level(lowest_electrons(flat.photosites), seed);
  const Level high = level(0.5 * flat.photosites.full_well_e, seed + 1000);
  const double low2 = low.electrons * low.electrons, high2 = high.electrons * high.electrons;

  FixedPattern result;
  const double prnu2 = (high.spatial_e2 - low.spatial_e2) / (high2 - low2);
  const double dsnu2_e2 = low.spatial_e2 - prnu2 * low2;
  result.prnu = std::sqrt(prnu2);
  result.dsnu_e = std::sqrt(dsnu2_e2);
  const double prnu2_sigma = std::hypot(high.sigma_e2, low.sigma_e2) / (high2 - low2);
  result.prnu_sigma = prnu2_sigma / (2 * result.prnu);
  result.dsnu_sigma_e = std::hypot(low.sigma_e2, prnu2_sigma * low2) / (2 * result.dsnu_e);
  result.true_prnu = std::sqrt(variance_of(green_values(flat, prnu_map(flat, unit))));
  const std::vector<double> offsets = green_values(flat, dsnu_map(flat, unit));
  result.true_dsnu_e = std::sqrt(variance_of(offsets));
  result.photosites = static_cast<std::int64_t>(offsets.size());
  return result;
}

double vignetting_deviation(const CameraSensorConfig& config, int frames, std::uint64_t seed) {
  CameraSensorConfig flat = flat_camera(config);
  flat.lens.optics = config.lens.optics;
  const CameraUnit unit = make_camera_unit(flat, Rng(seed));
  const Camera& camera = unit.lens.at_infinity;
  // Half of full well on the axis, so that nothing clips.
  const Stack shaded = stack(flat, unit, 0.5 * flat.photosites.full_well_e, frames, seed + 1);
  const double dark = dark_electrons(flat.photosites) * codes_per_electron(flat.photosites);
  constexpr int kRings = 16;
  const Image<float> prnu = prnu_map(flat, unit);
  std::array<double, kRings> measured{}, expected{};
  std::size_t i = 0;
  const double half_diagonal = 0.5 * std::hypot(flat.width_px, flat.height_px);
  for (int y = 0; y < flat.height_px; ++y) {
    for (int x = 0; x < flat.width_px; ++x) {
      if (!is_green(flat, x, y)) continue;
      const double r = std::hypot(x - camera.cx_px, y - camera.cy_px) / half_diagonal;
      const auto ring = static_cast<std::size_t>(std::min(kRings * r, kRings - 1.0));
      measured[ring] += shaded.mean[i++] - dark;
      expected[ring] +=
          vignetting_gain(flat.lens.optics, camera, x, y) * static_cast<double>(prnu(x, y));
    }
  }
  double largest = 0;
  for (std::size_t ring = 1; ring < kRings; ++ring) {
    const double ratio = measured[ring] / measured[0] / (expected[ring] / expected[0]);
    largest = std::max(largest, std::abs(ratio - 1));
  }
  return largest;
}

}  // namespace cousin
