#include "scenes/seedlings/watermelon.h"
#include "sim/plant/blade_colours.h"
#include "sim/plant/color.h"

namespace cousin {

using Eigen::Vector3d;

std::vector<Material> watermelon_materials(const WatermelonConfig& config) {
  const auto& h = config.hypocotyl;
  const auto& c = config.cotyledon;
  const auto& l = config.leaf;
  const auto& s = config.surface;
  Material stem;
  stem.name = "seedling stem";
  stem.albedo = to_rgb(color_vector(h.albedo).cwiseMax(color_vector(h.albedo_base)));
  stem.roughness = s.stem_roughness;
  const auto sheet = [&](const char* name, const Vector3d& albedo, const std::vector<double>& back,
                         const std::vector<double>& through) {
    Material m;
    m.name = name;
    m.kind = SurfaceKind::leaf;
    m.albedo = to_rgb(albedo);
    m.back_albedo = to_rgb(color_vector(back).cwiseMax(albedo));
    m.transmittance = to_rgb(color_vector(through));
    m.roughness = s.leaf_roughness;
    m.infrared_transmittance = static_cast<float>(s.infrared_transmittance);
    return m;
  };
  std::vector<Material> materials = {
      stem,
      sheet("cotyledon", brightest(c.albedo, c.albedo_young, c.albedo_vein), c.albedo_back,
            c.transmittance),
      sheet("seedling leaf", brightest(l.albedo, l.albedo_young, l.albedo_vein), l.albedo_back,
            l.transmittance)};
  for (Material& m : materials) {
    m.ior = s.ior;
    m.infrared_albedo = static_cast<float>(s.infrared_albedo);
  }
  return materials;
}

}  // namespace cousin
