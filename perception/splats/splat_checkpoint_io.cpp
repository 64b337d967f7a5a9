#include "perception/splats/splat_checkpoint_io.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim/dataset/byte_reader.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/sealed_file.h"

namespace cousin {
namespace {

constexpr std::string_view kFirstLine = "cousin splat training 4";
constexpr int kMostSteps = 1'000'000;     ///< as of a configuration
constexpr std::size_t kFingerprint = 64;  ///< characters

std::string hash_of(const Image<float>& image) {
  return sha256_hex({reinterpret_cast<const char*>(image.data()), image.size() * sizeof(float)});
}

void add_camera(ByteWriter& bytes, const Camera& camera, const Pose& pose) {
  bytes.add(camera.width_px).add(camera.height_px);
  bytes.add(camera.fx_px).add(camera.fy_px).add(camera.cx_px).add(camera.cy_px);
  bytes.add(pose.rotation.coeffs().data(), 4 * sizeof(double));
  bytes.add(pose.translation_m.data(), 3 * sizeof(double));
}

void add_config(ByteWriter& bytes, const SplatTrainConfig& c) {
  bytes.add(c.steps).add(c.sh_degree).add(c.sh_degree_every).add(c.seed).add(c.report_every);
  for (const float value : c.background) bytes.add(value);
  bytes.add(c.any_background).add(c.ssim_share).add(c.near).add(c.low_pass_px2);
  const SplatRates& r = c.rates;
  bytes.add(r.centre_first).add(r.centre_last).add(r.log_scale).add(r.rotation).add(r.opacity);
  bytes.add(r.dc).add(r.rest).add(r.decay);
  bytes.add(c.rest_every).add(c.quarter_until).add(c.half_until);
  bytes.add(static_cast<int>(c.growth)).add(c.most_splats).add(c.grow_every).add(c.grow_from);
  bytes.add(c.grow_until).add(c.growth_power).add(c.gradient_limit).add(c.split_size);
  bytes.add(c.least_opacity).add(c.largest_size).add(c.reset_every).add(c.noise);
  bytes.add(c.opacity_pull).add(c.scale_pull);
}

void add_planes(ByteWriter& bytes, const SplatPlanes& planes) {
  std::vector<float> row(static_cast<std::size_t>(planes.size()));
  for (int k = 0; k < planes.planes(); ++k) {
    for (int i = 0; i < planes.size(); ++i) row[static_cast<std::size_t>(i)] = planes.at(k, i);
    bytes.add(row.data(), sizeof(float) * row.size());
  }
}

SplatPlanes take_planes(ByteReader& reader, int size) {
  SplatPlanes planes(SplatPlane::count, size);
  std::vector<float> row(static_cast<std::size_t>(size));
  for (int k = 0; k < planes.planes(); ++k) {
    reader.take(row.data(), sizeof(float) * row.size());
    for (int i = 0; i < size; ++i) planes.at(k, i) = row[static_cast<std::size_t>(i)];
  }
  return planes;
}

/// @throws std::runtime_error for one that is out of its limits
void take_counts(ByteReader& reader, const std::string& name, int most_splats,
                 SavedTraining& saved) {
  SplatTrainState& state = saved.state;
  saved.loss_sum = reader.take<double>();
  saved.loss_count = reader.take<int>();
  saved.blind = reader.take<int>();
  state.step = reader.take<int>();
  state.rest_updates = reader.take<int>();
  state.started_with = reader.take<int>();
  const auto within = [&](const char* what, int value, int low, int high) {
    if (value >= low && value <= high) return;
    throw std::runtime_error(name + ": " + what + " = " + std::to_string(value) + " is not in " +
                             std::to_string(low) + ".." + std::to_string(high));
  };
  within("step", state.step, 1, kMostSteps);
  within("rest_updates", state.rest_updates, 0, state.step);
  within("loss_count", saved.loss_count, 0, state.step);
  within("blind", saved.blind, 0, state.step);
  within("started_with", state.started_with, 1, most_splats);
}

/// Takes the near depths and checks them with the origin and the extent, which come before.
/// @throws std::runtime_error naming what is wrong
void take_near_depths(ByteReader& reader, const std::string& name, int views,
                      SplatTrainState& state) {
  if (views < 0 || static_cast<std::size_t>(views) * sizeof(double) > reader.left()) {
    throw std::runtime_error(name + ": " + std::to_string(views) +
                             " views do not fit the checkpoint's size");
  }
  state.near_m.resize(static_cast<std::size_t>(views));
  reader.take(state.near_m.data(), state.near_m.size() * sizeof(double));
  const auto is_near = [](double near_m) { return near_m >= 0 && std::isfinite(near_m); };
  if (!state.origin_in_world_m.allFinite() || !(state.extent_m >= 0) ||
      !std::isfinite(state.extent_m) ||
      !std::all_of(state.near_m.begin(), state.near_m.end(), is_near)) {
    throw std::runtime_error(name +
                             ": the origin, the extent or a near depth is not finite, or negative");
  }
}

void take_curve(ByteReader& reader, int points, std::vector<SplatTrainPoint>& curve) {
  for (int i = 0; i < points; ++i) {
    SplatTrainPoint p;
    p.step = reader.take<int>();
    p.wall_s = reader.take<double>();
    p.cpu_s = reader.take<double>();
    p.loss = reader.take<double>();
    p.splats = reader.take<int>();
    curve.push_back(p);
  }
}

}  // namespace

std::string training_fingerprint(std::span<const SplatView> views, const SplatModel& start,
                                 const SplatTrainConfig& config) {
  ByteWriter bytes;
  add_config(bytes, config);
  for (const SplatView& view : views) {
    add_camera(bytes, view.full.camera, view.camera_from_world);
    for (const Image<float>& channel : view.full.color.channel) bytes.text += hash_of(channel);
    bytes.text += hash_of(view.full.weight) + hash_of(view.full.behind);
  }
  bytes.add(start.origin_in_world_m.data(), 3 * sizeof(double));
  add_planes(bytes, to_planes(start.splats));
  return sha256_hex(bytes.text);
}

void write_training(const std::filesystem::path& file, const SavedTraining& saved) {
  ByteWriter bytes;
  bytes.text.append(kFirstLine).append("\n").append(saved.fingerprint);
  const SplatTrainState& state = saved.state;
  bytes.add(saved.loss_sum).add(saved.loss_count).add(saved.blind);
  bytes.add(state.step).add(state.rest_updates).add(state.started_with);
  bytes.add(state.origin_in_world_m.data(), 3 * sizeof(double));
  bytes.add(state.extent_m).add(saved.wall_s).add(saved.cpu_s);
  bytes.add(state.values.size()).add(static_cast<int>(saved.curve.size()));
  bytes.add(static_cast<int>(state.near_m.size()));
  bytes.add(state.near_m.data(), state.near_m.size() * sizeof(double));
  for (const SplatTrainPoint& p : saved.curve) {
    bytes.add(p.step).add(p.wall_s).add(p.cpu_s).add(p.loss).add(p.splats);
  }
  add_planes(bytes, state.values);
  add_planes(bytes, state.first_moment);
  add_planes(bytes, state.second_moment);
  const std::size_t row = sizeof(float) * static_cast<std::size_t>(state.values.size());
  bytes.add(state.gradient_sum.data(), row).add(state.gradient_count.data(), row);
  write_sealed(file, std::move(bytes.text));
}

SavedTraining read_training(const std::filesystem::path& file, int most_splats) {
  const std::string name = file.string();
  const std::size_t a_splat = (3 * SplatPlane::count + 2) * sizeof(float);
  const std::size_t limit =
      static_cast<std::size_t>(most_splats) * a_splat + (std::size_t{1} << 26);
  const std::string body = read_sealed(file, kFirstLine, "checkpoint of a splat training", limit);
  ByteReader reader(body, name);
  SavedTraining saved;
  saved.fingerprint.resize(kFingerprint);
  reader.take(saved.fingerprint.data(), kFingerprint);
  SplatTrainState& state = saved.state;
  take_counts(reader, name, most_splats, saved);
  reader.take(state.origin_in_world_m.data(), 3 * sizeof(double));
  state.extent_m = reader.take<double>();
  saved.wall_s = reader.take<double>();
  saved.cpu_s = reader.take<double>();
  const int size = reader.take<int>();
  const int points = reader.take<int>();
  const int views = reader.take<int>();
  take_near_depths(reader, name, views, state);
  const std::size_t bytes_a_point = 2 * sizeof(int) + 3 * sizeof(double);
  if (size < 0 || points < 0 ||
      static_cast<std::size_t>(size) * a_splat + static_cast<std::size_t>(points) * bytes_a_point !=
          reader.left()) {
    throw std::runtime_error(name + ": " + std::to_string(size) + " splats and " +
                             std::to_string(points) + " points do not fit the checkpoint's size");
  }
  take_curve(reader, points, saved.curve);
  state.values = take_planes(reader, size);
  hide_padding(state.values);
  state.first_moment = take_planes(reader, size);
  state.second_moment = take_planes(reader, size);
  const std::size_t row = sizeof(float) * static_cast<std::size_t>(size);
  state.gradient_sum.assign(static_cast<std::size_t>(state.values.padded()), 0);
  state.gradient_count.assign(static_cast<std::size_t>(state.values.padded()), 0);
  reader.take(state.gradient_sum.data(), row);
  reader.take(state.gradient_count.data(), row);
  return saved;
}

}  // namespace cousin
