#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/types/board.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"

namespace cousin {

/// The board's print as a table for fast look-up; the same answer as `is_black` on the plate.
class BoardPattern {
 public:
  explicit BoardPattern(const SeedBoard& board);
  /// Whether paper (not ink) is at a point of the plate, in squares from the lower-left corner of
  /// the checkerboard.
  bool is_white(float x, float y) const;
  /// Whether everything within `reach` of a point, in squares, has one colour. May say no where it
  /// has.
  bool is_uniform(const Eigen::Vector2f& centre, const Eigen::Vector2f& reach) const;
  /// Whether a point, in squares, is on the plate, at least `inset` squares inside its edge.
  bool on_plate(float x, float y, float inset) const;
  double square_m() const { return square_m_; }
  int squares() const { return squares_; }
  /// Metres in the board's frame to squares from the lower-left corner of the checkerboard, and
  /// back.
  Eigen::Matrix3d squares_from_board() const;

 private:
  int squares_;
  double square_m_;
  float margin_;                 ///< plate beyond the checkerboard, in squares
  float marker_inset_, module_;  ///< white around a marker within its block; one module; in squares
  std::vector<std::uint8_t> cells_;    ///< for each square: 0 black, 1 white, 2 + marker index
  std::vector<std::uint8_t> modules_;  ///< 36 for each marker, white = 1, from the lower left
};

/// An axis-aligned block of pixels, inside the image.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
};

/// Undistorted coordinates (x/z, y/z) of pixels, interpolated between nodes 8 px apart, each
/// unprojected when first needed: the lens' second derivative leaves an error below 1e-3 px for the
/// distortions of phones and webcams. One for each image; not for use by several threads at once.
class LensMap {
 public:
  explicit LensMap(const Camera& camera);
  /// For a pixel of the image or one pixel beside it; NaN where the lens has no direction in front.
  Eigen::Vector2d operator()(int x, int y);
  const Camera& camera() const { return lens_.camera(); }

 private:
  const Eigen::Vector2d& node(int column, int row);
  static constexpr int kStep = 8;
  Lens lens_;
  int columns_;  ///< nodes start one step outside the image
  std::vector<Eigen::Vector2d> nodes_;
  std::vector<std::uint8_t> known_;
};

/// What an ideal camera would see of the print: the share of white in each pixel, blurred.
struct BoardTemplate {
  PixelBox box;
  Image<float> white;
  Image<Eigen::Vector2f>
      in_squares;  ///< board point at the pixel's centre; NaN where the ray misses the plane
};

enum class TemplateQuality {
  coarse,  ///< 21 samples in a pixel that an edge crosses
  fine     ///< 144
};

/// Pixels in which the plate may be seen, one pixel wider on each side.
PixelBox plate_box(const SeedBoard& board, const Camera& camera,
                   const Eigen::Matrix3d& normalized_from_board);

/// @param normalized_from_board  plane z = 0 of the board (m) to x/z, y/z of the camera
/// @param psf_sigma_px           Gaussian blur on top of the pixel's square
BoardTemplate render_board(const BoardPattern& pattern, LensMap& lens, const PixelBox& box,
                           const Eigen::Matrix3d& normalized_from_board, double psf_sigma_px,
                           TemplateQuality quality);

/// d(white)/d(pixel) at a pixel of the box.
Eigen::Vector2f gradient(const BoardTemplate& t, int x, int y);

}  // namespace cousin
