#include "benchmarks/tools/fit_sensor/sensor_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "benchmarks/tools/fit_sensor/model_curves.h"
#include "benchmarks/tools/fit_sensor/preset_patch.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void reject(const std::string& where, const std::string& what) {
  throw std::runtime_error(where + ": " + what);
}

std::string number(const char* format, double value) {
  char out[48];
  std::snprintf(out, sizeof out, format, value);
  return out;
}

std::string bracket(const WithInterval& v) {
  char out[80];
  std::snprintf(out, sizeof out, "95 %% [%.5g, %.5g]", v.low, v.high);
  return out;
}

/// "6 walls of 0.60 to 2.60 m, 12 frames each, in desk"
std::string data_words(const Recordings& r) {
  std::string words;
  if (!r.walls.empty()) {
    words = std::to_string(r.walls.size()) + " walls at " +
            number("%.2f", r.walls.front().distance_m) + " to " +
            number("%.2f m", r.walls.back().distance_m);
  }
  if (!r.flats.empty())
    words += (words.empty() ? "" : " and ") + std::to_string(r.flats.size()) + " flat fields";
  return words + " in " + fs::absolute(r.folder).lexically_normal().filename().string();
}

void require_enough(const Recordings& r) {
  if (!r.walls.empty() && r.walls.size() < static_cast<std::size_t>(kLeastWalls))
    reject(r.folder.string(), std::to_string(r.walls.size()) + " wall folders; at least " +
                                  std::to_string(kLeastWalls) + " distances are needed");
  for (const WallFolder& wall : r.walls) {
    if (wall.files.size() < static_cast<std::size_t>(kLeastFrames))
      reject((r.folder / wall.name).string(), std::to_string(wall.files.size()) +
                                                  " PNG frames; at least " +
                                                  std::to_string(kLeastFrames) + " are needed");
  }
  if (r.flats.empty() && r.dark.empty()) return;
  if (r.flats.size() < static_cast<std::size_t>(kLeastFlats))
    reject(r.folder.string(), std::to_string(r.flats.size()) + " flat_* folders; at least " +
                                  std::to_string(kLeastFlats) + " brightnesses are needed");
  const auto two = [&](const std::string& name, std::size_t count) {
    if (count < 2)
      reject((r.folder / name).string(),
             std::to_string(count) + " PNG frames; at least 2 are needed");
  };
  two("dark", r.dark.size());
  for (const FlatFolder& flat : r.flats) two(flat.name, flat.files.size());
}

void require_size(const fs::path& file, const Image<std::uint16_t>& image, int width, int height) {
  if (image.width() == width && image.height() == height) return;
  reject(file.string(), std::to_string(image.width()) + " x " + std::to_string(image.height()) +
                            " pixels; the first file has " + std::to_string(width) + " x " +
                            std::to_string(height));
}

/// A reader of the raw frames of a folder that holds all to the first one's bits.
FlatFrames flat_frames(const fs::path& folder, const std::vector<std::string>& files, int bits) {
  return {folder.filename().string(), static_cast<int>(files.size()), [folder, files, bits](int k) {
            const fs::path file = folder / files[static_cast<std::size_t>(k)];
            RawFrame frame = read_raw_frame(file);
            if (frame.bits != bits)
              reject(file.string(),
                     std::to_string(frame.bits) + " bits; the first has " + std::to_string(bits));
            return std::move(frame.codes);
          }};
}

RecordedFrames frames_of(const Recordings& r, const DepthGeometry& g,
                         const std::optional<PhotositesChoice>& photosites) {
  RecordedFrames out;
  for (const WallFolder& wall : r.walls) {
    out.walls.push_back({wall.name, wall.distance_m, wall.distance_sigma_m, wall.albedo, wall.light,
                         static_cast<int>(wall.files.size()),
                         [folder = r.folder / wall.name, files = wall.files, g](int k) {
                           const fs::path file = folder / files[static_cast<std::size_t>(k)];
                           Image<std::uint16_t> depth = read_depth_frame(file);
                           require_size(file, depth, g.width_px, g.height_px);
                           return depth;
                         }});
  }
  if (r.flats.empty()) return out;
  const int stored = read_raw_frame(r.folder / "dark" / r.dark.front()).bits;
  int bits = stored;
  if (r.color_bits > 0)
    bits = r.color_bits;
  else if (stored == 16 && photosites)
    bits = std::max(photosites->bits, 8);
  if (bits > stored)
    reject(r.folder.string(), "color_bits = " + std::to_string(bits) + ", but the PNG files of " +
                                  "dark/ store " + std::to_string(stored));
  out.max_code = (1 << bits) - 1;
  out.dark = flat_frames(r.folder / "dark", r.dark, stored);
  for (const FlatFolder& flat : r.flats)
    out.flats.push_back(flat_frames(r.folder / flat.name, flat.files, stored));
  return out;
}

