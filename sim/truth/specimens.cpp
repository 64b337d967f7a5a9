#include "sim/truth/specimens.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace cousin {

std::vector<const Instance*> specimens_of(const Scene& scene) {
  std::vector<const Instance*> result;
  for (const Instance& instance : scene.instances) {
    if (instance.is_specimen) result.push_back(&instance);
  }
  std::sort(result.begin(), result.end(),
            [](const Instance* a, const Instance* b) { return a->id < b->id; });
  return result;
}

std::string label_of(const Instance& instance, const std::string& name) {
  for (const TrueLabel& label : instance.labels) {
    if (label.name == name) return label.value;
  }
  return {};
}

std::string variety_of(const Instance& instance) {
  const std::string variety = label_of(instance, "variety");
  return variety.empty() ? instance.category : variety;
}

std::vector<std::size_t> places_of(const Scene& scene, const Instance& specimen) {
  std::vector<std::size_t> places = {static_cast<std::size_t>(&specimen - scene.instances.data())};
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (scene.instances[i].part_of == specimen.id) places.push_back(i);
  }
  return places;
}

std::size_t carrier_of(const Scene& scene, const Instance& specimen, std::size_t keypoint) {
  const auto own = static_cast<std::size_t>(&specimen - scene.instances.data());
  if (specimen.keypoint_carriers.empty()) return own;
  const int id = specimen.keypoint_carriers.at(keypoint);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (scene.instances[i].id == id) return i;
  }
  throw std::invalid_argument("instance \"" + specimen.name + "\": keypoint " +
                              std::to_string(keypoint) + " is carried by " + std::to_string(id) +
                              ", which does not exist");
}

}  // namespace cousin
