#include "benchmarks/tools/fit_sensor/hidden_device.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "benchmarks/score/distributions.h"
#include "benchmarks/tools/fit_sensor/model_curves.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

std::string two_digits(double value) {
  char out[32];
  std::snprintf(out, sizeof out, "%.2f", value);
  return out;
}

CameraSensorConfig draw_camera(Rng rng) {
  CameraSensorConfig camera;
  camera.width_px = 320;
  camera.height_px = 240;
  camera.lens.model = LensModel::pinhole;
  PhotositesConfig& p = camera.photosites;
  p.electrons_at_unit_radiance = 1000;
  p.bits = 12;
  p.black_level = 100;
  p.full_well_e = uniform(rng, 5000, 12000);
  p.read_noise_e = uniform(rng, 2.5, 8);
  p.row_noise_e = uniform(rng, 0, 0.5);
  p.prnu = 0.01;
  p.dsnu_e = uniform(rng, 0.5, 2);
  return camera;
}

/// A wall that bends like a parabola across the view.
void bend(DepthModelInputs& inputs, double bend_m) {
  const double half = 0.5 * inputs.depth_m.width();
  for (int y = 0; y < inputs.depth_m.height(); ++y) {
    for (int x = 0; x < inputs.depth_m.width(); ++x) {
      const double u = (x + 0.5 - half) / half;
      inputs.depth_m(x, y) += static_cast<float>(bend_m * u * u);
    }
  }
}

WallFrames record_wall(const HiddenDevice& device, const RecordingPlan& plan, double z_m,
                       const Rng& rng) {
  auto config = std::make_shared<ActiveStereoConfig>(device.config);
  const double off_law = std::pow(
      z_m / std::sqrt(plan.distances_m.front() * plan.distances_m.back()), plan.noise_exponent - 2);
  set_even_noise(config->model, off_law * spatial_px_at(device, z_m),
                 off_law * temporal_px_at(device, z_m), fill_at(device, z_m),
                 device.config.model.ripple_px.front());
  const PlaneBefore plane{z_m, 0.5 * plan.turn_rad, plan.turn_rad, 0.5, 0.02};
  auto inputs = std::make_shared<DepthModelInputs>(plane_inputs(plane, *config));
  if (plan.bend_m != 0) bend(*inputs, plan.bend_m);
  Rng tape = rng.fork("tape");
  const double stated_m = z_m + plan.tape_sigma_m * normal(tape);
  return {"wall_" + two_digits(z_m) + "m",
          stated_m,
          plan.tape_sigma_m,
          0.5,
          0.02,
          plan.frames,
          [config, inputs, rng](int k) {
            return model_depth(*inputs, *config, rng.fork("fixed"),
                               rng.fork("frame").fork(static_cast<std::uint64_t>(k)))
                .depth;
          }};
}

FlatFrames record_flat(const HiddenDevice& device, const std::string& name, double electrons,
                       const Rng& rng) {
  const CameraSensorConfig& camera = device.camera;
  const auto unit =
      std::make_shared<CameraUnit>(make_camera_unit(camera, Rng(1).fork("hidden camera")));
  const auto radiance =
      static_cast<float>(electrons / camera.photosites.electrons_at_unit_radiance);
  return {name, 4, [camera, unit, radiance, rng](int k) {
            return expose(
                Image<Rgbf>(camera.width_px, camera.height_px, {radiance, radiance, radiance}),
                camera, *unit, unit->lens.at_infinity, rng.fork(static_cast<std::uint64_t>(k)));
          }};
}

}  // namespace

double spatial_px_at(const HiddenDevice& device, double z_m) {
  return device.spatial_px * std::pow(z_m, device.spatial_exponent);
}
double temporal_px_at(const HiddenDevice& device, double z_m) {
  return device.temporal_px * std::pow(z_m, device.temporal_exponent);
}
double fill_at(const HiddenDevice& device, double z_m) {
  return 1 / (1 + std::pow(z_m / device.half_fill_m, device.fill_power));
}

HiddenDevice draw_hidden_device(const std::string& rig, const Rng& rng) {
  HiddenDevice device;
  device.config = active_stereo_preset(rig);
  Rng draw = rng.fork("depth");
  device.spatial_px = uniform(draw, 0.05, 0.11);
  device.spatial_exponent = uniform(draw, -0.1, 0.2);
  device.temporal_px = uniform(draw, 0.02, 0.06);
  device.temporal_exponent = uniform(draw, 0.2, 1);
  device.half_fill_m = uniform(draw, 4, 7);
  device.fill_power = uniform(draw, 3, 5);
  device.config.model.ripple_px.assign(device.config.model.contrast.size(),
                                       uniform(draw, 0.01, 0.06));
  device.config.model.bias_px = uniform(draw, -0.04, 0.04);
  device.config.model.grain_px = uniform(draw, 3, 7);
  device.camera = draw_camera(rng.fork("camera"));
  return device;
}

