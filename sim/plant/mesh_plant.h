#pragma once

#include <string>

#include "sim/geometry/user_mesh.h"
#include "sim/plant/plant.h"

namespace cousin {

/// What kind of organ a part is by its name, in English, whatever its case: "Leaf_03" is a blade,
/// "leaf 3 petiole" a petiole, "Sphere.001" a stem, as all that is not known.
OrganKind organ_kind_of(const std::string& name);

/// How a user's mesh becomes ours.
struct MeshPlacing {
  double metres_per_unit = 1;
  /// Rotation of ours from the file's axes: whose z is up.
  Eigen::Matrix3d ours_from_file = Eigen::Matrix3d::Identity();
};

/// Gives an organ the surface of a mesh: a scan, another program's leaf. Triangles that use a
/// vertex twice are left out. Colours of the file are kept as the organ's albedo, to be taken with
/// a material of albedo 1.
void set_surface(Organ& organ, const UserMesh& user, const MeshPlacing& placing);

/// A plant of a user's mesh: an organ each part, or one where the file has none, of the kinds that
/// their names say; all grow on the collar. It keeps its place in the file's axes.
Plant plant_of_mesh(const UserMesh& user, const MeshPlacing& placing, const std::string& name);

}  // namespace cousin
