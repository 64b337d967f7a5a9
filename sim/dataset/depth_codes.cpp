#include "sim/dataset/depth_codes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cousin {
namespace {

constexpr double kMostCode = 65535, kMillimetresAMetre = 1000;
constexpr std::array<double, 5> kDepthSteps_mm = {0.1, 1, 10, 100, 1000};

}  // namespace

double depth_step_mm(double most_m) {
  return *std::find_if(kDepthSteps_mm.begin(), kDepthSteps_mm.end() - 1, [&](double step_mm) {
    return std::round(most_m * kMillimetresAMetre / step_mm) <= kMostCode;
  });
}

Image<std::uint16_t> depth_codes(const Image<float>& depth_m, double step_mm) {
  Image<std::uint16_t> codes(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const double depth = static_cast<double>(depth_m.data()[i]);
    if (std::isnan(depth)) continue;
    codes.data()[i] =
        static_cast<std::uint16_t>(std::max(1.0, std::round(depth * kMillimetresAMetre / step_mm)));
  }
  return codes;
}

}  // namespace cousin
