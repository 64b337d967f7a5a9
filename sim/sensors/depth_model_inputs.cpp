#include <unordered_map>

#include "sim/render/infrared_pass.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/active_stereo.h"

namespace cousin {

DepthModelInputs depth_model_inputs(const RayScene& rays, const Scene& scene,
                                    const Pose& rig_from_world, const ActiveStereoConfig& config,
                                    const ActiveStereoUnit& unit, Rng rng) {
  const TrueView view = left_view(unit, rig_from_world);
  TruthImages truth =
      render_truth(rays, scene, view, {.depth = true, .normal = true, .instance = true});
  InfraredConfig infrared = config.infrared;
  infrared.pixel_samples = 1;
  DepthModelInputs inputs;
  inputs.ambient = render_infrared(rays, scene, view, {}, infrared, rng).radiance;
  std::unordered_map<std::int32_t, float> albedo;
  for (const Instance& instance : scene.instances) {
    albedo[instance.id] =
        scene.materials[static_cast<std::size_t>(instance.material)].infrared_albedo;
  }
  inputs.albedo = Image<float>(truth.instance.width(), truth.instance.height(), 0.0F);
  std::int32_t last = -1;
  float value = 0;
  for (std::size_t i = 0; i < truth.instance.size(); ++i) {
    const std::int32_t id = truth.instance.data()[i];
    if (id < 0) continue;
    if (id != last) value = albedo[last = id];
    inputs.albedo.data()[i] = value;
  }
  inputs.hidden = stereo_occlusion(truth.depth_m, config);
  inputs.depth_m = std::move(truth.depth_m);
  inputs.normal = std::move(truth.normal);
  return inputs;
}

}  // namespace cousin
