#include "tests/sim/sensors/depth_test_scenes.h"

#include <numbers>

namespace cousin::test {

ActiveStereoConfig small_depth_camera() {
  ActiveStereoConfig config = active_stereo_preset("d457");
  config.mode_columns = {320};
  config.mode_rows = {240};
  config.mode_focal_px = {192};
  config.columns = 320;
  config.projector.dot_sigma_rad = 0.004;
  config.projector.dots = 2500;
  config.focal_error = config.baseline_error = config.yaw_error_rad = 0;
  config.color_focal_error = config.color_rotation_error_rad = 0;
  config.color_columns = 320;
  config.color_rows = 240;
  config.color_focal_px = 195;
  config.color_distortion.clear();
  return config;
}

void add_plate(Scene& scene, double z_m, double left_m, double top_m, double right_m,
               double bottom_m, const Material& material) {
  // The rig's x is the world's -y, its y the world's -z.
  ObjectModel model;
  model.name = "plate";
  model.mesh.vertices_m = {{z_m, -left_m, -top_m},
                           {z_m, -left_m, -bottom_m},
                           {z_m, -right_m, -bottom_m},
                           {z_m, -right_m, -top_m}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size()) + 1;
  instance.name = model.name;
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  scene.models.push_back(model);
  scene.materials.push_back(material);
  scene.instances.push_back(instance);
}

Material infrared_grey(float albedo, float contrast, double scale_m) {
  Material material;
  material.infrared_albedo = albedo;
  material.ior = 1;
  if (contrast > 0) {
    NoiseTexture noise;
    const float dark = 0.5F * (1 - contrast);
    noise.other_albedo = {dark, dark, dark};
    noise.scale_m = scale_m;
    noise.octaves = 3;
    material.noise = noise;
  }
  return material;
}

Pose rig_looking_along_x() { return look_at({0, 0, 0}, {1, 0, 0}); }

Sky even_sky(double irradiance) {
  const auto l = static_cast<float>(irradiance / std::numbers::pi);
  return Sky{{l, l, l}, {l, l, l}, {l, l, l}};
}

StereoDepth look(const Scene& scene, const ActiveStereoConfig& config, std::uint64_t seed) {
  const ActiveStereoUnit unit = make_active_stereo(config, Rng(seed).fork("unit"));
  const RayScene rays(scene);
  const InfraredPair pair = render_infrared_pair(rays, scene, rig_looking_along_x(), config, unit,
                                                 Rng(seed).fork("light"));
  return sense_depth(pair, config, unit, Rng(seed).fork("sensor"));
}

}  // namespace cousin::test