RecordedFrames record(const HiddenDevice& device, const RecordingPlan& plan, const Rng& rng) {
  RecordedFrames out;
  for (const double z : plan.distances_m)
    out.walls.push_back(record_wall(device, plan, z, rng.fork(two_digits(z))));
  if (plan.flats == 0) return out;
  const PhotositesConfig& p = device.camera.photosites;
  out.max_code = (1 << p.bits) - 1;
  out.dark = record_flat(device, "dark", 0, rng.fork("dark"));
  for (int i = 0; i < plan.flats; ++i) {
    const double share = plan.brightest * (i + 1) / plan.flats;
    out.flats.push_back(record_flat(device, "flat_" + std::to_string(i), share * p.full_well_e,
                                    rng.fork("flat").fork(static_cast<std::uint64_t>(i))));
  }
  return out;
}

DepthGeometry geometry_of(const HiddenDevice& device, const RecordingPlan& plan) {
  Recordings recordings;
  recordings.walls.push_back({.name = {}, .distance_m = plan.distances_m.front(), .files = {}});
  RigChoice rig{"hidden", {}, device.config, {}};
  const Camera camera = depth_camera(device.config);
  return depth_geometry(recordings, rig, camera.width_px, camera.height_px);
}

void write_recordings(const std::filesystem::path& folder, const RecordedFrames& frames,
                      const HiddenDevice& device, const RecordingPlan& plan) {
  const auto write = [&](const std::string& name, int count, const auto& frame) {
    for (int k = 0; k < count; ++k) {
      char file[32];
      std::snprintf(file, sizeof file, "%03d.png", k);
      write_png(folder / name / file, frame(k));
    }
  };
  std::string toml = "depth_unit_m = " + std::to_string(device.config.depth_unit_m) +
                     "\ndistance_sigma_m = " + std::to_string(plan.tape_sigma_m) + "\n";
  if (frames.dark) toml += "color_bits = " + std::to_string(device.camera.photosites.bits) + "\n";
  for (const WallFrames& wall : frames.walls) {
    write(wall.name, wall.count, wall.frame);
    toml += "[\"" + wall.name + "\"]\ndistance_m = " + std::to_string(wall.distance_m) + "\n";
  }
  if (frames.dark) write("dark", frames.dark->count, frames.dark->frame);
  for (const FlatFrames& flat : frames.flats) write(flat.name, flat.count, flat.frame);
  write_file(folder / "recordings.toml", toml);
}

std::vector<HiddenParameter> hidden_parameters(const HiddenDevice& device, const SensorFit& fit) {
  std::vector<HiddenParameter> out;
  if (fit.depth && !fit.depth->held_out.empty()) {
    const DepthFit& d = *fit.depth;
    const double z = d.reference_m, s = spatial_px_at(device, z), t = temporal_px_at(device, z);
    const double share = s * s / (s * s + t * t);
    out.push_back({"sigma_d", "px", std::hypot(s, t), d.sigma_d_px});
    out.push_back({"sigma_z_exponent", "1",
                   2 + share * device.spatial_exponent + (1 - share) * device.temporal_exponent,
                   d.sigma_z_exponent});
    const auto law = [&](const std::string& name, const PowerLaw& l, double value,
                         double exponent) {
      const double sigma = std::sqrt(l.covariance(0, 0)), slope = std::sqrt(l.covariance(1, 1));
      out.push_back({name,
                     "px",
                     value,
                     {std::exp(l.log_value), std::exp(l.log_value - kSigmas95 * sigma),
                      std::exp(l.log_value + kSigmas95 * sigma)}});
      out.push_back({name + "_exponent",
                     "1",
                     exponent,
                     {l.exponent, l.exponent - kSigmas95 * slope, l.exponent + kSigmas95 * slope}});
    };
    law("spatial_d", d.spatial, s, device.spatial_exponent);
    if (d.temporal_solved) law("temporal_d", d.temporal, t, device.temporal_exponent);
    if (d.ripple_solved)
      out.push_back(
          {"ripple_d", "px", std::abs(device.config.model.ripple_px.front()), d.ripple_px});
    if (d.bias_solved) out.push_back({"bias_d", "px", device.config.model.bias_px, d.bias_px});
    out.push_back({"scale", "1", 1, d.scale});
    for (const WallStatistics& w : d.walls) {
      out.push_back({"fill, " + w.name,
                     "1",
                     fill_at(device, w.depth_m),
                     {w.fill.value, w.fill.value - kSigmas95 * w.fill.sigma,
                      std::min(1.0, w.fill.value + kSigmas95 * w.fill.sigma)}});
    }
  }
  if (fit.gain && fit.gain->gain.value > 0) {
    const PhotositesConfig& p = device.camera.photosites;
    out.push_back({"gain", "DN/e", codes_per_electron(p), fit.gain->gain});
    if (fit.gain->read_noise_solved)
      out.push_back({"read_noise", "e",
                     std::sqrt(p.read_noise_e * p.read_noise_e + p.row_noise_e * p.row_noise_e +
                               dark_electrons(p)),
                     fit.gain->read_noise_e});
  }
  return out;
}

bool is_inside(const HiddenParameter& p) {
  return p.truth >= p.estimate.low && p.truth <= p.estimate.high;
}

}  // namespace cousin
