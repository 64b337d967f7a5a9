#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/plant/organ_surface.h"
#include "sim/truth/scene.h"

namespace cousin {

enum class OrganKind {
  stem,       ///< hypocotyl, internode, trunk, branch
  petiole,    ///< leaf or fruit stalk
  blade,      ///< counted as leaf area and as a leaf
  cotyledon,  ///< counted as leaf area, not as a leaf
  sheath,
  ligule,
  flower,
  root,
  fruit,
};
const char* to_string(OrganKind kind);

/// One organ on one day. Its id is its place in Plant::organs and in the model's part_names, the
/// same on every day: organs that have not come yet are there, without surface.
struct Organ {
  int id = 0;
  OrganKind kind = OrganKind::stem;
  std::string name;      ///< unique in the plant: "leaf 2 petiole"
  int parent = -1;       ///< id of the organ that it grows on; -1 = the root collar
  int rank = 0;          ///< from the base up, 1 = the lowest leaf
  int look = 0;          ///< which of the species' materials it has
  double age_days = -1;  ///< negative: not there yet
  CentreLine line;       ///< of stems, petioles, roots; of a blade its midrib; empty if not there
  OrganSurface surface;
  std::vector<Rgbf> albedo;  ///< one a vertex: share of the material's
};
inline bool is_there(const Organ& organ) { return !organ.surface.mesh.triangles.empty(); }

/// A plant in its own frame: root collar at the origin, z up.
struct Plant {
  std::string name;
  std::vector<Organ> organs;
  std::vector<Keypoint> keypoints;
};

/// Adds an organ whose id is the next. Returns its place; references to others are not kept.
Organ& add_organ(Plant& plant, OrganKind kind, std::string name, int parent, int rank);

/// @throws std::invalid_argument naming the organ, if ids, parents or names are not as stated, or a
/// point is not finite.
void validate(const Plant& plant);

/// All organs as one model: a part each, in the order of their ids, with smooth normals and
/// colours.
struct PlantModel {
  ObjectModel model;
  std::vector<int> part_looks;  ///< of each part
};
PlantModel plant_model(const Plant& plant);

/// Azimuth of the rank-th lateral organ, from 0: turned on by `divergence_rad` each.
/// 137.5 degrees: the golden angle; 180: two rows, as in grasses; 90 with pairs: decussate.
struct Phyllotaxis {
  double first_rad = 0;
  double divergence_rad = 2.39996;
  double spread_rad = 0;  ///< sigma of each about its place
};
double azimuth_rad(const Phyllotaxis& phyllotaxis, int rank, double normal_draw);

// Traits, read off the surfaces.
double leaf_area_m2(const Plant& plant);  ///< one side of blades and cotyledons
double blade_area_m2(const Plant& plant);
int leaf_count(const Plant& plant,
               double least_m = 0);   ///< blades that are there, at least so long
double height_m(const Plant& plant);  ///< of the highest vertex above the collar; 0 if below it
/// Angle between an organ's first step and its parent's line where it begins; NaN if either has no
/// line. Of a blade that is the leaf angle: 0 stands along the stalk.
double insertion_angle_rad(const Plant& plant, const Organ& organ);
/// Length along the line of an organ; 0 if it is not there.
double line_length_m(const Organ& organ);

}  // namespace cousin
