#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "sim/imaging/depth_registration.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/active_stereo.h"

namespace cousin {

InfraredPair render_infrared_pair(const RayScene& rays, const Scene& scene,
                                  const Pose& rig_from_world, const ActiveStereoConfig& config,
                                  const ActiveStereoUnit& unit, Rng rng) {
  std::vector<Projector> projectors;
  if (unit.projector) {
    projectors.push_back(*unit.projector);
    projectors.back().world_from_projector =
        inverse(rig_from_world) * unit.projector->world_from_projector;
  }
  InfraredPair pair;
  const TrueView left = left_view(unit, rig_from_world), right = right_view(unit, rig_from_world);
  pair.left = render_infrared(rays, scene, left, projectors, config.infrared, rng.fork("left"));
  pair.right = render_infrared(rays, scene, right, projectors, config.infrared, rng.fork("right"));
  const TruthNeeds needs{.depth = true};
  pair.depth_m = render_truth(rays, scene, left, needs).depth_m;
  pair.right_depth_m = render_truth(rays, scene, right, needs).depth_m;
  return pair;
}

Image<std::uint16_t> depth_of_disparity(const Image<float>& disparity_px,
                                        const ActiveStereoConfig& config) {
  const double focal_baseline = depth_camera(config).fx_px * config.baseline_m;
  Image<std::uint16_t> depth(disparity_px.width(), disparity_px.height(), std::uint16_t{0});
  tbb::parallel_for(0, depth.height(), [&](int y) {
    for (int x = 0; x < depth.width(); ++x) {
      const auto d = static_cast<double>(disparity_px(x, y));
      if (!(d > 0)) continue;
      const double z_m = focal_baseline / d;
      const double code = std::round(z_m / config.depth_unit_m);
      if (z_m <= config.largest_depth_m && code >= 1 && code <= 65535)
        depth(x, y) = static_cast<std::uint16_t>(code);
    }
  });
  return depth;
}

InfraredCodes expose_pair(const InfraredPair& pair, const ActiveStereoConfig& config,
                          const ActiveStereoUnit& unit, const Rng& rng) {
  const InfraredExposure exposure = auto_exposure(pair.left.radiance, config.imager);
  return {expose_infrared(pair.left.radiance, unit.response_left, exposure, config.imager,
                          rng.fork("left")),
          expose_infrared(pair.right.radiance, unit.response_right, exposure, config.imager,
                          rng.fork("right"))};
}

StereoDepth sense_depth(const InfraredPair& pair, const ActiveStereoConfig& config,
                        const ActiveStereoUnit& unit, Rng rng) {
  return match_pair(pair, expose_pair(pair, config, unit, rng), config, unit);
}

StereoDepth match_pair(const InfraredPair& pair, InfraredCodes codes,
                       const ActiveStereoConfig& config, const ActiveStereoUnit& unit) {
  StereoDepth out;
  out.left_codes = std::move(codes.left);
  out.right_codes = std::move(codes.right);
  StereoMatches matches = match_stereo(out.left_codes, out.right_codes, config.match);

  // Disparities in the device's steps, within its range.
  const auto step = static_cast<float>(config.disparity_step_px);
  const auto most = static_cast<float>(config.match.shift_px + config.match.range_px);
  const double focal_baseline = unit.reported.fx_px * config.baseline_m;
  const double least_px =
      std::max(focal_baseline / config.largest_depth_m, config.match.shift_px + 0.5);
  for (std::size_t i = 0; i < matches.disparity_px.size(); ++i) {
    float& d = matches.disparity_px.data()[i];
    if (step > 0) d = std::round(d / step) * step;
    if (d > most || static_cast<double>(d) < least_px) {
      d = std::numeric_limits<float>::quiet_NaN();
      matches.reason.data()[i] = MatchReason::out_of_range;
    }
  }
  out.depth = depth_of_disparity(matches.disparity_px, config);
  out.noise_free_depth_m = pair.depth_m;
  InvalidReasonInputs inputs;
  inputs.matches = &matches;
  inputs.true_depth_m = &pair.depth_m;
  inputs.true_right_depth_m = &pair.right_depth_m;
  inputs.projected = unit.projector ? &pair.left.projected : nullptr;
  inputs.left_codes = &out.left_codes;
  inputs.right_codes = &out.right_codes;
  inputs.saturated_code = (1 << config.imager.bits) - 1;
  inputs.focal_baseline_px_m = unit.imager.fx_px * unit.baseline_m;
  inputs.least_disparity_px = least_px;
  inputs.largest_disparity_px = static_cast<double>(most);
  inputs.window_px = config.match.census_width_px + config.match.block_px - 1;
  out.reason = invalid_reasons(inputs);
  out.disparity_px = std::move(matches.disparity_px);
  return out;
}

Image<std::uint16_t> register_to_color(const Image<std::uint16_t>& depth,
                                       const ActiveStereoConfig& config,
                                       const ActiveStereoUnit& unit) {
  return register_depth(depth, config.depth_unit_m, unit.reported, unit.color_reported,
                        unit.color_from_rig_reported);
}

}  // namespace cousin
