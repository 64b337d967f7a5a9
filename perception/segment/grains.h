#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/config/fields.h"
#include "sim/types/image.h"

namespace cousin {

/// Light grains that lie apart on a dark ground, seen from straight above (a scanner), with paper
/// strips of known length beside them.
struct GrainConfig {
  double strip_length_m = 0.1;    ///< what a strip stands for
  double strip_aspect = 5;        ///< least length over width of a strip
  double least_length_m = 0.004;  ///< of a grain; shorter blobs are chaff or dirt
  double most_length_m = 0.015;   ///< longer blobs are several grains or something else
  double most_dent = 0.25;        ///< depth of a dent over the width; deeper = grains that touch
  double least_solidity = 0.88;   ///< area over that of the convex hull; less = grains that touch
  double most_area = 1.5;         ///< over the median of the blobs kept; more = grains that touch
  double smoothing_px = 0.7;      ///< standard deviation of the blur against noise
};
Fields fields(GrainConfig& config);
void validate(const GrainConfig& config);

/// A strip's rectangle. Strips are cut by hand: their ends are neither straight nor square, so the
/// length is the median over lines along the strip.
struct Strip {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double angle_rad = 0;  ///< of the long side, from x towards y
  double length_px = 0;
  double width_px = 0;
};

/// One grain's rectangle of least area, from its sub-pixel outline.
struct Grain {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double angle_rad = 0;  ///< of the long side, from x towards y
  double length_m = 0;
  double width_m = 0;
};

enum class GrainStatus { ok, no_strip, no_grains };
struct GrainPhoto {
  GrainStatus status = GrainStatus::no_strip;
  /// By the mean of the strips within 2 % of the longest: a strip is more easily cut short than
  /// long.
  double m_per_px = 0;
  std::vector<Strip> strips;                 ///< longest first
  std::vector<Grain> grains;                 ///< single and whole, by rows of the image
  std::vector<Eigen::Vector2d> touching_px;  ///< centres of blobs of several grains
  std::vector<Eigen::Vector2d> other_px;     ///< centres of blobs too large or cut by the border
  int fragments = 0;                         ///< blobs shorter than a grain, at least a millimetre
};

/// Blobs by Otsu's threshold [Otsu, IEEE SMC 1979] on sRGB codes; then each outline at the level
/// half way, in linear light, between the ground around the blob and the blob's median,
/// interpolated between pixels. Where that level parts a blob, each part counts. Blobs of a grain's
/// size without deep dents are measured (a rice grain's beak makes shallow ones); the others are
/// counted.
GrainPhoto measure_grains(const Image<Rgb8>& image, const GrainConfig& config = {});

}  // namespace cousin
