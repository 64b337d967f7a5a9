#include "sim/sensors/infrared_albedo.h"

#include <unordered_map>

#include "sim/truth/scene.h"

namespace cousin {

Image<float> infrared_albedo(const Scene& scene, const Image<std::int32_t>& instance) {
  std::unordered_map<std::int32_t, float> albedo;
  for (const Instance& each : scene.instances)
    albedo[each.id] = scene.materials[static_cast<std::size_t>(each.material)].infrared_albedo;
  Image<float> result(instance.width(), instance.height(), 0.0F);
  std::int32_t last = -1;
  float value = 0;
  for (std::size_t i = 0; i < instance.size(); ++i) {
    const std::int32_t id = instance.data()[i];
    if (id < 0) continue;
    if (id != last) value = albedo[last = id];
    result.data()[i] = value;
  }
  return result;
}

}  // namespace cousin
