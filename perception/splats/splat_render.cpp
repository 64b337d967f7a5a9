#include "perception/splats/splat_render.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "perception/splats/splat_frame.h"

namespace cousin {

namespace {

struct Drawing {
  const SplatPlanes& planes;
  int sh_degree;
  const SplatCamera& camera;
  const std::array<float, 3>& background;
};

/// Puts rows of an image where they belong in one of the whole height.
void put_rows(Image<float>&& rows, int first, int height, Image<float>& whole) {
  if (rows.height() == height) {
    whole = std::move(rows);
    return;
  }
  if (whole.empty()) whole = Image<float>(rows.width(), height);
  std::copy(rows.begin(), rows.end(), whole.data() + std::ptrdiff_t{first} * rows.width());
}

/// Draws rows `first` to `last`, which is left out; in halves where they are too much at once.
/// Transmittance is put in the place of alpha.
void draw_rows(const Drawing& drawing, int first, int last, SplatFrame& frame, SplatImage& image) {
  const int height = drawing.camera.height_px;
  SplatCamera part = drawing.camera;  // what its Jacobians are clamped to stays the whole's
  part.cy -= static_cast<float>(first);
  part.height_px = last - first;
  try {
    draw_splats(best_splat_kernels(), drawing.planes, drawing.sh_degree, part, drawing.background,
                SplatDepths::with, frame);
  } catch (const TooManyPairs&) {
    if (part.height_px <= SplatTile::side) throw;
    const int tiles = (part.height_px + SplatTile::side - 1) / SplatTile::side;
    const int middle = first + tiles / 2 * SplatTile::side;
    draw_rows(drawing, first, middle, frame, image);
    draw_rows(drawing, middle, last, frame, image);
    return;
  }
  for (std::size_t c = 0; c < 3; ++c)
    put_rows(std::move(frame.color.channel[c]), first, height, image.color.channel[c]);
  put_rows(std::move(frame.transmittance), first, height, image.alpha);
  put_rows(std::move(frame.depth_m), first, height, image.depth_m);
  put_rows(std::move(frame.mean_depth_m), first, height, image.mean_depth_m);
}

}  // namespace

SplatImage render_splats(const SplatModel& model, const Camera& camera,
                         const Pose& camera_from_world, const SplatRenderConfig& config) {
  if (model.sh_degree < 0 || model.sh_degree > 3) {
    throw std::invalid_argument("sh_degree " + std::to_string(model.sh_degree) +
                                " of a splat model is not 0..3");
  }
  const double low_pass_px2 = config.low_pass_px2 == 0 ? model.low_pass_px2 : config.low_pass_px2;
  if (!(low_pass_px2 > 0) || !std::isfinite(low_pass_px2)) {
    throw std::invalid_argument("low_pass_px2 = " + std::to_string(low_pass_px2) +
                                " is not above 0");
  }
  if (!(config.near >= 1e-9 && config.near <= 1)) {
    std::ostringstream text;
    text << "near = " << config.near << " is not in 1e-9..1 (a share of the median depth)";
    throw std::invalid_argument(text.str());
  }
  const SplatPlanes planes = to_planes(model.splats);
  const double near_m =
      near_depth_m(planes, camera_from_world, model.origin_in_world_m, config.near);
  SplatCamera pinhole = splat_camera(camera, camera_from_world, model.origin_in_world_m, near_m);
  pinhole.low_pass_px2 = static_cast<float>(low_pass_px2);
  SplatFrame frame;
  frame.most_pairs = config.most_pairs;
  SplatImage image;
  draw_rows({planes, model.sh_degree, pinhole, config.background}, 0, pinhole.height_px, frame,
            image);
  for (float& value : image.alpha) value = 1 - value;
  return image;
}

}  // namespace cousin
