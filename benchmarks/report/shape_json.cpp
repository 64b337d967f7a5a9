#include "benchmarks/report/shape_json.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "benchmarks/report/html.h"

namespace cousin {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
std::string base64_of(const std::vector<T>& values) {
  return base64(
      std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)));
}

/// `value` between `low` and `high` as a share of the largest code.
std::uint16_t code_of(float value, float low, float high) {
  const float share = high > low ? (value - low) / (high - low) : 0.5F;
  return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(share, 0.0F, 1.0F)));
}

/// How much of what is behind it a Gaussian hides, but for the direction it is seen from.
float hidden_m2(const ReportSplat& splat) {
  const Eigen::Vector3f& s = splat.scale_m;
  return splat.opacity * std::max({s.x() * s.y(), s.y() * s.z(), s.z() * s.x()});
}

std::vector<std::size_t> kept_of(const ReportShape& shape, std::size_t limit) {
  const std::size_t count = shape.positions_m.size();
  std::vector<std::size_t> kept(limit);
  if (shape.splats.empty()) {
    for (std::size_t i = 0; i < limit; ++i) kept[i] = i * count / limit;
    return kept;
  }
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return hidden_m2(shape.splats[a]) > hidden_m2(shape.splats[b]);
  });
  std::copy_n(order.begin(), limit, kept.begin());
  std::sort(kept.begin(), kept.end());
  return kept;
}

void add_splats(const std::vector<ReportSplat>& splats, Json& json) {
  float low = std::log(splats.front().scale_m.x()), high = low;
  for (const ReportSplat& splat : splats) {
    low = std::min(low, std::log(splat.scale_m.minCoeff()));
    high = std::max(high, std::log(splat.scale_m.maxCoeff()));
  }
  std::vector<std::uint16_t> scales;
  std::vector<std::int8_t> rotations;
  std::vector<std::uint8_t> opacities;
  for (const ReportSplat& splat : splats) {
    for (int k = 0; k < 3; ++k) scales.push_back(code_of(std::log(splat.scale_m[k]), low, high));
    const Eigen::Quaternionf& q = splat.rotation;
    for (const float part : {q.w(), q.x(), q.y(), q.z()})
      rotations.push_back(static_cast<std::int8_t>(std::lround(127 * part)));
    opacities.push_back(static_cast<std::uint8_t>(std::lround(255 * splat.opacity)));
  }
  json["log_scale"] = {low, high};
  json["scales"] = base64_of(scales);
  json["rotations"] = base64_of(rotations);
  json["opacities"] = base64_of(opacities);
}

}  // namespace

void validate(const ReportShape& shape) {
  const auto fail = [&](const std::string& what) {
    throw std::invalid_argument("report: shape \"" + shape.name + "\": " + what);
  };
  const std::size_t count = shape.positions_m.size();
  if (!shape.colors.empty() && shape.colors.size() != count) {
    fail(std::to_string(shape.colors.size()) + " colours for " + std::to_string(count) +
         " positions");
  }
  for (const Eigen::Vector3f& p : shape.positions_m) {
    if (!p.allFinite()) fail("a position is not finite");
  }
  for (const auto& triangle : shape.triangles) {
    for (const std::uint32_t i : triangle) {
      if (i >= count) fail("vertex " + std::to_string(i) + " does not exist");
    }
  }
  if (shape.splats.empty()) return;
  if (!shape.triangles.empty()) fail("it has Gaussians and triangles");
  if (shape.splats.size() != count || shape.colors.size() != count) {
    fail(std::to_string(shape.splats.size()) + " Gaussians and " +
         std::to_string(shape.colors.size()) + " colours for " + std::to_string(count) +
         " positions");
  }
  for (const ReportSplat& splat : shape.splats) {
    const bool is_sized = splat.scale_m.allFinite() && (splat.scale_m.array() > 0).all();
    if (!is_sized) fail("a Gaussian's scale is not a positive number");
    if (!(splat.opacity >= 0 && splat.opacity <= 1)) fail("an opacity is not in 0..1");
    if (!(std::abs(splat.rotation.norm() - 1) < 1e-3F)) fail("a rotation is not of unit norm");
  }
}

ReportShape thinned(const ReportShape& shape, int limit) {
  const std::size_t count = shape.positions_m.size();
  if (!shape.triangles.empty() || count <= static_cast<std::size_t>(limit)) return shape;
  ReportShape result{shape.name, shape.caption, {}, {}, {}, {}};
  for (const std::size_t at : kept_of(shape, static_cast<std::size_t>(limit))) {
    result.positions_m.push_back(shape.positions_m[at]);
    if (!shape.colors.empty()) result.colors.push_back(shape.colors[at]);
    if (!shape.splats.empty()) result.splats.push_back(shape.splats[at]);
  }
  result.caption += " Shown: " + std::to_string(limit) + " of " + std::to_string(count) +
                    (shape.splats.empty() ? " points." : " Gaussians, those that hide most.");
  return result;
}

nlohmann::ordered_json shape_json(const ReportShape& shape) {
  Eigen::Vector3f low = shape.positions_m.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& p : shape.positions_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3f size = high - low;
  std::vector<std::uint16_t> codes;
  codes.reserve(3 * shape.positions_m.size());
  for (const Eigen::Vector3f& p : shape.positions_m) {
    for (int k = 0; k < 3; ++k) codes.push_back(code_of(p[k], low[k], high[k]));
  }
  Json json = {{"size", {size.x(), size.y(), size.z()}}, {"positions", base64_of(codes)}};
  if (!shape.colors.empty()) json["colors"] = base64_of(shape.colors);
  if (!shape.triangles.empty()) json["triangles"] = base64_of(shape.triangles);
  if (!shape.splats.empty()) add_splats(shape.splats, json);
  return json;
}

}  // namespace cousin
