#include "sim/plant/plant.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "sim/geometry/smooth_normals.h"

namespace cousin {

const char* to_string(OrganKind kind) {
  switch (kind) {
    case OrganKind::stem:
      return "stem";
    case OrganKind::petiole:
      return "petiole";
    case OrganKind::blade:
      return "blade";
    case OrganKind::cotyledon:
      return "cotyledon";
    case OrganKind::sheath:
      return "sheath";
    case OrganKind::ligule:
      return "ligule";
    case OrganKind::flower:
      return "flower";
    case OrganKind::root:
      return "root";
    case OrganKind::fruit:
      return "fruit";
  }
  return "?";
}

Organ& add_organ(Plant& plant, OrganKind kind, std::string name, int parent, int rank) {
  Organ organ;
  organ.id = static_cast<int>(plant.organs.size());
  organ.kind = kind;
  organ.name = std::move(name);
  organ.parent = parent;
  organ.rank = rank;
  plant.organs.push_back(std::move(organ));
  return plant.organs.back();
}

void validate(const Plant& plant) {
  const auto fail = [&](const Organ& organ, const std::string& what) {
    throw std::invalid_argument("plant \"" + plant.name + "\", organ \"" + organ.name +
                                "\": " + what);
  };
  std::set<std::string> names;
  for (std::size_t i = 0; i < plant.organs.size(); ++i) {
    const Organ& organ = plant.organs[i];
    if (organ.id != static_cast<int>(i))
      fail(organ, "its id is " + std::to_string(organ.id) + " at place " + std::to_string(i));
    if (organ.parent < -1 || organ.parent >= organ.id)
      fail(organ, "its parent " + std::to_string(organ.parent) + " does not come before it");
    if (!names.insert(organ.name).second) fail(organ, "its name is not unique");
    if (organ.line.points_m.size() != organ.line.radii_m.size())
      fail(organ, "its line has other radii than points");
    if (!organ.albedo.empty() && organ.albedo.size() != organ.surface.mesh.vertices_m.size())
      fail(organ, "its albedo has another size than its vertices");
    for (const Eigen::Vector3d& vertex : organ.surface.mesh.vertices_m) {
      if (!vertex.allFinite()) fail(organ, "a vertex is not finite");
    }
  }
}

PlantModel plant_model(const Plant& plant) {
  validate(plant);
  PlantModel out;
  ObjectModel& model = out.model;
  model.name = plant.name;
  model.keypoints = plant.keypoints;
  for (const Organ& organ : plant.organs) {
    const Mesh& mesh = organ.surface.mesh;
    const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
    model.mesh.vertices_m.insert(model.mesh.vertices_m.end(), mesh.vertices_m.begin(),
                                 mesh.vertices_m.end());
    for (const auto& t : mesh.triangles)
      model.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    model.triangle_part.insert(model.triangle_part.end(), mesh.triangles.size(),
                               static_cast<std::uint16_t>(organ.id));
    if (organ.albedo.empty()) {
      model.vertex_albedo.insert(model.vertex_albedo.end(), mesh.vertices_m.size(), {1, 1, 1});
    } else {
      model.vertex_albedo.insert(model.vertex_albedo.end(), organ.albedo.begin(),
                                 organ.albedo.end());
    }
    model.part_names.push_back(organ.name);
    out.part_looks.push_back(organ.look);
  }
  model.vertex_normals = smooth_normals(model.mesh);
  return out;
}

double azimuth_rad(const Phyllotaxis& phyllotaxis, int rank, double normal_draw) {
  return phyllotaxis.first_rad + rank * phyllotaxis.divergence_rad +
         normal_draw * phyllotaxis.spread_rad;
}

double leaf_area_m2(const Plant& plant) {
  double sum = blade_area_m2(plant);
  for (const Organ& organ : plant.organs) {
    if (organ.kind == OrganKind::cotyledon) sum += surface_area_m2(organ.surface.mesh);
  }
  return sum;
}

double blade_area_m2(const Plant& plant) {
  double sum = 0;
  for (const Organ& organ : plant.organs) {
    if (organ.kind == OrganKind::blade) sum += surface_area_m2(organ.surface.mesh);
  }
  return sum;
}

int leaf_count(const Plant& plant, double least_m) {
  return static_cast<int>(
      std::count_if(plant.organs.begin(), plant.organs.end(), [&](const Organ& organ) {
        return organ.kind == OrganKind::blade && is_there(organ) && line_length_m(organ) >= least_m;
      }));
}

double height_m(const Plant& plant) {
  double highest = 0;
  for (const Organ& organ : plant.organs) {
    for (const Eigen::Vector3d& vertex : organ.surface.mesh.vertices_m)
      highest = std::max(highest, vertex.z());
  }
  return highest;
}

double insertion_angle_rad(const Plant& plant, const Organ& organ) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (organ.parent < 0 || organ.line.points_m.size() < 2) return kNone;
  const auto& below = plant.organs.at(static_cast<std::size_t>(organ.parent)).line.points_m;
  if (below.size() < 2) return kNone;
  const Eigen::Vector3d begin = organ.line.points_m[0];
  std::size_t nearest = 1;  // segment that ends here
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < below.size(); ++i) {
    const double distance = (0.5 * (below[i - 1] + below[i]) - begin).norm();
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  const Eigen::Vector3d along = (below[nearest] - below[nearest - 1]).normalized();
  const Eigen::Vector3d first = (organ.line.points_m[1] - begin).normalized();
  return std::atan2(along.cross(first).norm(), along.dot(first));
}

double line_length_m(const Organ& organ) {
  return organ.line.points_m.size() < 2 ? 0 : length_m(organ.line);
}

}  // namespace cousin
