#include "sim/plant/blade_colours.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/gradient_noise.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// 1 on a vein, 0 off it; a vertex stands for `cell_m` around it.
double on_vein(double distance_m, double width_m, double cell_m) {
  return std::clamp((0.5 * width_m + 0.5 * cell_m - distance_m) / cell_m, 0.0, 1.0) *
         std::min(1.0, width_m / cell_m);
}

}  // namespace

Vector3d brightest(const std::vector<double>& a, const std::vector<double>& b,
                   const std::vector<double>& c) {
  return color_vector(a).cwiseMax(color_vector(b)).cwiseMax(color_vector(c));
}

std::vector<Rgbf> blade_albedo(const OrganSurface& surface, const BladeShape& shape,
                               const BladeColours& c, double cell_m) {
  const std::vector<double> veins = side_veins(shape);
  std::vector<Rgbf> colours;
  for (const Eigen::Vector2d& place : surface.place) {
    const double s = place.x(), out = std::abs(place.y());
    const double y_m = 0.5 * shape.width_m * out * row_share(shape, s);
    double vein = on_vein(y_m, c.vein_m * (1 - 0.7 * s), cell_m);
    double near_m = y_m;
    for (const double at : veins) {
      const double off_m = std::abs(s - at) * c.length_m;
      vein = std::max(vein, on_vein(off_m, 0.7 * c.vein_m * (1 - 0.8 * out), cell_m));
      near_m = std::min(near_m, off_m + 0.0012 * out);
    }
    vein = std::max(vein, c.halo * std::exp(-std::pow(near_m / (2.5 * c.vein_m), 2)));
    const double mottle =
        1 + 0.22 * fractal_noise3(
                       Vector3d(s * c.length_m, place.y() * shape.width_m * 0.5, 0.1) / 0.003, 3,
                       c.key);
    const Vector3d colour = mottle * ((1 - vein) * c.lamina + vein * c.vein);
    colours.push_back(to_rgb(colour.cwiseQuotient(c.base).cwiseMax(0.02).cwiseMin(1.0)));
  }
  return colours;
}

}  // namespace cousin
