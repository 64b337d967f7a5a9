#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "perception/splats/splat_model.h"
#include "sim/types/image.h"
#include "sim/types/rng.h"

namespace cousin {

/// A coloured point that a Gaussian starts from.
struct StartPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< in the world
  Rgb8 color{128, 128, 128};                             ///< sRGB
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();      ///< of the surface, unit; zero = unknown
  double opacity = 0;  ///< how sure something is there, 0..1 exclusive; zero = the configuration's
};

/// What a file of points held.
struct StartPoints {
  std::vector<StartPoint> points;
  std::size_t not_finite = 0;  ///< points left out
};

inline constexpr std::size_t kMostStartPoints = 10'000'000;

/// Points of a PLY file (x y z, and red green blue as integers of 255 or floats of 1 where they are
/// there; else grey), or of COLMAP's points3D.txt or points3D.bin, by its ending. Lengths are taken
/// as metres. @throws std::runtime_error naming file, place, value and limit.
StartPoints read_start_points(const std::filesystem::path& file,
                              std::size_t most_points = kMostStartPoints);

/// Grey points spread evenly over a box.
/// @throws std::invalid_argument if a bound is not finite, low is not below high, or count < 0.
std::vector<StartPoint> random_start_points(const Eigen::Vector3d& low_m,
                                            const Eigen::Vector3d& high_m, int count, Rng rng);

struct SplatStartConfig {
  int sh_degree = 3;      ///< of the model; coefficients beyond the first start at zero
  double opacity = 0.1;   ///< of a Gaussian whose point has none, 0..1 exclusive
  double flatness = 1;    ///< thickness over width where the point has a normal; 0..1, not 0
  double alone_m = 0.01;  ///< scale where no other point gives one
};
void validate(const SplatStartConfig& config);  ///< throws std::invalid_argument

/// A round Gaussian for each point, as the reference starts [Kerbl et al. 2023, section 5.1]: its
/// scale is the root mean square distance of the three nearest other points, and at least a
/// hundredth of the median of those (points may coincide); where the point has a normal, a disc
/// across it, `flatness` times as thick; its colour is the point's in every
/// direction. The origin is zero, or, where coordinates are more than a hundred times the points'
/// spread, their median: floats then keep what they tell apart. TBB; the same bytes on any number
/// of threads. @throws std::invalid_argument if a point is not finite, its opacity is none, or the
/// configuration is invalid.
SplatModel splats_from_points(std::span<const StartPoint> points,
                              const SplatStartConfig& config = {});

}  // namespace cousin
