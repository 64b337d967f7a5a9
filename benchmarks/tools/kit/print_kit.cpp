#include "benchmarks/tools/kit/print_kit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>

#include "benchmarks/score/length_units.h"
#include "scenes/apples/apple.h"
#include "scenes/seeds/seeds_scene.h"
#include "scenes/seeds/setting.h"
#include "scenes/seeds/specimen.h"
#include "scenes/strawberries/strawberry.h"
#include "sim/dataset/atomic_file.h"
#include "sim/geometry/mesh_io.h"

namespace cousin {
namespace {

constexpr int kOfEach = 2;

/// Moved so that its lowest point lies on z = 0 and its middle above the origin.
Mesh standing(Mesh mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex_m : mesh.vertices_m) box.extend(vertex_m);
  const Eigen::Vector3d foot_m(box.center().x(), box.center().y(), box.min().z());
  for (Eigen::Vector3d& vertex_m : mesh.vertices_m) vertex_m -= foot_m;
  return mesh;
}

/// Traits of the very mesh. The scene's volume of a strawberry is another one: without its achenes.
/// A print has its own mass and colour.
std::vector<TrueTrait> traits_of_shape(const Mesh& mesh) {
  std::vector<TrueTrait> result = measure_traits(mesh, 1);
  std::erase_if(result, [](const TrueTrait& trait) { return trait.unit == "kg"; });
  return result;
}

KitObject kit_object(const std::string& name, const std::string& kind, Mesh mesh) {
  KitObject object{name, kind, standing(std::move(mesh)), {}};
  object.traits = traits_of_shape(object.mesh);
  return object;
}

std::string numbered(const std::string& name, int i) { return name + "_" + std::to_string(i + 1); }

constexpr const char* kReadme =
    "Seeds and fruits of Cousin's scenes at their true size, for a 3D printer.\n"
    "\n"
    "NAME.stl    closed meshes in millimetres; each stands on the print bed\n"
    "traits.csv  the exact length, width, height, area and volume of each mesh, in millimetres\n"
    "\n"
    "1. Print at 100 %, with the finest layers there are: a layer of 0.1 mm is an error of 0.1 "
    "mm.\n"
    "2. Measure the sphere with a caliper, 22.00 mm in every direction: what it is off, the "
    "printer\n"
    "   is off. Put that number beside the results.\n"
    "3. Matt paint in a seed's colour; gloss and glassy plastic mislead every method.\n"
    "4. `cousin board seeds` prints the board, `cousin measure` the table to hold against "
    "traits.csv.\n";

}  // namespace

std::vector<KitObject> print_kit(std::uint64_t seed) {
  std::vector<KitObject> kit;
  const Rng rng = Rng(seed).fork("kit");
  for (const std::string& name : cultivar_names()) {
    for (int i = 0; i < kOfEach; ++i) {
      const SeedModel model = make_seed(name, SizeSpread::literature,
                                        rng.fork(name).fork(static_cast<std::uint64_t>(i)));
      kit.push_back(kit_object(numbered(name, i), "seed, " + name, model.model.mesh));
    }
  }
  for (int i = 0; i < kOfEach; ++i) {
    const auto which = static_cast<std::uint64_t>(i);
    const FruitModel berry = make_strawberry({}, rng.fork("strawberry").fork(which));
    kit.push_back(
        kit_object(numbered("strawberry", i), "strawberry, without calyx", berry.flesh.model.mesh));
    const FruitModel apple = make_apple({}, rng.fork("apple").fork(which));
    kit.push_back(kit_object(numbered("apple", i), "apple, without stalk", apple.flesh.model.mesh));
  }
  const SeedModel sphere = make_sphere(seeds_setting(), rng.fork("sphere"));
  kit.push_back(kit_object("sphere_22mm", "sphere", sphere.model.mesh));
  return kit;
}

std::vector<std::string> print_kit_files(const std::vector<KitObject>& objects) {
  std::vector<std::string> files = {"README.txt", "traits.csv"};
  for (const KitObject& object : objects) files.push_back(object.name + ".stl");
  return files;
}

void write_print_kit(const std::filesystem::path& folder, const std::vector<KitObject>& objects) {
  constexpr double kMillimetres = 1e3;
  std::string table = "object,kind,trait,unit,value\n";
  for (const KitObject& object : objects) {
    write_stl(folder / (object.name + ".stl"), object.mesh, kMillimetres);
    for (const TrueTrait& trait : object.traits) {
      const LengthUnit unit = length_unit(trait.unit);
      char line[200];
      std::snprintf(line, sizeof line, "%s,\"%s\",%s,%s,%.6g\n", object.name.c_str(),
                    object.kind.c_str(), trait.name.c_str(), unit.millimetres.data(),
                    trait.value * unit.factor);
      table += line;
    }
  }
  write_file(folder / "traits.csv", table);
  write_file(folder / "README.txt", kReadme);
}

}  // namespace cousin
