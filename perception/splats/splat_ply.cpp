#include "perception/splats/splat_ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sim/dataset/atomic_file.h"
#include "sim/geometry/ply_rows.h"
#include "sim/types/memory_limit.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

using geometry::PlyElementHeader;
using geometry::PlyHeader;

constexpr std::size_t kMostBytes = std::size_t{1} << 32;
constexpr int kMostRest = 45;  ///< coefficients beyond the first, all channels
constexpr int kRestOfChannel = 15;
constexpr double kLeastNorm = 1e-12;
constexpr std::string_view kOrigin = "origin_m";
constexpr std::string_view kLowPass = "low_pass_px2";

bool low_pass_fits(double px2) { return px2 >= 1e-6 && px2 <= 100; }

/// The values of a splat as the layout names them.
constexpr int kFirstRest = 14;
constexpr int kFields = kFirstRest + kMostRest;
constexpr std::array<std::string_view, kFirstRest> kNames = {
    "x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
    "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};
constexpr std::array<int, 4> kRestOfDegree = {0, 9, 24, 45};

/// Properties and elements of files that look like the reference's and mean something else.
struct Variant {
  std::string_view name, what;
};
constexpr std::array<Variant, 9> kVariants = {
    {{"packed_position", "compressed (packed_*, as SuperSplat does): save it as a plain PLY"},
     {"filter_3D", "Gaussians before Mip-Splatting's 3D filter (filter_3D): save the fused PLY"},
     {"trbf_center", "Gaussians that move (trbf_center): save those of one time"},
     {"motion_0", "Gaussians that move (motion_*): save those of one time"},
     {"scale_t", "4D Gaussians (scale_t): save those of one time"},
     {"t_scale", "4D Gaussians (t_scale): save those of one time"},
     {"rot_r_0", "4D Gaussians (rot_r_*): save those of one time"},
     {"beta", "Beta kernels (beta), not Gaussians"},
     {"sb_params_0", "Beta kernels (sb_params_*), not Gaussians"}}};

/// Where a field lies in a splat. @param rest  f_rest of all channels in the file.
template <class SplatType>
auto& field_of(SplatType& splat, int field, int rest) {
  if (field < 3) return splat.centre_m[field];
  if (field < 6) return splat.sh_dc[static_cast<std::size_t>(field - 3)];
  if (field == 6) return splat.opacity_logit;
  if (field < 10) return splat.log_scale[field - 7];
  if (field < kFirstRest) return splat.rotation_wxyz[field - 10];
  const int of_channel = rest / 3;
  const int index = field - kFirstRest;
  return splat
      .sh_rest[static_cast<std::size_t>(index / of_channel * kRestOfChannel + index % of_channel)];
}

enum class RowProblem { none, not_finite, zero_rotation };

RowProblem problem_of(const Splat& splat) {
  if (!is_finite(splat)) return RowProblem::not_finite;
  return splat.rotation_wxyz.cast<double>().norm() < kLeastNorm ? RowProblem::zero_rotation
                                                                : RowProblem::none;
}

std::string text_of(RowProblem problem) {
  return problem == RowProblem::not_finite ? "has a value that is not finite"
                                           : "has a rotation whose norm is below 1e-12";
}

/// Reader of one file: what its errors name.
class SplatReader {
 public:
  SplatReader(std::string bytes, std::string name, const SplatPlyConfig& config)
      : bytes_(std::move(bytes)), name_(std::move(name)), config_(config) {}

  SplatFile read() {
    const PlyHeader header = geometry::parse_ply_header(bytes_, name_);
    geometry::PlyBody body(bytes_, header.body, header.encoding, name_);
    SplatFile result;
    comment_numbers(header, kOrigin, {result.model.origin_in_world_m.data(), 3});
    double& low_pass_px2 = result.model.low_pass_px2;
    comment_numbers(header, kLowPass, {&low_pass_px2, 1});
    if (!low_pass_fits(low_pass_px2))
      fail("header: low_pass_px2 " + std::to_string(low_pass_px2) + " is not in 1e-6..100");
    for (const PlyElementHeader& element : header.elements) {
      if (element.name != "vertex") {
        geometry::skip_rows(element, body);
        continue;
      }
      read_rows(element, body, result);
      return result;
    }
    fail("header: there is no element \"vertex\"");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(name_ + ": " + what);
  }

  /// Numbers after a comment's key: as many as `numbers` has, finite, and nothing more. They stay
  /// as they are where there is no such comment.
  void comment_numbers(const PlyHeader& header, std::string_view key,
                       std::span<double> numbers) const {
    bool found = false;
    for (const std::string& comment : header.comments) {
      if (!comment.starts_with(key)) continue;
      const char next = comment.size() > key.size() ? comment[key.size()] : ' ';
      if (std::isalpha(static_cast<unsigned char>(next)) != 0 || next == '_')
        continue;  // another key
      if (found) fail("header: there are two comments \"" + std::string(key) + "\"");
      found = true;
      const char* at = comment.data() + key.size();
      const char* const end = comment.data() + comment.size();
      const auto skip_space = [&] {
        while (at < end && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
      };
      const std::string wanted = std::to_string(numbers.size());
      for (double& number : numbers) {
        const char* const before = at;
        skip_space();
        const auto [stop, error] = std::from_chars(at, end, number);
        if (at == before || error != std::errc() || !std::isfinite(number))
          fail("header: \"" + comment + "\": expected " + std::string(key) + " and " + wanted +
               " finite numbers");
        at = stop;
      }
      skip_space();
      if (at != end) fail("header: \"" + comment + "\": there is more than " + wanted + " numbers");
    }
  }

  /// The field that each property of the element fills, or -1.
  std::vector<int> fields_of(const PlyElementHeader& element, SplatModel& model) {
    std::vector<int> fields(element.properties.size(), -1);
    std::array<bool, kFields> has{};
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const int field = field_named(element.properties[i]);
      if (field < 0) continue;
      if (has[static_cast<std::size_t>(field)])
        fail("header: there are two properties \"" + element.properties[i].name + "\"");
      has[static_cast<std::size_t>(field)] = true;
      fields[i] = field;
    }
    refuse_variants(element, has);
    rest_ = 0;
    while (rest_ < kMostRest && has[static_cast<std::size_t>(kFirstRest + rest_)]) ++rest_;
    for (int i = rest_; i < kMostRest; ++i) {
      if (has[static_cast<std::size_t>(kFirstRest + i)])
        fail("header: there is f_rest_" + std::to_string(i) + " but no f_rest_" +
             std::to_string(rest_));
    }
    model.sh_degree = -1;
    for (int degree = 0; degree <= 3; ++degree) {
      if (kRestOfDegree[static_cast<std::size_t>(degree)] == rest_) model.sh_degree = degree;
    }
    if (model.sh_degree < 0)
      fail("header: there are " + std::to_string(rest_) +
           " of f_rest_; 0, 9, 24 or 45 are degree 0 to 3");
    return fields;
  }

  void refuse_variants(const PlyElementHeader& element, const std::array<bool, kFields>& has) {
    const auto property = [&](std::string_view name) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [&](const geometry::PlyProperty& p) { return p.name == name; });
    };
    for (const Variant& variant : kVariants) {
      if (property(variant.name))
        fail("header: these are " + std::string(variant.what) + "; 3D Gaussians are read");
    }
    if (property("scale_0") && property("scale_1") && !property("scale_2"))
      fail(
          "header: these are 2D Gaussians (scale_0 and scale_1, no scale_2); 3D Gaussians are "
          "read");
    if (property("scale_0") && !property("scale_1"))
      fail("header: these are Gaussians with one scale (scale_0 alone); three are read");
    if (!property("f_dc_0") && property("red"))
      fail("header: colours are given as red, green, blue; f_dc_0 to f_dc_2 are read");
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      if (!has[i]) {
        fail("header: no file of 3D Gaussians: vertices have no property \"" +
             std::string(kNames[i]) + "\"");
      }
    }
  }

  int field_named(const geometry::PlyProperty& property) const {
    if (property.is_list) return -1;
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      if (property.name == kNames[i]) return static_cast<int>(i);
    }
    constexpr std::string_view kRest = "f_rest_";
    if (!property.name.starts_with(kRest)) return -1;
    int index = -1;
    const char* const end = property.name.data() + property.name.size();
    const auto [stop, error] = std::from_chars(property.name.data() + kRest.size(), end, index);
    if (error != std::errc() || stop != end || index < 0 || index >= kMostRest)
      fail("header: property \"" + property.name + "\" is not f_rest_0 to f_rest_44");
    return kFirstRest + index;
  }

  void read_rows(const PlyElementHeader& element, geometry::PlyBody& body, SplatFile& result) {
    const std::vector<int> fields = fields_of(element, result.model);
    if (element.count > config_.most_splats) {
      fail("there are " + std::to_string(element.count) + " splats; most_splats is " +
           std::to_string(config_.most_splats));
    }
    body.require_rows(element);
    check_memory(name_, bytes_.size() + bytes_times(element.count, sizeof(Splat)),
                 std::to_string(element.count) + " Gaussians");
    result.model.splats.reserve(element.count);
    for (std::size_t row = 0; row < element.count; ++row) {
      Splat splat;
      for (std::size_t i = 0; i < fields.size(); ++i) {
        const geometry::PlyProperty& property = element.properties[i];
        const std::size_t items = property.is_list ? body.list_length(property) : 1;
        for (std::size_t k = 0; k < items; ++k) {
          const double value = body.number(property.type);
          if (fields[i] >= 0) field_of(splat, fields[i], rest_) = static_cast<float>(value);
        }
      }
      const RowProblem problem = problem_of(splat);
      if (problem == RowProblem::none) {
        result.model.splats.push_back(splat);
        continue;
      }
      if (config_.invalid == SplatPlyConfig::Invalid::refuse)
        fail("splat " + std::to_string(row) + " " + text_of(problem));
      ++(problem == RowProblem::not_finite ? result.not_finite : result.zero_rotations);
    }
  }

  std::string bytes_;
  std::string name_;
  SplatPlyConfig config_;
  int rest_ = 0;
};

