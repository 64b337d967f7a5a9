#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "perception/splats/splat_render.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

struct SplatViewsConfig {
  int largest_side_px = 0;           ///< photographs are made this small; 0 = as they are
  double most_pixels = 268'435'456;  ///< of all views: 12 to 20 bytes each are kept
};
void validate(const SplatViewsConfig& config);  ///< throws std::invalid_argument

/// A photograph at one size, as a pinhole camera would have taken it.
struct SplatViewLevel {
  Camera camera;        ///< pinhole, of this size
  ColorPlanes color;    ///< sRGB-encoded, 0..1: codes are averaged, as a splat's colours are
  Image<float> weight;  ///< share of the pixel that counts, 0..1; empty = every pixel counts
  /// Share of the pixel that shows no scene but what is behind it (a screen, the sky), about 0..1,
  /// which is black in `color`; empty = none. Any colour can so be put there.
  Image<float> behind;
};

/// A photograph to train on or to be scored by.
struct SplatView {
  int frame = 0;  ///< index into the capture's frames
  Pose camera_from_world;
  SplatViewLevel full;  ///< smaller ones are made where they are needed, see halved()
};

/// The poses that a capture itself reports, of each frame's first sensor; frames without one have
/// the status no_board.
Poses reported_poses(const Capture& capture);

/// The views of a capture whose poses are ok and whose first sensor has a colour image, in the
/// capture's order. Lenses are undistorted to the pinhole camera of undistorted_camera(), with
/// weight zero where the photograph shows nothing; then pixels are averaged over the areas of the
/// larger ones, so that cameras keep where their rays go. Pixels of weight zero add no colour to a
/// larger one, whose weight is the mean of theirs; where it is zero, colour is zero. TBB over
/// views; the same bytes on any number of threads.
/// @param masks  empty, or one for each frame: empty, or of the photograph's size, where a pixel of
/// zero does not count.
/// @param screens  the same: not zero where the photograph shows what is behind the scene, which
/// the caller has made black.
/// @throws std::invalid_argument if counts or sizes differ, a camera or the configuration is
/// invalid, or there are more pixels than `most_pixels`.
std::vector<SplatView> splat_views(const Capture& capture, const Poses& poses,
                                   const std::vector<Image<std::uint8_t>>& masks = {},
                                   const SplatViewsConfig& config = {},
                                   const std::vector<Image<std::uint8_t>>& screens = {});

/// @throws std::invalid_argument naming `name`, the image's size and the camera's if they differ
void check_size(const Camera& camera, const Image<float>& image, const std::string& name);
/// The same of all images of a level that are there; colours must be.
void check_sizes(const SplatViewLevel& level, const std::string& name);

/// How often a camera's image can be halved, at most `times`, before a side is below 16 pixels.
int halvings_of(const Camera& camera, int times);

/// The level halved as often as halvings_of() says: pixels are averaged as in splat_views(), a last
/// odd row or column is left out.
SplatViewLevel halved(const SplatViewLevel& level, int times = 1);

}  // namespace cousin
