#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// Leaves at random in a ball of 1 m radius: `models` curved sheets of 2 * cells * cells triangles,
/// each placed as often as the others.
struct LeafCloud {
  int leaves = 2000;
  int models = 8;
  int cells = 20;
  int specimens = 50;  ///< the first leaves of the cloud, spread over it
};
/// @throws std::invalid_argument if there are no leaves, models or cells.
Scene leaf_cloud(const LeafCloud& cloud, std::uint64_t seed);

/// A pinhole of 640 x 480 that the cloud fills.
TrueView leaf_cloud_view();

/// Median seconds of an image: of the clock, and of all cores together.
struct ImageSeconds {
  double wall_s = 0;
  double cpu_s = 0;
};

/// The truth pass on the cloud, rays prepared, and Embree's packets alone on the same rays, by
/// turns.
struct LeafCloudSpeed {
  std::int64_t triangles = 0;  ///< instanced
  ImageSeconds raw;            ///< packets alone
  ImageSeconds centres;        ///< depth, normals, ids
  ImageSeconds masks;          ///< and full masks and visible fractions of the specimens
  ImageSeconds shares;         ///< and areas by 4 samples a pixel
};
LeafCloudSpeed measure_leaf_cloud(const LeafCloud& cloud, int repeats);

/// Largest memory of the process above what it had before, from making the scene through one truth
/// image of 64 x 48, in MB; NaN where the system does not tell.
double leaf_cloud_memory_mb(const LeafCloud& cloud);

}  // namespace cousin
