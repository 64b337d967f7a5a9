#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "perception/stem/eye_pair.h"
#include "sim/config/fields.h"
#include "sim/types/seams.h"

namespace cousin {

/// How a plant's nodes in space follow from their pixels in two images.
struct StemFitConfig {
  /// Share of a node's variance that both eyes have in common (a detector that sees the node too
  /// high does so in both). The rest is each image's own.
  double common_share = 0;
  double calibration_px = 1.5;       ///< deviation of the right image's offset, each axis
  double calibration_share = 0.002;  ///< deviation of a length's scale by focal length and baseline
  double shift_bias_px = 1;          ///< deviation of what all matched shifts of a plant are off
  double bend_rad = 0.08;            ///< deviation of a stem's turn between its ends
  double lean_rad = 0.35;            ///< deviation of its lean from where the image is upright
  double upright_rad = 0.1;          ///< and from where the ground says that it is
  double scatter_m = 0.0007;         ///< deviation of a node from the smooth stem, across it
  double most_sigmas = 4.5;          ///< a node farther from the stem than this is no node of it
  double most_residual_sigmas = 3;   ///< RMS of the residuals: beyond it the images disagree
  double motion_m_per_s = 0.3;       ///< speed of the plant between exposures that are not at once
};
Fields fields(StemFitConfig& config);
void validate(const StemFitConfig& config);

/// One point of a stem in both images.
struct StemSighting {
  EyeNode left, right;
  /// Where the right image shows what the left one has at its pixel (node_shift.h), if it is known.
  std::optional<Eigen::Vector2d> shifted_px;
  double shift_sigma_px = 0.2;
};

/// Nodes of one plant.
struct StemNodes {
  FitStatus status = FitStatus::too_few_points;
  std::string reason;                    ///< why it is not ok
  std::vector<int> places;               ///< of the sightings that are kept, from the root on
  std::vector<Eigen::Vector3d> nodes_m;  ///< in the left eye's axes
  std::vector<double> along_m;           ///< along the stem, from the first
  Eigen::MatrixXd covariance_m2;         ///< of (x, y, z, along) of each; empty = not given
  double residual_sigmas = kNaN;         ///< RMS
};

/// Each node where its rays pass each other (mid-point) [Maize, equation 5]; along is the sum of
/// chords. Says nothing of its error.
StemNodes nodes_by_middle(const EyePair& eyes, std::span<const StemSighting> sightings);

/// Each node by itself at the least squares of its pixels, with the covariance that follows, and
/// that of the calibration, which all share.
/// @param apart_s  between the exposures
StemNodes nodes_by_pixels(const EyePair& eyes, std::span<const StemSighting> sightings,
                          const StemFitConfig& config = {}, double apart_s = 0);

/// Where stems grow to, in the left eye's axes: up in its image, if nobody knows better.
struct StemUp {
  Eigen::Vector3d up = -Eigen::Vector3d::UnitY();  ///< unit
  bool is_of_ground = false;  ///< a plane's normal (plant_height.h), not the image's side
};

/// All nodes on one smooth stem: a cubic across an axis in the image's plane, whose turn and lean
/// have priors, a place along it for each node, and the right image's offset, by least squares on
/// all pixels and matched shifts at once. A node that no stem explains is left out, the worst
/// first. Two nodes make a straight stem; one is placed by itself.
StemNodes nodes_on_stem(const EyePair& eyes, std::span<const StemSighting> sightings,
                        const StemFitConfig& config = {}, double apart_s = 0,
                        const StemUp& up = {});

/// A length of a plant with its standard deviation. That of a chord includes the second-order part
/// of the errors of its two ends, which only lengthens it.
struct StemLength {
  double value_m = kNaN, sigma_m = kNaN;
};
StemLength chord(const StemNodes& nodes, std::size_t from, std::size_t to);
StemLength along(const StemNodes& nodes, std::size_t from, std::size_t to);

}  // namespace cousin
