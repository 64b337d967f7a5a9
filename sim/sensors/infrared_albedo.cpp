#include "sim/sensors/infrared_albedo.h"

#include <unordered_map>

#include "sim/truth/scene.h"

namespace cousin {

Image<float> infrared_albedo(const Scene& scene, const Image<std::int32_t>& instance,
                             const Image<std::uint16_t>& part) {
  std::unordered_map<std::int32_t, const Instance*> by_id;
  for (const Instance& each : scene.instances) by_id[each.id] = &each;
  Image<float> result(instance.width(), instance.height(), 0.0F);
  const Instance* seen = nullptr;
  for (std::size_t i = 0; i < instance.size(); ++i) {
    const std::int32_t id = instance.data()[i];
    if (id < 0) continue;
    if (!seen || seen->id != id) seen = by_id.at(id);
    const std::vector<int>& parts = seen->part_materials;
    const int material = parts.empty() ? seen->material : parts.at(part.data()[i]);
    result.data()[i] = scene.materials[static_cast<std::size_t>(material)].infrared_albedo;
  }
  return result;
}

}  // namespace cousin
