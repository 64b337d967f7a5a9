#include "sim/render/coat.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/render/sample_points.h"

namespace cousin {
namespace {
constexpr float kSmallestCosine = 1e-4F;
}

Coat::Coat(double ior, double roughness)
    : ior_(static_cast<float>(ior)), facets_{static_cast<float>(roughness * roughness)} {
  if (!exists()) return;
  // E by its definition: the mean weight of drawn directions.
  constexpr std::uint32_t kDraws = 1024;
  for (int i = 0; i <= kCells; ++i) {
    const float cosine = std::max(static_cast<float>(i) / kCells, kSmallestCosine);
    const Eigen::Vector3f out(std::sqrt(std::max(0.0F, 1 - cosine * cosine)), 0, cosine);
    double sum = 0;
    for (std::uint32_t k = 0; k < kDraws; ++k) {
      const Eigen::Vector2f half_cell = Eigen::Vector2f::Constant(0.5F / kDraws);
      sum += static_cast<double>(draw(out, sobol_point(k) + half_cell).weight);
    }
    reflected_[static_cast<std::size_t>(i)] = static_cast<float>(sum / kDraws);
  }
  // 2 * integral of E(c) c dc for the linear interpolant, exact in each cell.
  double average = 0;
  for (int i = 0; i < kCells; ++i) {
    const double a = static_cast<double>(i) / kCells, h = 1.0 / kCells;
    const double e0 = static_cast<double>(reflected_[static_cast<std::size_t>(i)]);
    const double e1 = static_cast<double>(reflected_[static_cast<std::size_t>(i) + 1]);
    average += 2 * h * (e0 * (a / 2 + h / 6) + e1 * (a / 2 + h / 3));
  }
  entering_scale_ = static_cast<float>(1 / (1 - average));
}

float Coat::reflected(float cosine) const {
  const float position = std::clamp(cosine, 0.0F, 1.0F) * kCells;
  const int cell = std::min(static_cast<int>(position), kCells - 1);
  const float t = position - static_cast<float>(cell);
  const float* e = reflected_.data() + cell;
  return e[0] + t * (e[1] - e[0]);
}

float Coat::fresnel(float cosine) const {
  const float g = std::sqrt(ior_ * ior_ - 1 + cosine * cosine);
  const float a = (g - cosine) / (g + cosine);
  const float b = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1);
  return 0.5F * a * a * (1 + b * b);
}

Coat::Draw Coat::draw(const Eigen::Vector3f& out, const Eigen::Vector2f& u) const {
  const Eigen::Vector3f m = facets_.draw_visible(out, u);
  Draw result;
  const float out_m = out.dot(m);
  result.in = 2 * out_m * m - out;
  if (result.in.z() <= 0)
    return result;  // weight 0: lost to multiple scattering, which the base receives
  const float lambda_out = facets_.lambda(out.z());
  result.weight = fresnel(std::clamp(out_m, 0.0F, 1.0F)) * (1 + lambda_out) /
                  (1 + lambda_out + facets_.lambda(result.in.z()));
  result.density = value(out, result.in).density;
  return result;
}

Coat::Value Coat::value(const Eigen::Vector3f& out, const Eigen::Vector3f& in) const {
  if (in.z() <= 0 || out.z() <= 0) return {};
  const Eigen::Vector3f m = (out + in).normalized();
  const float lambda_out = facets_.lambda(out.z()), lambda_in = facets_.lambda(in.z());
  const float common = facets_.distribution(m) / (4 * out.z());
  return {fresnel(std::clamp(out.dot(m), 0.0F, 1.0F)) * common / (1 + lambda_out + lambda_in),
          common / (1 + lambda_out)};
}

}  // namespace cousin