/// What the raw frames say, as the photosites' keys.
void add_photosites(const SensorFit& fit, const RigChoice& rig, int max_code,
                    std::vector<PresetPatch>& patches, std::string& heading) {
  const GainFit& gain = *fit.gain;
  const auto photosites = photosites_choice(rig);
  const std::string words = "fitted: to " + fit.data + ", ";
  const double black = std::round(gain.black_code);
  const double span = max_code - black;
  if (!photosites) {
    heading += "# fitted: colour camera, K = " + number("%.5g", gain.gain.value) +
               " codes an electron, " + bracket(gain.gain);
    if (gain.read_noise_solved)
      heading += ", read noise " + number("%.4g e, ", gain.read_noise_e.value) +
                 bracket(gain.read_noise_e);
    heading += "; this preset has no keys for them\n";
    return;
  }
  const WithInterval well{span / gain.gain.value, span / gain.gain.high, span / gain.gain.low};
  patches.push_back({photosites->prefix + "full_well_e", number("%.1f", well.value),
                     words + bracket(well) + ", from K = " + number("%.5g", gain.gain.value) +
                         " codes an electron"});
  if (gain.read_noise_solved)
    patches.push_back({photosites->prefix + "read_noise_e", number("%.3f", gain.read_noise_e.value),
                       words + bracket(gain.read_noise_e) + ", with row noise and dark current"});
  patches.push_back({photosites->prefix + "black_level", number("%.0f", black),
                     words + "mean of the dark frames"});
  int bits = 0;
  while ((1 << bits) - 1 < max_code) ++bits;
  patches.push_back({photosites->prefix + "bits", std::to_string(bits), words + "as recorded"});
}

/// The mode recorded, and what recordings.toml says of the device.
void add_geometry(const DepthGeometry& g, const ActiveStereoConfig& c,
                  std::vector<PresetPatch>& patches) {
  const auto add = [&](const char* key, double before, double now, const char* format) {
    if (before != now)
      patches.push_back({key, number(format, now), "sourced: the recordings, as their user says"});
  };
  add("baseline_m", c.baseline_m, g.baseline_m, "%.9g");
  add("depth_unit_m", c.depth_unit_m, g.depth_unit_m, "%.9g");
  std::string focals;
  bool is_other = false;
  for (std::size_t i = 0; i < c.mode_columns.size(); ++i) {
    const bool is_mode = c.mode_columns[i] == g.width_px && c.mode_rows[i] == g.height_px;
    if (is_mode) add("columns", c.columns, g.width_px, "%.0f");
    is_other = is_other || (is_mode && c.mode_focal_px[i] != g.focal_px);
    focals +=
        (focals.empty() ? "" : ", ") + number("%.9g", is_mode ? g.focal_px : c.mode_focal_px[i]);
  }
  if (is_other)
    patches.push_back({"mode_focal_px", "[" + focals + "]",
                       "sourced: the recorded mode's, as the recordings' user says"});
}

/// The preset as it was recorded.
ActiveStereoConfig recorded_config(ActiveStereoConfig c, const DepthGeometry& g) {
  for (std::size_t i = 0; i < c.mode_columns.size(); ++i) {
    if (c.mode_columns[i] != g.width_px || c.mode_rows[i] != g.height_px) continue;
    c.columns = g.width_px;
    c.mode_focal_px[i] = g.focal_px;
  }
  c.baseline_m = g.baseline_m;
  c.depth_unit_m = g.depth_unit_m;
  return c;
}

/// The rig's preset with the fit's numbers; read back by the presets' own reader.
std::string fitted_preset(const SensorFit& fit, const RigChoice& rig, int max_code) {
  std::vector<PresetPatch> patches;
  std::string heading = "# Preset " + rig.name + " with numbers fitted to recordings (cousin " +
                        "fit-sensor): " + fit.data +
                        ".\n# Not validated: nobody measured what this "
                        "device sees by other means.\n";
  if (fit.depth) {
    add_geometry(fit.geometry, *rig.depth, patches);
    const ActiveStereoConfig recorded = recorded_config(*rig.depth, fit.geometry);
    for (const ModelCurves::Entry& e : model_curves(*fit.depth, recorded, "to " + fit.data).entries)
      patches.push_back({e.key, e.value, "fitted: " + e.words});
  }
  if (fit.gain) add_photosites(fit, rig, max_code, patches, heading);
  const std::string toml = heading + patched_preset(rig.toml, patches);
  if (rig.depth) {
    ActiveStereoConfig config;
    read_toml_text(toml, "fitted preset", fields(config), MissingKeys::error);
    validate(config);
  } else {
    rig_from_toml(toml, "fitted preset");
  }
  return toml;
}

}  // namespace

