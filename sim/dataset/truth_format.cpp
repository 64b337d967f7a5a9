#include "sim/dataset/truth_format.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/depth_codes.h"
#include "sim/dataset/float_files.h"
#include "sim/dataset/json_interop.h"
#include "sim/imaging/exr_vectors.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/npy.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr double kMillimetresAMetre = 1000;

/// The ending of an image that is not of depths.
const char* float_ending(TruthFormat format) {
  return format == TruthFormat::exr ? ".exr" : ".npy";
}

/// The largest depth of an image that a 16-bit PNG holds.
double most_depth_m(const Image<float>& depth_m, const fs::path& file) {
  double most_m = 0;
  for (const float value : depth_m) {
    if (std::isnan(value)) continue;
    const double depth = static_cast<double>(value);
    if (!(depth >= 0 && depth <= kMostCodedDepth_m)) {
      throw std::invalid_argument(file.string() + ": the depth " + std::to_string(depth) +
                                  " m is not in [0, 65535], which a 16-bit PNG holds");
    }
    most_m = std::max(most_m, depth);
  }
  return most_m;
}

void write_depth_png(const fs::path& dir, const std::string& stem, const Image<float>& depth_m) {
  const fs::path png = dir / (stem + ".png");
  const double step_mm = depth_step_mm(most_depth_m(depth_m, png));
  Json scale = Json::object();
  scale["depth_scale"] = step_mm;
  write_file(dir / (stem + ".json"), to_text(scale));  // before the image, which needs it
  write_png(png, depth_codes(depth_m, step_mm));
}

double read_depth_scale(const fs::path& file) {
  const JsonDocument document = JsonDocument::read(file);
  const JsonNode root = document.root();
  root.expect_keys({"depth_scale"});
  const double scale = root["depth_scale"].number();
  if (!(scale > 0 && scale <= kMillimetresAMetre))
    root["depth_scale"].fail("is not in (0, 1000] millimetres a step");
  return scale;
}

}  // namespace

std::string to_string(TruthFormat format) {
  switch (format) {
    case TruthFormat::exr:
      return "exr";
    case TruthFormat::png16:
      return "png16";
    case TruthFormat::npy:
      break;
  }
  return "npy";
}

TruthFormat truth_format_from_string(std::string_view text) {
  for (const TruthFormat format : {TruthFormat::npy, TruthFormat::exr, TruthFormat::png16}) {
    if (text == to_string(format)) return format;
  }
  throw std::invalid_argument("--truth-format \"" + std::string(text) +
                              "\" is not one of npy, exr, png16");
}

std::vector<std::string> depth_files(const std::string& stem, TruthFormat format) {
  if (format == TruthFormat::png16) return {stem + ".png", stem + ".json"};
  return {stem + float_ending(format)};
}

void write_truth_depth(const fs::path& dir, const std::string& stem, const Image<float>& depth_m,
                       TruthFormat format) {
  if (format == TruthFormat::png16)
    write_depth_png(dir, stem, depth_m);
  else
    write_truth_floats(dir, stem, depth_m, format);
}

void write_truth_floats(const fs::path& dir, const std::string& stem, const Image<float>& image,
                        TruthFormat format) {
  const fs::path file = dir / (stem + float_ending(format));
  if (format == TruthFormat::exr)
    write_exr(file, image);
  else
    write_npy(file, image);
}

void write_truth_vectors(const fs::path& dir, const std::string& stem,
                         const Image<Eigen::Vector3f>& image, TruthFormat format) {
  const fs::path file = dir / (stem + float_ending(format));
  if (format == TruthFormat::exr)
    write_exr_vectors(file, image);
  else
    write_npy(file, image);
}

std::vector<std::string> depth_endings() { return {".exr", ".npy", ".png"}; }

Image<float> read_truth_depth(const fs::path& dir, const std::string& relative) {
  const fs::path file = resolve_inside(dir, relative);
  if (file.extension() != ".png") return read_floats(file);
  const Image<std::uint16_t> codes = read_png16(file);
  const double scale =
      read_depth_scale(resolve_inside(dir, fs::path(relative).replace_extension(".json")));
  Image<float> depth_m(codes.width(), codes.height(), kNone);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const double code = codes.data()[i];
    if (code > 0) depth_m.data()[i] = static_cast<float>(code * scale / kMillimetresAMetre);
  }
  return depth_m;
}

}  // namespace cousin
