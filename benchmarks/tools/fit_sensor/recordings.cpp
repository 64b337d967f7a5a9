#include "benchmarks/tools/fit_sensor/recordings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "sim/config/fields.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kTape_m = 0.002;
constexpr std::size_t kMostToml = std::size_t{1} << 20;

[[noreturn]] void reject(const std::string& where, const std::string& what) {
  throw std::runtime_error(where + ": " + what);
}

/// "wall_0.60m", "wall_60cm_sunny": the number after "wall_", in metres; NaN if there is none.
double distance_of_name(std::string_view name) {
  constexpr std::string_view kPrefix = "wall_";
  if (!name.starts_with(kPrefix)) return kNone;
  name.remove_prefix(kPrefix.size());
  double value = kNone;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), value);
  if (error != std::errc()) return kNone;
  name.remove_prefix(static_cast<std::size_t>(end - name.data()));
  name = name.substr(0, name.find('_'));
  if (name == "m") return value;
  if (name == "cm") return 0.01 * value;
  if (name == "mm") return 0.001 * value;
  return kNone;
}

/// A key that may be missing: NaN then.
Field optional_number(const std::string& key, double* value, const std::string& help, double min,
                      double max) {
  return {key, value, help, min, max, true};
}

/// The keys of recordings.toml and where they are kept while it is read.
struct Index {
  double depth_unit_m = kNone, focal_px = kNone, baseline_m = kNone;
  double distance_sigma_m = kTape_m, albedo = 0.5, light = 0.02;
  int color_bits = 0;
  std::vector<double> region;

  Fields fields() {
    return {optional_number("depth_unit_m", &depth_unit_m, "metres a step of the depth", 1e-6, 1),
            optional_number("focal_px", &focal_px, "of the depth images", 10, 1e5),
            optional_number("baseline_m", &baseline_m, "between the imagers", 1e-4, 10),
            optional_number("distance_sigma_m", &distance_sigma_m, "of the distances", 1e-6, 10),
            optional_number("albedo", &albedo, "of the wall", 0.001, 1),
            optional_number("light", &light, "irradiance of the wall", 0, 10),
            {"color_bits", &color_bits, "of the raw frames", 8, 16, true},
            {"region_px", &region, "x, y, width, height of the part used", 0, kMostSide_px, true}};
  }
};

Fields wall_fields(WallFolder& wall) {
  return nested(wall.name,
                {optional_number("distance_m", &wall.distance_m, "to the wall", 0.01, 100),
                 optional_number("distance_sigma_m", &wall.distance_sigma_m, "of that", 1e-6, 10),
                 optional_number("albedo", &wall.albedo, "of the wall", 0.001, 1),
                 optional_number("light", &wall.light, "irradiance of the wall", 0, 10)});
}

std::optional<double> given(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
}

ImageRegion rect_of(const std::vector<double>& v, const std::string& where) {
  const bool whole = std::all_of(v.begin(), v.end(), [](double x) { return x == std::floor(x); });
  if (v.size() != 4 || !whole || v[2] < 16 || v[3] < 16)
    reject(where, "region_px has " + std::to_string(v.size()) +
                      " numbers; it must be x, y, width, height in whole pixels, at least 16 wide "
                      "and high");
  return {static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2]),
          static_cast<int>(v[3])};
}

/// The PNG files of a folder, by name.
std::vector<std::string> frames_of(const fs::path& folder) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".png" || is_temporary_name(name)) continue;
    if (files.size() == static_cast<std::size_t>(kMostFramesOfFolder))
      reject(folder.string(), "more than " + std::to_string(kMostFramesOfFolder) +
                                  " PNG files; that is the most that are read");
    files.push_back(name);
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Bit depth and colour type of a PNG's header.
struct PngKind {
  int bits = 0;
  bool is_grey = false;
};
PngKind png_kind(const fs::path& file) {
  std::array<unsigned char, 26> head{};
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(head.data()), head.size());
  if (!in) reject(file.string(), "too short for a PNG, or not readable");
  return {head[24], head[25] == 0};
}

template <class T>
const Image<T>& within_sides(const Image<T>& image, const fs::path& file) {
  if (image.width() <= kMostSide_px && image.height() <= kMostSide_px) return image;
  reject(file.string(), std::to_string(image.width()) + " x " + std::to_string(image.height()) +
                            " pixels; the limit is " + std::to_string(kMostSide_px) + " a side");
}

}  // namespace

