#include "sim/physics/limbs.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

namespace cousin {
namespace {

/// A section of a stem; {-1, 0} is the ground.
using Section = std::pair<int, int>;
constexpr Section kGround = {-1, 0};

/// The section that holds a place: a stem's first half segment is a part of what carries it.
Section section_of(const BendingPlant& plant, LimbPlace place) {
  for (;;) {
    if (place.stem < 0) return kGround;
    const BendingStem& stem = plant.stems.at(static_cast<std::size_t>(place.stem));
    const int node = static_cast<int>(std::clamp(place.share, 0.0, 1.0) * stem.segments + 0.5);
    if (node > 0) return {place.stem, node};
    place = {stem.parent, stem.parent_share};
  }
}

LimbPlace place_of(const BendingPlant& plant, const Section& section) {
  if (section == kGround) return {};
  const int segments = plant.stems[static_cast<std::size_t>(section.first)].segments;
  return {section.first, static_cast<double>(section.second) / segments};
}

/// The triangles of a model that `is_own` says, and the vertices that they use, in their order.
template <class IsOwn>
ObjectModel part_of_model(const ObjectModel& model, const IsOwn& is_own) {
  ObjectModel part;
  part.name = model.name;
  part.part_names = model.part_names;
  constexpr std::uint32_t kUnused = 0xFFFFFFFFU;
  std::vector<std::uint32_t> number(model.mesh.vertices_m.size(), kUnused);
  for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
    if (!is_own(t)) continue;
    auto triangle = model.mesh.triangles[t];
    for (std::uint32_t& vertex : triangle) {
      if (number[vertex] == kUnused) {
        number[vertex] = static_cast<std::uint32_t>(part.mesh.vertices_m.size());
        part.mesh.vertices_m.push_back(model.mesh.vertices_m[vertex]);
        if (!model.vertex_albedo.empty()) part.vertex_albedo.push_back(model.vertex_albedo[vertex]);
        if (!model.vertex_normals.empty())
          part.vertex_normals.push_back(model.vertex_normals[vertex]);
      }
      vertex = number[vertex];
    }
    part.mesh.triangles.push_back(triangle);
    if (!model.triangle_part.empty()) part.triangle_part.push_back(model.triangle_part[t]);
  }
  return part;
}

BendingPlant placed(BendingPlant plant, const Pose& world_from_object) {
  for (BendingStem& stem : plant.stems) {
    for (Eigen::Vector3d& point : stem.points_m) point = world_from_object * point;
  }
  for (BendingLoad& load : plant.loads) {
    load.centroid_m = world_from_object * load.centroid_m;
    load.world_from_hulls = world_from_object.rotation * load.world_from_hulls;
  }
  return plant;
}

void sway_one(Scene& scene, const SplitSpecimen& specimen, const WindField& wind,
              const SwayConfig& config, const SwayWindows& windows) {
  const Instance& whole = scene.instances.at(specimen.places.at(0));
  const Pose at_rest = whole.world_from_object;
  const BendingPlant plant = placed(specimen.limbs->plant, at_rest);
  const SwayResult swayed =
      sway_windows(plant, unbent(plant), specimen.pushes, config, wind, windows);
  if (swayed.status == PlantStatus::not_built) {
    throw std::runtime_error("the motion of \"" + whole.name +
                             "\": this program is built without physics, and organs do not move; "
                             "--set moves=plants sways plants as one body each");
  }
  if (swayed.status != PlantStatus::ok) {
    throw std::runtime_error("the motion of \"" + whole.name +
                             "\": " + std::string(to_string(swayed.status)) +
                             (swayed.first_warning.empty() ? "" : ", " + swayed.first_warning));
  }
  for (std::size_t i = 0; i < specimen.places.size(); ++i) {
    const LimbPlace& place = specimen.pieces->places[i];
    if (place.stem < 0) continue;  // on the ground
    scene.instances[specimen.places[i]].motion =
        motion_of(plant, swayed.frames, place.stem, place.share, at_rest);
  }
}

}  // namespace

