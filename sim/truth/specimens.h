#pragma once

#include <string>
#include <vector>

#include "sim/truth/scene.h"

namespace cousin {

/// The instances that are scored, in the order of their ids; files and true seams number them so.
std::vector<const Instance*> specimens_of(const Scene& scene);

/// Id of the specimen whose surface this is; the instance's own where it is no organ.
inline int whole_id(const Instance& instance) {
  return instance.part_of >= 0 ? instance.part_of : instance.id;
}
/// A specimen, or an organ of one.
inline bool is_of_specimen(const Instance& instance) {
  return instance.is_specimen || instance.part_of >= 0;
}

/// Value of a specimen's label; empty where it has none of this name.
std::string label_of(const Instance& instance, const std::string& name);
/// The label "variety", else the category.
std::string variety_of(const Instance& instance);

/// Places in Scene::instances of a specimen's surface: its own first, then its organs' in order.
std::vector<std::size_t> places_of(const Scene& scene, const Instance& specimen);

/// Place in Scene::instances of what carries keypoint number `keypoint` of a specimen's model.
std::size_t carrier_of(const Scene& scene, const Instance& specimen, std::size_t keypoint);

}  // namespace cousin
