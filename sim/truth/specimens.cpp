#include "sim/truth/specimens.h"

#include <algorithm>

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

}  // namespace cousin
