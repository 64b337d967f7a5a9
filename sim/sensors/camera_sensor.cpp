#include "sim/sensors/camera_sensor.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "sim/sensors/photosites.h"

namespace cousin {
namespace {

/// Rec. 709 luminance: a grey photosite's share of each colour.
const Eigen::Vector3f kGrey(0.2126F, 0.7152F, 0.0722F);

/// Signal of each kind of photosite (a row each) from linear sRGB, green white = 1.
Eigen::Matrix3f photosite_colours(const PhotositesConfig& p) {
  if (p.mosaic == Mosaic::grey) return Eigen::Vector3f::Ones() * kGrey.transpose();
  const Eigen::Vector3d sensitivity(p.sensitivity_red, 1, p.sensitivity_blue);
  const Eigen::Matrix3d camera_from_srgb = srgb_from_camera(p).inverse();
  return (sensitivity.asDiagonal() * camera_from_srgb).cast<float>();
}

/// The unit's columns' offsets, in electrons.
std::vector<float> column_offsets(const CameraSensorConfig& config, const CameraUnit& unit) {
  std::vector<float> offsets(static_cast<std::size_t>(config.width_px));
  fixed_pattern_row(offsets, 0, config.photosites.column_dsnu_e, unit.column_dsnu);
  return offsets;
}

void dsnu_row(const CameraSensorConfig& config, const CameraUnit& unit,
              std::span<const float> columns, int y, std::span<float> row) {
  const auto index = static_cast<std::uint64_t>(y);
  fixed_pattern_row(row, 0, config.photosites.dsnu_e, unit.dsnu.fork(index));
  float line = 0;
  fixed_pattern_row({&line, 1}, 0, config.photosites.row_dsnu_e, unit.row_dsnu.fork(index));
  for (std::size_t x = 0; x < row.size(); ++x) row[x] += columns[x] + line;
}

void require_size(const Image<Rgbf>& radiance, const CameraSensorConfig& config) {
  if (radiance.width() == config.width_px && radiance.height() == config.height_px) return;
  throw std::invalid_argument("camera: radiance is " + std::to_string(radiance.width()) + " x " +
                              std::to_string(radiance.height()) + ", the preset " +
                              std::to_string(config.width_px) + " x " +
                              std::to_string(config.height_px));
}

}  // namespace

CameraUnit make_camera_unit(const CameraSensorConfig& config, const Rng& rng) {
  validate(config);
  CameraUnit unit;
  const LensConfig& lens = config.lens;
  unit.lens =
      draw_lens(nominal_camera(config),
                {.centre_px = lens.principal_offset_px_per_width * config.width_px,
                 .report_focal = lens.report_focal_error,
                 .report_centre_px = lens.report_centre_error_px_per_width * config.width_px,
                 .report_distortion = lens.report_distortion_error},
                rng);
  unit.prnu = rng.fork("prnu");
  unit.dsnu = rng.fork("dsnu");
  unit.column_dsnu = rng.fork("column_dsnu");
  unit.row_dsnu = rng.fork("row_dsnu");
  return unit;
}

Image<float> prnu_map(const CameraSensorConfig& config, const CameraUnit& unit) {
  Image<float> map(config.width_px, config.height_px);
  tbb::parallel_for(0, config.height_px, [&](int y) {
    fixed_pattern_row(map.row(y), 1, config.photosites.prnu,
                      unit.prnu.fork(static_cast<std::uint64_t>(y)));
  });
  return map;
}

Image<float> dsnu_map(const CameraSensorConfig& config, const CameraUnit& unit) {
  Image<float> map(config.width_px, config.height_px);
  const std::vector<float> columns = column_offsets(config, unit);
  tbb::parallel_for(0, config.height_px,
                    [&](int y) { dsnu_row(config, unit, columns, y, map.row(y)); });
  return map;
}

FocusedLens focused_lens(const CameraSensorConfig& config, const CameraUnit& unit,
                         double distance_m, const Rng& rng) {
  const LensConfig& lens = config.lens;
  if (!lens.autofocus) {
    const double infinity = std::numeric_limits<double>::infinity();
    return {unit.lens.at_infinity, lens.focus_m > 0 ? lens.focus_m : infinity};
  }
  Rng focus = rng.fork("focus");
  const double found_m = distance_m * (1 + truncated_normal(focus, 0, lens.focus_error));
  return {with_focus(unit.lens.at_infinity, focus_breathing(lens.focal_m, found_m)), found_m};
}

Camera reported_camera(const CameraSensorConfig& config, const CameraUnit& unit, const Camera& now,
                       const Rng& rng) {
  return report_at_focus(unit.lens, now, config.lens.focal_m, config.lens.report_focus_error, rng);
}

double electrons_per_radiance(const CameraSensorConfig& config, const Image<Rgbf>& radiance) {
  const PhotositesConfig& p = config.photosites;
  if (p.electrons_at_unit_radiance > 0) return p.electrons_at_unit_radiance;
  const Eigen::Matrix3f colours = photosite_colours(p);
  // Every second pixel of every second row is plenty for a quantile.
  std::vector<float> brightest;
  brightest.reserve(radiance.size() / 4 + 1);
  for (int y = 0; y < radiance.height(); y += 2) {
    const auto row = radiance.row(y);
    for (std::size_t x = 0; x < row.size(); x += 2) {
      const Eigen::Vector3f signal = colours * Eigen::Vector3f(row[x].r, row[x].g, row[x].b);
      brightest.push_back(signal.maxCoeff());
    }
  }
  return auto_exposure_electrons(std::move(brightest), p.full_well_e);
}

Image<std::uint16_t> expose(const Image<Rgbf>& radiance, const CameraSensorConfig& config,
                            const CameraUnit& unit, const Camera& camera, const Rng& rng) {
  require_size(radiance, config);
  const PhotositesConfig& p = config.photosites;
  const Optics& optics = config.lens.optics;
  const std::vector<float> weights = gaussian_weights(optics.blur_sigma_px);
  const Image<Rgbf> shaded = shade_and_blur_rows(radiance, optics, camera, weights, "camera");
  const Eigen::Matrix3f colours = photosite_colours(p);
  const std::vector<float> columns = column_offsets(config, unit);

  Exposure exposure;
  exposure.electrons = static_cast<float>(electrons_per_radiance(config, radiance));
  exposure.dark_e = static_cast<float>(dark_electrons(p));
  exposure.read_variance = static_cast<float>(p.read_noise_e * p.read_noise_e);
  exposure.codes_per_e = static_cast<float>(codes_per_electron(p));
  exposure.black_code = static_cast<float>(p.black_level);
  exposure.max_code = static_cast<float>((1 << p.bits) - 1);

  Image<std::uint16_t> codes(config.width_px, config.height_px);
  tbb::parallel_for(
      tbb::blocked_range<int>(0, config.height_px, 16), [&](const tbb::blocked_range<int>& rows) {
        std::vector<float> light;
        std::vector<float> signal(columns.size()), prnu(columns.size()), dsnu(columns.size());
        for (int y = rows.begin(); y < rows.end(); ++y) {
          const auto index = static_cast<std::uint64_t>(y);
          blurred_row(shaded, weights, y, light);
          for (std::size_t x = 0; x < signal.size(); ++x) {
            const int channel = bayer_channel(p.mosaic, static_cast<int>(x), y);
            const Eigen::Map<const Eigen::Vector3f> rgb(&light[3 * x]);
            signal[x] = colours.row(channel).dot(rgb);
          }
          fixed_pattern_row(prnu, 1, p.prnu, unit.prnu.fork(index));
          dsnu_row(config, unit, columns, y, dsnu);
          Exposure of_row = exposure;
          Rng row_rng = rng.fork(index);
          if (p.row_noise_e > 0) {
            Rng offset = row_rng.fork("row_noise");
            of_row.offset_e = static_cast<float>(p.row_noise_e * normal(offset));
          }
          expose_row(signal, prnu.data(), dsnu.data(), of_row, row_rng, codes.row(y).data());
        }
      });
  return codes;
}

SensorFrame sense(const Image<Rgbf>& radiance, const CameraSensorConfig& config,
                  const CameraUnit& unit, const TrueView& view, const Rng& rng) {
  Image<std::uint16_t> raw = expose(radiance, config, unit, view.camera, rng);
  SensorFrame frame;
  frame.color = develop(raw, config);
  if (config.develop.raw) frame.raw = std::move(raw);
  frame.reported = reported_camera(config, unit, view.camera, rng);
  return frame;
}

SensorReport report_of(const CameraSensorConfig& config, const CameraUnit& unit,
                       const std::string& name, const Pose& sensor_from_rig) {
  const PhotositesConfig& p = config.photosites;
  SensorReport report;
  report.name = name;
  report.camera = unit.lens.reported_at_infinity;
  report.sensor_from_rig = sensor_from_rig;
  report.exposure_s = p.exposure_s;
  report.shutter = p.readout_s > 0 ? Shutter::rolling : Shutter::global;
  report.readout_s = p.readout_s;
  report.linear_raw = config.develop.raw;
  if (config.develop.raw) report.raw_format = {p.mosaic, p.bits, p.black_level};
  return report;
}

double code_variance(const PhotositesConfig& p, double electrons) {
  const double k = codes_per_electron(p);
  const double counted = std::min(std::max(electrons, 0.0) + dark_electrons(p), p.full_well_e);
  return k * k * (counted + p.read_noise_e * p.read_noise_e + p.row_noise_e * p.row_noise_e) +
         1.0 / 12;
}

}  // namespace cousin