LimbPieces cut_model(const ObjectModel& model, const Limbs& limbs) {
  if (limbs.triangles.size() != model.mesh.triangles.size() ||
      limbs.keypoints.size() != model.keypoints.size()) {
    throw std::invalid_argument("limbs: " + std::to_string(limbs.triangles.size()) +
                                " triangles and " + std::to_string(limbs.keypoints.size()) +
                                " keypoints are placed; the model \"" + model.name + "\" has " +
                                std::to_string(model.mesh.triangles.size()) + " and " +
                                std::to_string(model.keypoints.size()));
  }
  const int stems = static_cast<int>(limbs.plant.stems.size());
  const auto checked = [&](const LimbPlace& place) {
    if (place.stem >= stems)
      throw std::invalid_argument("limbs: there is no stem " + std::to_string(place.stem));
    return section_of(limbs.plant, place);
  };
  std::vector<Section> of_triangle;
  std::map<Section, int> pieces;  // in the order of stems and nodes, the ground first
  for (const LimbPlace& place : limbs.triangles) {
    of_triangle.push_back(checked(place));
    pieces.emplace(of_triangle.back(), 0);
  }
  for (const LimbPlace& place : limbs.keypoints) pieces.emplace(checked(place), 0);
  LimbPieces cut;
  for (auto& [section, number] : pieces) {
    number = static_cast<int>(cut.models.size());
    cut.models.push_back(
        part_of_model(model, [&](std::size_t t) { return of_triangle[t] == section; }));
    cut.places.push_back(place_of(limbs.plant, section));
  }
  if (cut.models.empty())
    cut = {{part_of_model(model, [](std::size_t) { return false; })}, {{}}, {}};
  cut.models.front().keypoints = model.keypoints;
  for (const LimbPlace& place : limbs.keypoints)
    cut.keypoint_pieces.push_back(pieces.at(section_of(limbs.plant, place)));
  return cut;
}

std::vector<std::size_t> split_specimen(Scene& scene, std::size_t specimen,
                                        const LimbPieces& pieces, const std::vector<int>& models) {
  int next_id = 0;
  for (const Instance& instance : scene.instances) next_id = std::max(next_id, instance.id + 1);
  std::vector<std::size_t> places = {specimen};
  scene.instances.at(specimen).model = models.at(0);
  for (std::size_t i = 1; i < pieces.models.size(); ++i) {
    Instance organ = scene.instances[specimen];
    organ.part_of = organ.id;
    organ.id = next_id++;
    organ.name += ", piece " + std::to_string(i);
    organ.is_specimen = false;
    organ.model = models.at(i);
    organ.mass_kg = 0;
    organ.traits.clear();
    organ.labels.clear();
    organ.keypoint_carriers.clear();
    places.push_back(scene.instances.size());
    scene.instances.push_back(std::move(organ));
  }
  for (const int piece : pieces.keypoint_pieces) {
    const int id = scene.instances[places[static_cast<std::size_t>(piece)]].id;
    scene.instances[specimen].keypoint_carriers.push_back(id);
  }
  return places;
}

void sway_limbs(Scene& scene, const std::vector<SplitSpecimen>& specimens, const WindField& wind,
                const SwayConfig& config, const SwayWindows& windows) {
  tbb::parallel_for(std::size_t{0}, specimens.size(),
                    [&](std::size_t i) { sway_one(scene, specimens[i], wind, config, windows); });
}

SwayWindows windows_of(const Scene& scene, double lead_s) {
  constexpr double kBefore_s = 0.3, kAfter_s = 0.5;
  SwayWindows windows;
  windows.lead_s = lead_s;
  for (const View& view : scene.views)
    windows.spans.push_back({view.time_s - kBefore_s, view.time_s + kAfter_s});
  return windows;
}

}  // namespace cousin
