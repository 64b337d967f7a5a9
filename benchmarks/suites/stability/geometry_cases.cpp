#include "benchmarks/suites/stability/geometry_cases.h"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <string>

#include "scenes/seeds/cultivar.h"
#include "scenes/seeds/specimen.h"
#include "sim/geometry/measure.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// Points all over an ellipsoid of a seed's size.
Points ellipsoid_points(int count) {
  Rng rng(5);
  Points points;
  while (static_cast<int>(points.size()) < count) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
    points.push_back(direction.cwiseProduct(Eigen::Vector3d(0.005, 0.003, 0.002)));
  }
  return points;
}

Points flat_points(int dimensions) {
  Rng rng(6);
  const Eigen::Matrix3d tilt =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  Points points;
  for (int i = 0; i < 200; ++i) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (int d = 0; d < dimensions; ++d) p[d] = uniform(rng, -0.005, 0.005);
    points.push_back(tilt * p);
  }
  return points;
}

Points moved(Points points, const Eigen::Vector3d& by) {
  for (Eigen::Vector3d& p : points) p += by;
  return points;
}

/// A measured value against a limit from above; NaN and exceptions fail.
StabilityRow row(const std::string& name, const std::string& quantity, const std::string& unit,
                 double limit, const std::function<double()>& measure) {
  StabilityRow result{name, quantity, unit, limit, std::nan(""), true, false};
  try {
    result.value = measure();
    result.pass = result.value <= limit;
  } catch (const std::exception&) {
    result.pass = false;  // the value stays NaN: the case threw
  }
  return result;
}

double worst_size_error(const OrientedBox& box, const OrientedBox& reference) {
  return (box.size_m - reference.size_m).cwiseAbs().maxCoeff();
}

/// How far the sizes of the boxes of a cultivar's seeds go when each vertex moves by a few
/// micrometres: where two boxes of almost the same volume compete (a seed as wide as it is high), a
/// small change of shape turns the box.
double box_response_m(const std::string& cultivar, double sigma_m) {
  constexpr std::uint64_t kSeeds = 4, kDraws = 6;
  double worst_m = 0;
  for (std::uint64_t i = 0; i < kSeeds; ++i) {
    const Points seed =
        make_seed(cultivar, SizeSpread::literature, Rng(7).fork(i)).model.mesh.vertices_m;
    const OrientedBox box = minimum_volume_box(seed);
    for (std::uint64_t k = 0; k < kDraws; ++k) {
      Rng rng = Rng(8).fork(kDraws * i + k);
      Points noisy = seed;
      for (Eigen::Vector3d& p : noisy)
        p += sigma_m * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
      worst_m = std::max(worst_m, worst_size_error(minimum_volume_box(noisy), box));
    }
  }
  return worst_m;
}

void add_flat_rows(std::vector<StabilityRow>& rows) {
  struct Flat {
    const char* name;
    Points points;
    int zero_sizes;
  };
  const std::vector<Flat> flats = {
      {"coplanar", flat_points(2), 1},
      {"collinear", flat_points(1), 2},
      {"duplicate", Points(50, Eigen::Vector3d(0.001, 0.002, 0.003)), 3},
      {"single", Points(1, Eigen::Vector3d(0.001, 0.002, 0.003)), 3}};
  for (const Flat& flat : flats) {
    rows.push_back(row(std::string("box, ") + flat.name + " points",
                       "smallest sizes that should be 0", "m", 1e-15, [&] {
                         const OrientedBox box = minimum_volume_box(flat.points);
                         double worst = 0;
                         for (int i = 3 - flat.zero_sizes; i < 3; ++i)
                           worst = std::max(worst, box.size_m[i]);
                         return box.size_m.allFinite() && box.axes.allFinite() ? worst
                                                                               : std::nan("");
                       }));
    rows.push_back(
        row(std::string("alpha shape, ") + flat.name + " points", "volume", "m3", 0, [&] {
          const AlphaShape shape = alpha_shape(flat.points, 0.0015);
          return shape.volume_m3 + shape.area_m2;
        }));
  }
}

/// Points of a seed's size, their box and their volume.
struct SolidPoints {
  Points points;
  OrientedBox box;
  double volume_m3 = 0;
};

void add_far_rows(const SolidPoints& solid, std::vector<StabilityRow>& rows) {
  for (const double offset_m : {1.0, 1e3, 1e6}) {
    // Coordinates carry a rounding of 2^-53 of the offset each; sizes and volumes can be no better
    // than a few of those.
    const double rounding_m = offset_m * 0x1p-52;
    const Points far = moved(solid.points, {offset_m, -offset_m, offset_m});
    const std::string name =
        "2000 points " + std::to_string(static_cast<long>(offset_m)) + " m away";
    rows.push_back(row("box, " + name, "change of a size", "m", 1e-12 + 4 * rounding_m,
                       [&] { return worst_size_error(minimum_volume_box(far), solid.box); }));
    rows.push_back(row("alpha shape, " + name, "relative change of the volume", "1",
                       1e-9 + 40 * rounding_m / 0.002, [&] {
                         return std::abs(alpha_shape(far, 0.0015).volume_m3 / solid.volume_m3 - 1);
                       }));
  }
}

void add_repeated_and_scaled_rows(const SolidPoints& solid, std::vector<StabilityRow>& rows) {
  rows.push_back(row("box, every point twice", "change of a size", "m", 1e-15, [&] {
    Points twice = solid.points;
    twice.insert(twice.end(), solid.points.begin(), solid.points.end());
    return worst_size_error(minimum_volume_box(twice), solid.box);
  }));
  rows.push_back(
      row("alpha shape, every point twice", "relative change of the volume", "1", 1e-12, [&] {
        Points twice = solid.points;
        twice.insert(twice.end(), solid.points.begin(), solid.points.end());
        return std::abs(alpha_shape(twice, 0.0015).volume_m3 / solid.volume_m3 - 1);
      }));
  rows.push_back(
      row("box, unit change to kilometres and back", "relative change of a size", "1", 1e-9, [&] {
        Points scaled = solid.points;
        for (Eigen::Vector3d& p : scaled) p *= 1e-3;
        OrientedBox box = minimum_volume_box(scaled);
        box.size_m *= 1e3;
        return worst_size_error(box, solid.box) / solid.box.size_m.z();
      }));
}

}  // namespace

std::vector<StabilityRow> geometry_cases() {
  std::vector<StabilityRow> rows;
  const Points points = ellipsoid_points(2000);
  const SolidPoints solid{points, minimum_volume_box(points),
                          alpha_shape(points, 0.0015).volume_m3};
  add_flat_rows(rows);
  add_far_rows(solid, rows);
  add_repeated_and_scaled_rows(solid, rows);
  for (const std::string& cultivar : cultivar_names()) {
    constexpr double kSigma_m = 5e-6, kLimit_m = 1e-4;
    rows.push_back(row("box, " + cultivar + ", vertices moved by 5 um", "largest change of a size",
                       "m", kLimit_m, [&] { return box_response_m(cultivar, kSigma_m); }));
  }
  return rows;
}

}  // namespace cousin
