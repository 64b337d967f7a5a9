#include "perception/ngp/ngp_file.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "perception/ngp/ngp_rays.h"
#include "sim/dataset/byte_reader.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/sealed_file.h"

namespace cousin {
namespace {

constexpr std::string_view kModelLine = "cousin radiance field 1";
constexpr std::string_view kTrainingLine = "cousin radiance field training 1";
constexpr std::size_t kFingerprint = 64;                   ///< characters
constexpr std::size_t kMostBytes = std::size_t{1} << 32;   ///< of a file
constexpr std::size_t kMostConfig = std::size_t{1} << 16;  ///< characters

void add_text(ByteWriter& bytes, std::string_view text) {
  bytes.add(text.size()).add(text.data(), text.size());
}

std::string take_text(ByteReader& reader, std::size_t most) {
  const std::string where = reader.where();
  const auto size = static_cast<std::size_t>(reader.count(1));
  if (size > most)
    throw std::runtime_error(where + "a text of " + std::to_string(size) + " characters; at most " +
                             std::to_string(most));
  std::string text(size, '\0');
  reader.take(text.data(), size);
  return text;
}

template <class Number>
void add_numbers(ByteWriter& bytes, const std::vector<Number>& numbers) {
  bytes.add(numbers.size()).add(numbers.data(), numbers.size() * sizeof(Number));
}

/// As many as there must be.
template <class Number>
std::vector<Number> take_numbers(ByteReader& reader, std::size_t wanted, const char* what) {
  const std::string where = reader.where();
  const std::uint64_t count = reader.count(sizeof(Number));
  if (count != wanted)
    throw std::runtime_error(where + std::to_string(count) + " numbers of the " + what +
                             "; the configuration asks for " + std::to_string(wanted));
  std::vector<Number> numbers(wanted);
  reader.take(numbers.data(), wanted * sizeof(Number));
  return numbers;
}

void add_model(ByteWriter& bytes, const NgpModel& model) {
  NgpConfig config = model.config;
  add_text(bytes, to_toml(fields(config)));
  bytes.add(model.volume.centre_in_world_m.data(), 3 * sizeof(double));
  bytes.add(model.volume.side_m);
  add_numbers(bytes, model.occupancy.thickness);
  add_numbers(bytes, model.occupancy.filled);
  add_numbers(bytes, model.table);
  add_numbers(bytes, model.weights);
}

NgpModel take_model(ByteReader& reader, const std::string& name) {
  NgpModel model;
  read_toml_text(take_text(reader, kMostConfig), name, fields(model.config), MissingKeys::error);
  try {
    validate(model.config);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(name + ": " + error.what());
  }
  const std::string where = reader.where();
  reader.take(model.volume.centre_in_world_m.data(), 3 * sizeof(double));
  model.volume.side_m = reader.take<double>();
  model.volume.cascades = model.config.cascades;
  if (!model.volume.centre_in_world_m.allFinite() || !(model.volume.side_m > 0) ||
      !std::isfinite(model.volume.side_m))
    throw std::runtime_error(where + "the cubes have no place or no finite side above 0");
  model.occupancy.resolution = model.config.occupancy_cells;
  const std::size_t cells =
      model.occupancy.cells_of_cube() * static_cast<std::size_t>(model.config.cascades);
  model.occupancy.thickness = take_numbers<float>(reader, cells, "thickness of cells");
  model.occupancy.filled = take_numbers<std::uint8_t>(reader, cells, "cells that are filled");
  model.table = take_numbers<float>(reader, ngp::table_size(ngp::grid_levels(model.config.grid)),
                                    "hash grid");
  model.weights = take_numbers<float>(reader, ngp::network_shape(model.config).size(), "networks");
  return model;
}

void nothing_more(const ByteReader& reader) {
  if (reader.left() > 0)
    throw std::runtime_error(reader.where() + std::to_string(reader.left()) + " bytes too many");
}

}  // namespace

std::string ngp_fingerprint(std::span<const NgpView> views, const NgpConfig& config) {
  ByteWriter bytes;
  NgpConfig copy = config;
  add_text(bytes, to_toml(fields(copy)));
  for (const NgpView& view : views) {
    const Camera& camera = view.camera;
    bytes.add(static_cast<int>(camera.model)).add(camera.width_px).add(camera.height_px);
    bytes.add(camera.fx_px).add(camera.fy_px).add(camera.cx_px).add(camera.cy_px);
    bytes.add(camera.distortion.data(), sizeof camera.distortion);
    bytes.add(camera.spline.order).add(camera.spline.columns).add(camera.spline.rows);
    bytes.add(camera.spline.fov_x_rad);
    add_numbers(bytes, camera.spline.delta_u);
    bytes.add(view.camera_from_world.rotation.coeffs().data(), 4 * sizeof(double));
    bytes.add(view.camera_from_world.translation_m.data(), 3 * sizeof(double));
    bytes.text += sha256_hex(
        {reinterpret_cast<const char*>(view.color.data()), view.color.size() * sizeof(Rgb8)});
    bytes.text += sha256_hex({reinterpret_cast<const char*>(view.mask.data()), view.mask.size()});
  }
  return sha256_hex(bytes.text);
}

void write_ngp(const std::filesystem::path& file, const NgpModel& model) {
  ByteWriter bytes;
  bytes.text.append(kModelLine).append("\n");
  add_model(bytes, model);
  write_sealed(file, std::move(bytes.text));
}

NgpModel read_ngp(const std::filesystem::path& file) {
  const std::string body = read_sealed(file, kModelLine, "radiance field", kMostBytes);
  ByteReader reader(body, file.string());
  NgpModel model = take_model(reader, file.string());
  nothing_more(reader);
  return model;
}

void write_ngp_training(const std::filesystem::path& file, const SavedNgpTraining& saved) {
  ByteWriter bytes;
  bytes.text.append(kTrainingLine).append("\n").append(saved.fingerprint);
  add_model(bytes, saved.model);
  const NgpTrainState& state = saved.state;
  bytes.add(state.iteration).add(state.rays).add(state.samples);
  for (const auto* moments :
       {&state.table_first, &state.table_second, &state.weights_first, &state.weights_second})
    add_numbers(bytes, *moments);
  bytes.add(saved.wall_s).add(saved.cpu_s).add(saved.loss_sum).add(saved.loss_count);
  bytes.add(saved.curve.size());
  for (const NgpPoint& p : saved.curve)
    bytes.add(p.iteration).add(p.wall_s).add(p.cpu_s).add(p.loss);
  write_sealed(file, std::move(bytes.text));
}

SavedNgpTraining read_ngp_training(const std::filesystem::path& file) {
  const std::string name = file.string();
  const std::string body =
      read_sealed(file, kTrainingLine, "checkpoint of a radiance field", kMostBytes);
  ByteReader reader(body, name);
  SavedNgpTraining saved;
  saved.fingerprint.resize(kFingerprint);
  reader.take(saved.fingerprint.data(), kFingerprint);
  saved.model = take_model(reader, name);
  NgpTrainState& state = saved.state;
  const std::string where = reader.where();
  state.iteration = reader.take<int>();
  state.rays = reader.take<int>();
  state.samples = reader.take<std::int64_t>();
  if (state.iteration < 1 || state.iteration > saved.model.config.iterations || state.rays < 1 ||
      state.rays > ngp::kMostRays)
    throw std::runtime_error(where + std::to_string(state.iteration) + " iterations of " +
                             std::to_string(saved.model.config.iterations) + ", " +
                             std::to_string(state.rays) + " rays");
  const std::size_t table = saved.model.table.size(), weights = saved.model.weights.size();
  state.table_first = take_numbers<float>(reader, table, "first moments of the hash grid");
  state.table_second = take_numbers<float>(reader, table, "second moments of the hash grid");
  state.weights_first = take_numbers<float>(reader, weights, "first moments of the networks");
  state.weights_second = take_numbers<float>(reader, weights, "second moments of the networks");
  saved.wall_s = reader.take<double>();
  saved.cpu_s = reader.take<double>();
  saved.loss_sum = reader.take<double>();
  saved.loss_count = reader.take<int>();
  const std::uint64_t points = reader.count(sizeof(int) + 3 * sizeof(double));
  for (std::uint64_t i = 0; i < points; ++i) {
    NgpPoint p;
    p.iteration = reader.take<int>();
    p.wall_s = reader.take<double>();
    p.cpu_s = reader.take<double>();
    p.loss = reader.take<double>();
    saved.curve.push_back(p);
  }
  nothing_more(reader);
  return saved;
}

}  // namespace cousin
