#pragma once

#include <array>
#include <cstdint>

#include "scenes/strawberries/strawberry_plant.h"

namespace cousin {

/// Private to scenes/strawberries: the organs of a plant before they are its own.

/// How one leaf stands.
struct LeafPose {
  Eigen::Vector3d base_m = Eigen::Vector3d::Zero();
  double age = 0;  ///< 0 the youngest .. 1 the oldest
  double size = 1;
  double azimuth_rad = 0, angle_rad = 0;  ///< of its petiole; from the vertical
  double petiole_m = 0, sag_rad = 0;      ///< its turn towards the ground
  double droop_rad = 0, roll_rad = 0;     ///< of its blade
  std::array<double, 3> phases_rad{};
  std::uint64_t colour_key = 0;
};

/// Petiole and three leaflets: the middle one, then left and right.
struct LeafOrgans {
  CentreLine petiole_line;
  OrganSurface petiole;
  std::array<CentreLine, 3> midribs;
  std::array<OrganSurface, 3> leaflets;
  std::array<BladeShape, 3> shapes;
};
LeafOrgans make_strawberry_leaf(const StrawberryPlantConfig& config, const LeafPose& pose);
/// Shares of the material's colour for a leaflet's vertices.
std::vector<Rgbf> leaflet_albedo(const StrawberryPlantConfig& config, const LeafPose& pose,
                                 const LeafOrgans& leaf, std::size_t leaflet);

/// A flower's head about a point.
struct FlowerOrgans {
  OrganSurface petals, sepals, middle;
  std::vector<Rgbf> middle_albedo;
};
FlowerOrgans make_strawberry_flower(const StrawberryPlantConfig& config,
                                    const Eigen::Vector3d& at_m, const Eigen::Vector3d& facing,
                                    Rng rng);

/// Adds a surface to another.
void add_surface(OrganSurface& all, const OrganSurface& more);

}  // namespace cousin
