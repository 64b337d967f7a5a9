#include "scenes/strawberries/plant_rows.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <numbers>

#include "scenes/strawberries/leaf_crowd.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

std::string numbered(const char* kind, std::size_t number) {
  char name[40];
  std::snprintf(name, sizeof name, "%s %02d", kind, static_cast<int>(number));
  return name;
}

Instance instance_of(const PlantModel& model, int model_index, int first_material,
                     const Vector3d& at_m) {
  Instance instance;
  instance.category = "strawberry plant";
  instance.model = model_index;
  instance.material = first_material + kBerryLeafletLook;
  for (const int look : model.part_looks) instance.part_materials.push_back(first_material + look);
  instance.world_from_object.translation_m = at_m;
  return instance;
}

void add(Scene& scene, Instance instance, const std::string& name) {
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = name;
  scene.instances.push_back(std::move(instance));
}

/// A leaf off its plant: the base of its petiole is its origin.
struct CutLeaf {
  std::string name;
  Vector3d base_m, blade_m;
  PlantModel model;
};

constexpr std::size_t kOrgans = 4;  // of a leaf: petiole and three leaflets, one after another

CutLeaf cut_leaf(const Plant& plant, std::size_t petiole) {
  CutLeaf leaf;
  const Organ& stalk = plant.organs[petiole];
  leaf.name = stalk.name.substr(0, stalk.name.rfind(' '));
  leaf.base_m = stalk.line.points_m.front();
  leaf.blade_m.setZero();
  Plant own;
  own.name = leaf.name;
  std::size_t vertices = 0;
  for (std::size_t k = 0; k < kOrgans; ++k) {
    Organ organ = plant.organs[petiole + k];
    organ.id = static_cast<int>(k);
    organ.parent = k == 0 ? -1 : 0;
    for (Vector3d& p : organ.surface.mesh.vertices_m) {
      p -= leaf.base_m;
      if (k > 0) leaf.blade_m += p;
    }
    if (k > 0) vertices += organ.surface.mesh.vertices_m.size();
    own.organs.push_back(std::move(organ));
  }
  leaf.blade_m /= static_cast<double>(std::max<std::size_t>(1, vertices));
  leaf.model = plant_model(own);
  return leaf;
}

/// Takes the leaves that grow on the crown off a plant.
std::vector<CutLeaf> cut_leaves(Plant& plant) {
  std::vector<CutLeaf> leaves;
  for (std::size_t i = 0; i + kOrgans <= plant.organs.size(); ++i) {
    const Organ& organ = plant.organs[i];
    if (!organ.name.starts_with("leaf ") || !organ.name.ends_with(" petiole") || !is_there(organ))
      continue;
    leaves.push_back(cut_leaf(plant, i));
    for (std::size_t k = 0; k < kOrgans; ++k) {
      plant.organs[i + k].surface = {};
      plant.organs[i + k].albedo.clear();
    }
  }
  return leaves;
}

struct GrownPlant {
  PlantModel model;
  std::vector<CutLeaf> leaves;
};

/// Those of the near row, then the variants for all others.
std::vector<Plant> grow_plants(const StrawberryPlantConfig& config, const StrawberryBedConfig& bed,
                               const TrussLeafRoom& room, const RowPlaces& rows, const Rng& rng) {
  const std::size_t own = rows.near_m.size();
  const auto variants = static_cast<std::size_t>(bed.row.variants);
  const TrussLeafRoom bare{{}, room.bed, room.clear_m};
  std::vector<Plant> grown(own + variants);
  const auto grow = [&](std::size_t i, LeafCrowd* crowd) {
    const Pose at{Eigen::Quaterniond::Identity(), i < own ? rows.near_m[i] : rows.far_m.front()};
    const IsFree is_free = [&](const Mesh& part) {
      return (i < own ? room : bare).is_free(part, at);
    };
    grown[i] =
        grow_strawberry_plant(config, is_free, rng.fork("plant").fork(i), crowd, at.translation_m);
  };
  // Neighbours one after the other, for each keeps off those before it.
  tbb::parallel_invoke(
      [&] {
        LeafCrowd crowd;
        for (std::size_t i = 0; i < own; ++i) grow(i, &crowd);
      },
      [&] {
        for (std::size_t i = own; i < grown.size(); ++i) grow(i, nullptr);
      });
  return grown;
}

/// Variants in the far row and on the beds behind.
void add_far_plants(Scene& scene, const StrawberryBedConfig& bed, const RowPlaces& rows,
                    const std::vector<GrownPlant>& plants, int first_model, int first_material) {
  const std::size_t own = rows.near_m.size();
  const auto variants = static_cast<std::size_t>(bed.row.variants);
  // Behind the path's side of their own bed they face its other side.
  std::size_t count = 0;
  const auto behind = [&](const Vector3d& at_m, bool turned) {
    const std::size_t v = own + count % variants;
    Instance instance =
        instance_of(plants[v].model, first_model + static_cast<int>(v), first_material, at_m);
    if (turned) {
      instance.world_from_object.rotation = Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitZ());
    }
    add(scene, std::move(instance), numbered("far plant", count++));
  };
  for (const Vector3d& at_m : rows.far_m) behind(at_m, true);
  for (int b = 1; b <= bed.path.beds; ++b) {
    const Vector3d by_m(-b * bed.path.pitch_m, 0, 0);
    for (const Vector3d& at_m : rows.near_m) behind(at_m + by_m, false);
    for (const Vector3d& at_m : rows.far_m) behind(at_m + by_m, true);
  }
}

}  // namespace

std::vector<LoneLeaf> add_strawberry_plants(Scene& scene, const StrawberryPlantConfig& config,
                                            const StrawberryBedConfig& bed,
                                            const TrussLeafRoom& room, const RowPlaces& rows,
                                            bool apart, const Rng& rng) {
  const int first_material = static_cast<int>(scene.materials.size());
  for (Material& material : strawberry_materials(config))
    scene.materials.push_back(std::move(material));
  const std::size_t own = rows.near_m.size();
  std::vector<Plant> grown = grow_plants(config, bed, room, rows, rng);
  std::vector<GrownPlant> plants(grown.size());
  tbb::parallel_for(std::size_t{0}, plants.size(), [&](std::size_t i) {
    if (apart && i < own) plants[i].leaves = cut_leaves(grown[i]);
    plants[i].model = plant_model(grown[i]);
  });
  const int first_model = static_cast<int>(scene.models.size());
  for (const GrownPlant& plant : plants) scene.models.push_back(plant.model.model);
  std::vector<LoneLeaf> leaves;
  for (std::size_t i = 0; i < own; ++i) {
    const std::string name = numbered("plant", i);
    add(scene,
        instance_of(plants[i].model, first_model + static_cast<int>(i), first_material,
                    rows.near_m[i]),
        name);
    for (CutLeaf& leaf : plants[i].leaves) {
      leaves.push_back({scene.instances.size(), leaf.blade_m});
      add(scene,
          instance_of(leaf.model, static_cast<int>(scene.models.size()), first_material,
                      rows.near_m[i] + leaf.base_m),
          name + " " + leaf.name);
      scene.models.push_back(std::move(leaf.model.model));
    }
  }
  add_far_plants(scene, bed, rows, plants, first_model, first_material);
  return leaves;
}

}  // namespace cousin
