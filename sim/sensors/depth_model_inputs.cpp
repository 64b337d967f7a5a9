#include "sim/render/infrared_pass.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/active_stereo.h"
#include "sim/sensors/infrared_albedo.h"

namespace cousin {

DepthModelInputs depth_model_inputs(const RayScene& rays, const Scene& scene,
                                    const Pose& rig_from_world, const ActiveStereoConfig& config,
                                    const ActiveStereoUnit& unit, Rng rng) {
  const TrueView view = left_view(unit, rig_from_world);
  TruthImages truth = render_truth(rays, scene, view,
                                   {.depth = true, .normal = true, .instance = true, .part = true});
  InfraredConfig infrared = config.infrared;
  infrared.pixel_samples = 1;
  DepthModelInputs inputs;
  inputs.ambient = render_infrared(rays, scene, view, {}, infrared, rng).radiance;
  inputs.albedo = infrared_albedo(scene, truth.instance, truth.part);
  inputs.hidden = stereo_occlusion(truth.depth_m, config);
  inputs.depth_m = std::move(truth.depth_m);
  inputs.normal = std::move(truth.normal);
  return inputs;
}

}  // namespace cousin