std::string header_text(const SplatModel& model, int rest) {
  std::array<char, 192> comments{};
  std::snprintf(comments.data(), comments.size(),
                "comment origin_m %.17g %.17g %.17g\ncomment low_pass_px2 %.17g\n",
                model.origin_in_world_m.x(), model.origin_in_world_m.y(),
                model.origin_in_world_m.z(), model.low_pass_px2);
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                     std::to_string(model.splats.size()) + "\n";
  const auto property = [&](const std::string& name) { text += "property float " + name + "\n"; };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"})
    property(name);
  for (int i = 0; i < rest; ++i) property("f_rest_" + std::to_string(i));
  for (std::size_t i = 6; i < kNames.size(); ++i) property(std::string(kNames[i]));
  // Comments last: the reference's viewer takes the third line for the number of Gaussians.
  return text + std::string(comments.data()) + "end_header\n";
}

}  // namespace

SplatFile read_splat_ply(const fs::path& file, const SplatPlyConfig& config) {
  return SplatReader(read_file(file, kMostBytes), file.string(), config).read();
}

void write_splat_ply(const fs::path& file, const SplatModel& model) {
  static_assert(std::endian::native == std::endian::little, "values are written in memory order");
  if (model.sh_degree < 0 || model.sh_degree > 3) {
    throw std::invalid_argument(file.string() + ": sh_degree = " + std::to_string(model.sh_degree) +
                                " is not in 0..3");
  }
  if (!model.origin_in_world_m.allFinite())
    throw std::invalid_argument(file.string() + ": the model's origin is not finite");
  if (!low_pass_fits(model.low_pass_px2)) {
    throw std::invalid_argument(file.string() + ": low_pass_px2 = " +
                                std::to_string(model.low_pass_px2) + " is not in 1e-6..100");
  }
  const int rest = kRestOfDegree[static_cast<std::size_t>(model.sh_degree)];
  std::string bytes = header_text(model, rest);
  const std::size_t row_bytes = sizeof(float) * static_cast<std::size_t>(kFirstRest + 3 + rest);
  bytes.reserve(bytes.size() + row_bytes * model.splats.size());
  const auto put = [&](float value) {
    std::array<char, sizeof(float)> raw{};
    std::memcpy(raw.data(), &value, sizeof(float));
    bytes.append(raw.data(), raw.size());
  };
  for (std::size_t i = 0; i < model.splats.size(); ++i) {
    const Splat& splat = model.splats[i];
    if (const RowProblem problem = problem_of(splat); problem != RowProblem::none) {
      throw std::invalid_argument(file.string() + ": splat " + std::to_string(i) + " " +
                                  text_of(problem));
    }
    for (int field = 0; field < 3; ++field) put(field_of(splat, field, rest));
    for (int k = 0; k < 3; ++k) put(0);  // normals
    for (int field = 3; field < 6; ++field) put(field_of(splat, field, rest));
    for (int field = kFirstRest; field < kFirstRest + rest; ++field)
      put(field_of(splat, field, rest));
    for (int field = 6; field < kFirstRest; ++field) put(field_of(splat, field, rest));
  }
  write_file(file, bytes);
}

}  // namespace cousin
