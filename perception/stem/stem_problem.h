#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "perception/stem/stem_fit.h"

namespace cousin {

inline constexpr int kStemShape = 8;  ///< two cubics
inline constexpr int kStemRig = 3;    ///< the right image's offset, and of matched shifts one more
/// Residuals of a node: four of its pixels, one of its shift.
inline constexpr Eigen::Index kPerNode = 5;

/// Axes of a stem: `up` along it in the image's plane, `depth` along the line of sight.
struct StemFrame {
  Eigen::Vector3d origin_m, up, depth, side;
  double half_m = 0.02;  ///< half of its length
};

/// Everything that is solved for at once.
struct StemProblem {
  const EyePair& eyes;
  std::vector<StemSighting> sightings;
  std::vector<Eigen::Matrix4d> white;
  StemFrame frame;
  StemFitConfig config;
  StemUp up;

  Eigen::Index unknowns() const {
    return kStemShape + kStemRig + static_cast<Eigen::Index>(sightings.size());
  }
  Eigen::Vector3d point_m(const Eigen::VectorXd& at, double t_m) const {
    const double t = t_m / frame.half_m;
    const Eigen::Vector4d powers(1, t, t * t, t * t * t);
    return frame.origin_m + t_m * frame.up + powers.dot(at.segment<4>(0)) * frame.depth +
           powers.dot(at.segment<4>(4)) * frame.side;
  }
  double t_m(const Eigen::VectorXd& at, std::size_t i) const {
    return at(kStemShape + kStemRig + static_cast<Eigen::Index>(i));
  }
  Eigen::Vector3d node_m(const Eigen::VectorXd& at, std::size_t i) const {
    return point_m(at, t_m(at, i));
  }

  /// Arc from the first node, as the sum of eight chords.
  double along_m(const Eigen::VectorXd& at, std::size_t i) const {
    constexpr int kPieces = 8;
    const double from = t_m(at, 0), step = (t_m(at, i) - from) / kPieces;
    double length_m = 0;
    for (int k = 0; k < kPieces; ++k)
      length_m += (point_m(at, from + (k + 1) * step) - point_m(at, from + k * step)).norm();
    return step < 0 ? -length_m : length_m;
  }
};

/// Unknowns, their covariance and the whitened residuals; not there where it does not converge.
struct StemSolution {
  bool is_there = false;
  Eigen::VectorXd at;
  Eigen::MatrixXd covariance;
  Eigen::VectorXd residual;
};

/// Sets frame and weights by the sightings, which all have a first guess, and solves by
/// Levenberg-Marquardt.
StemSolution solve_stem(StemProblem& problem, double apart_s);

/// Where a node is by itself: by its shift if there is one, which is sharper than the points.
std::optional<Eigen::Vector3d> first_guess(const EyePair& eyes, const StemSighting& sighting);

/// Deviation by which a plant that moves between exposures is beside its place in the right image.
double motion_px(const EyePair& eyes, const StemFitConfig& config, double depth_m, double apart_s);

/// Central differences of `count` numbers at `at`; empty where there are not so many.
Eigen::MatrixXd slopes(const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& numbers,
                       const Eigen::VectorXd& at, Eigen::Index count);

}  // namespace cousin