DepthGeometry depth_geometry(const Recordings& r, const RigChoice& rig, int width_px,
                             int height_px) {
  if (!rig.depth)
    reject(r.folder.string(), "wall folders, but rig \"" + rig.name + "\" has no depth camera");
  const ActiveStereoConfig& c = *rig.depth;
  DepthGeometry g{width_px,
                  height_px,
                  0,
                  r.baseline_m.value_or(c.baseline_m),
                  r.depth_unit_m.value_or(c.depth_unit_m),
                  c.disparity_step_px,
                  {}};
  std::string modes;
  for (std::size_t i = 0; i < c.mode_columns.size(); ++i) {
    if (c.mode_columns[i] == width_px && c.mode_rows[i] == height_px)
      g.focal_px = c.mode_focal_px[i];
    modes += (modes.empty() ? "" : ", ") + number("%.0f x ", c.mode_columns[i]) +
             number("%.0f", c.mode_rows[i]);
  }
  if (r.focal_px) g.focal_px = *r.focal_px;
  if (!(g.focal_px > 0))
    reject(r.folder.string(), "depth images of " + std::to_string(width_px) + " x " +
                                  std::to_string(height_px) + " pixels are no mode of rig \"" +
                                  rig.name + "\" (" + modes +
                                  "); give focal_px in recordings.toml");
  // The middle half, right of the band that the right imager does not see at the nearest wall.
  const double most_px =
      r.walls.empty() ? 0 : g.focal_px * g.baseline_m / r.walls.front().distance_m;
  const int left = std::max(width_px / 4, static_cast<int>(most_px) + 16);
  g.region = r.region.value_or(
      ImageRegion{left, height_px / 4, std::max(0, 3 * width_px / 4 - left), height_px / 2});
  const ImageRegion& p = g.region;
  if (p.x < 0 || p.y < 0 || p.width < 16 || p.height < 16 || p.x + p.width > width_px ||
      p.y + p.height > height_px)
    reject(r.folder.string(),
           "the region of " + std::to_string(p.width) + " x " + std::to_string(p.height) +
               " pixels at " + std::to_string(p.x) + ", " + std::to_string(p.y) +
               " is not at least 16 x 16 within the image of " + std::to_string(width_px) + " x " +
               std::to_string(height_px) + "; give region_px in recordings.toml");
  return g;
}

SensorFit fit_frames(const RecordedFrames& frames, const DepthGeometry& geometry,
                     const RigChoice& rig, const std::string& data,
                     const std::function<void(const std::string&, int, int)>& progress) {
  SensorFit fit;
  fit.rig = rig.name;
  fit.data = data;
  fit.geometry = geometry;
  std::vector<WallStatistics> walls;
  const int all = static_cast<int>(frames.walls.size());
  for (const WallFrames& wall : frames.walls) {
    if (progress) progress(wall.name, static_cast<int>(walls.size()), all);
    walls.push_back(wall_statistics(wall, geometry));
  }
  if (!walls.empty()) {
    fit.depth = fit_depth(std::move(walls), geometry);
    fit.problems = fit.depth->problems;
  }
  if (frames.dark) {
    if (progress) progress("dark and flat fields", all, all);
    fit.gain = fit_gain(*frames.dark, frames.flats, frames.max_code);
    fit.problems.insert(fit.problems.end(), fit.gain->problems.begin(), fit.gain->problems.end());
  }
  if (fit.problems.empty()) fit.preset_toml = fitted_preset(fit, rig, frames.max_code);
  return fit;
}

SensorFit fit_sensor(const Recordings& r, const RigChoice& rig,
                     const std::function<void(const std::string&, int, int)>& progress) {
  require_enough(r);
  DepthGeometry geometry;
  if (!r.walls.empty()) {
    const WallFolder& first = r.walls.front();
    const Image<std::uint16_t> depth =
        read_depth_frame(r.folder / first.name / first.files.front());
    geometry = depth_geometry(r, rig, depth.width(), depth.height());
  }
  return fit_frames(frames_of(r, geometry, photosites_choice(rig)), geometry, rig, data_words(r),
                    progress);
}

}  // namespace cousin