Recordings recordings_from_index(const std::vector<std::string>& folders, std::string_view toml,
                                 const std::string& toml_name) {
  Recordings out;
  for (const std::string& name : folders) {
    WallFolder wall{.name = name,
                    .distance_m = kNone,
                    .distance_sigma_m = kNone,
                    .albedo = kNone,
                    .light = kNone,
                    .files = {}};
    if (name.starts_with("wall")) out.walls.push_back(std::move(wall));
    if (name.starts_with("flat")) out.flats.push_back({name, {}});
  }
  const auto most = static_cast<std::size_t>(kMostFolders);
  if (out.walls.size() > most || out.flats.size() > most)
    reject(toml_name, std::to_string(out.walls.size()) + " wall and " +
                          std::to_string(out.flats.size()) + " flat folders; the limit is " +
                          std::to_string(kMostFolders) + " of each");
  Index index;
  Fields keys = index.fields();
  for (WallFolder& wall : out.walls) keys = keys + wall_fields(wall);
  for (const std::string& table : toml_tables(toml, toml_name)) {
    const bool is_known = std::any_of(out.walls.begin(), out.walls.end(),
                                      [&](const WallFolder& w) { return w.name == table; });
    if (!is_known)
      reject(toml_name, "table [\"" + table +
                            "\"]: there is no folder of that name whose name "
                            "starts with wall");
  }
  read_toml_text(toml, toml_name, keys, MissingKeys::keep_default);
  for (WallFolder& wall : out.walls) {
    if (std::isnan(wall.distance_m)) wall.distance_m = distance_of_name(wall.name);
    if (!(wall.distance_m >= 0.01 && wall.distance_m <= 100))
      reject(wall.name,
             "the folder's name says no distance of 0.01 to 100 m; call it as "
             "wall_0.60m, or give distance_m in the table [\"" +
                 wall.name + "\"] of " + toml_name);
    if (std::isnan(wall.distance_sigma_m)) wall.distance_sigma_m = index.distance_sigma_m;
    if (std::isnan(wall.albedo)) wall.albedo = index.albedo;
    if (std::isnan(wall.light)) wall.light = index.light;
  }
  std::sort(out.walls.begin(), out.walls.end(), [](const WallFolder& a, const WallFolder& b) {
    return std::tie(a.distance_m, a.name) < std::tie(b.distance_m, b.name);
  });
  std::sort(out.flats.begin(), out.flats.end(),
            [](const FlatFolder& a, const FlatFolder& b) { return a.name < b.name; });
  out.depth_unit_m = given(index.depth_unit_m);
  out.focal_px = given(index.focal_px);
  out.baseline_m = given(index.baseline_m);
  out.color_bits = index.color_bits;
  if (!index.region.empty()) out.region = rect_of(index.region, toml_name + ": region_px");
  return out;
}

Recordings read_recordings(const fs::path& folder) {
  if (!fs::is_directory(folder)) reject(folder.string(), "no such folder");
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (names.size() > 4096) reject(folder.string(), "more than 4096 entries");
    if (entry.is_directory()) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  const fs::path toml = folder / "recordings.toml";
  const std::string text = fs::exists(toml) ? read_file(toml, kMostToml) : "";
  Recordings out = recordings_from_index(names, text, toml.string());
  out.folder = folder;
  for (WallFolder& wall : out.walls) wall.files = frames_of(folder / wall.name);
  for (FlatFolder& flat : out.flats) flat.files = frames_of(folder / flat.name);
  if (fs::is_directory(folder / "dark")) out.dark = frames_of(folder / "dark");
  if (out.walls.empty() && out.flats.empty())
    reject(folder.string(),
           "no recordings: there must be folders as wall_0.60m/ with 16-bit depth PNG files, or "
           "dark/ and flat_*/ with raw frames");
  return out;
}

Image<std::uint16_t> read_depth_frame(const fs::path& file) {
  return within_sides(read_png16(file), file);
}

RawFrame read_raw_frame(const fs::path& file) {
  const PngKind kind = png_kind(file);
  if (!kind.is_grey || (kind.bits != 8 && kind.bits != 16))
    reject(file.string(),
           "not a grey PNG of 8 or 16 bits; gain and read noise need raw linear frames (a colour "
           "mosaic is fine), since developed colours have another noise");
  if (kind.bits == 16) return {within_sides(read_png16(file), file), 16};
  const Image<std::uint8_t> codes = read_png8(file);
  within_sides(codes, file);
  RawFrame frame{Image<std::uint16_t>(codes.width(), codes.height()), 8};
  std::copy(codes.begin(), codes.end(), frame.codes.begin());
  return frame;
}

}  // namespace cousin
