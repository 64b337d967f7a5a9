#include "perception/splats/splat_render.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "perception/splats/splat_frame.h"

namespace cousin {

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
  draw_splats(best_splat_kernels(), planes, model.sh_degree, pinhole, config.background,
              SplatDepths::with, frame);
  SplatImage image;
  image.color = std::move(frame.color);
  image.alpha = std::move(frame.transmittance);
  for (float& value : image.alpha) value = 1 - value;
  image.depth_m = std::move(frame.depth_m);
  image.mean_depth_m = std::move(frame.mean_depth_m);
  return image;
}

}  // namespace cousin
