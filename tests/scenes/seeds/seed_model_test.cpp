#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>

#include "scenes/seeds/cultivar.h"
#include "scenes/seeds/seeds_scene.h"
#include "scenes/seeds/specimen.h"
#include "sim/geometry/measure.h"

namespace cousin {
namespace {

double trait(const SeedModel& seed, const std::string& name) {
  for (const TrueTrait& t : seed.traits) {
    if (t.name == name) return t.value;
  }
  throw std::runtime_error("no trait " + name);
}

TEST(SeedModel, EveryCultivarIsAClosedSolidAboutItsCentroid) {
  for (const std::string& name : cultivar_names()) {
    for (const SizeSpread spread : {SizeSpread::literature, SizeSpread::paper}) {
      const SeedModel seed = make_seed(name, spread, Rng(1));
      const MeshCheck check = check_watertight(seed.model.mesh);
      EXPECT_TRUE(check.ok) << name << ": " << check.problem;
      EXPECT_LT(mass_properties(seed.model.mesh).centroid_m.norm(), 1e-9) << name;
      EXPECT_EQ(seed.model.vertex_albedo.size(), seed.model.mesh.vertices_m.size());
      EXPECT_EQ(seed.model.vertex_normals.size(), seed.model.mesh.vertices_m.size());
    }
  }
}

TEST(SeedModel, TraitsAreThoseOfTheMesh) {
  for (const std::string& name : cultivar_names()) {
    const SeedModel seed = make_seed(name, SizeSpread::literature, Rng(5));
    const OrientedBox box = minimum_volume_box(seed.model.mesh.vertices_m);
    const MassProperties mass = mass_properties(seed.model.mesh);
    EXPECT_DOUBLE_EQ(trait(seed, "length"), box.size_m.x()) << name;
    EXPECT_DOUBLE_EQ(trait(seed, "width"), box.size_m.y()) << name;
    EXPECT_DOUBLE_EQ(trait(seed, "height"), box.size_m.z()) << name;
    EXPECT_DOUBLE_EQ(trait(seed, "area"), mass.area_m2) << name;
    EXPECT_DOUBLE_EQ(trait(seed, "volume"), mass.volume_m3) << name;
    // The mass was taken before the mesh moved to its centroid: the volume rounds otherwise.
    EXPECT_NEAR(trait(seed, "mass"), cultivar(name).density_kg_m3 * mass.volume_m3,
                1e-12 * seed.mass_kg + 1e-16)
        << name;
  }
}

TEST(SeedModel, TheExtentsAreTheSizeDrawnAndTheBoxAgreesWithThem) {
  for (const std::string& name : cultivar_names()) {
    const SeedModel seed = make_seed(name, SizeSpread::literature, Rng(8));
    Rng size_rng = Rng(8).fork("size");
    const Eigen::Vector3d drawn_m = draw_size_m(cultivar(name), SizeSpread::literature, size_rng);
    Eigen::AlignedBox3d extents;
    for (const Eigen::Vector3d& v : seed.model.mesh.vertices_m) extents.extend(v);
    EXPECT_LT((extents.sizes() - drawn_m).norm(), 1e-12) << name;
    // The minimum-volume box of a lopsided seed lies a few degrees off its axes: within 4 % in each
    // size.
    EXPECT_NEAR(trait(seed, "length"), drawn_m[0], 0.04 * drawn_m[0]) << name;
    EXPECT_NEAR(trait(seed, "width"), drawn_m[1], 0.04 * drawn_m[1]) << name;
    EXPECT_NEAR(trait(seed, "height"), drawn_m[2], 0.04 * drawn_m[2]) << name;
  }
}

TEST(SeedModel, MassesAreThoseOfTheCrop) {
  // Thousand-kernel masses of the lots. Three seeds: volume varies by 10-15 %, so 25 % is three
  // standard errors.
  const std::map<std::string, double> mg = {{"zhengdan958", 320}, {"tianguinuo932", 280},
                                            {"jimai22", 43},      {"aikang58", 43},
                                            {"suijing18", 26},    {"xiangyaxiangzhan", 23}};
  for (const auto& [name, expected] : mg) {
    double sum = 0;
    for (std::uint64_t i = 0; i < 3; ++i)
      sum += 1e6 * make_seed(name, SizeSpread::literature, Rng(i)).mass_kg / 3;
    EXPECT_NEAR(sum, expected, 0.25 * expected) << name;
  }
}

TEST(SeedModel, NoEdgeIsCoarserThanTheCamerasNeed) {
  // 0.3 mm: a pixel at 0.3 m of a 1280-pixel phone.
  for (const std::string& name : cultivar_names()) {
    const SeedModel seed = make_seed(name, SizeSpread::literature, Rng(2));
    const Mesh& mesh = seed.model.mesh;
    double longest_m = 0;
    for (const auto& t : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        longest_m =
            std::max(longest_m, (mesh.vertices_m[t[k]] - mesh.vertices_m[t[(k + 1) % 3]]).norm());
      }
    }
    EXPECT_LT(longest_m, name.find("xiangya") == 0 ? 0.0005 : 0.0004) << name;
  }
}

TEST(SeedModel, KeypointsLieOnTheSurface) {
  for (const std::string& name : cultivar_names()) {
    const SeedModel seed = make_seed(name, SizeSpread::literature, Rng(3));
    EXPECT_GE(seed.model.keypoints.size(), 2U);
    for (const Keypoint& keypoint : seed.model.keypoints) {
      double nearest_m = 1;
      for (const Eigen::Vector3d& v : seed.model.mesh.vertices_m) {
        nearest_m = std::min(nearest_m, (v - keypoint.in_object_m).norm());
      }
      EXPECT_LT(nearest_m, 1e-12) << name << " " << keypoint.name;
    }
  }
}

TEST(SeedModel, EveryTriangleHasAPartAndEveryPartIsThere) {
  for (const std::string& name : cultivar_names()) {
    const ObjectModel model = make_seed(name, SizeSpread::literature, Rng(3)).model;
    ASSERT_EQ(model.triangle_part.size(), model.mesh.triangles.size()) << name;
    std::vector<double> area_m2(model.part_names.size(), 0);
    double whole_m2 = 0;
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
      const auto& corner = model.mesh.triangles[t];
      const Eigen::Vector3d& a = model.mesh.vertices_m[corner[0]];
      const double triangle_m2 = (model.mesh.vertices_m[corner[1]] - a)
                                     .cross(model.mesh.vertices_m[corner[2]] - a)
                                     .norm() /
                                 2;
      area_m2.at(model.triangle_part[t]) += triangle_m2;
      whole_m2 += triangle_m2;
    }
    for (std::size_t part = 0; part < area_m2.size(); ++part) {
      // The rest of the stalk is the least, a thousandth; the body (for rice, the lemma) the most.
      EXPECT_GT(area_m2[part], 5e-4 * whole_m2) << name << " " << model.part_names[part];
      if (part > 0) {
        EXPECT_LT(area_m2[part], area_m2[0]) << name << " " << model.part_names[part];
      }
    }
  }
}

TEST(SeedModel, KeypointsLieOnTheirParts) {
  const std::map<std::string, std::map<std::string, std::string>> expected = {
      {"zhengdan958", {{"tip", "tip_cap"}, {"embryo", "embryo"}}},
      {"jimai22", {{"crown", "brush"}, {"embryo", "embryo"}}},
      {"suijing18", {{"tip", "pedicel"}, {"crown", "apiculus"}}}};
  for (const auto& [name, parts] : expected) {
    const ObjectModel model = make_seed(name, SizeSpread::literature, Rng(3)).model;
    for (const Keypoint& keypoint : model.keypoints) {
      const auto part = parts.find(keypoint.name);
      if (part == parts.end()) continue;
      std::set<std::string> around;  // of the triangles that meet there
      for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
        for (const std::uint32_t i : model.mesh.triangles[t]) {
          if (model.mesh.vertices_m[i] == keypoint.in_object_m)
            around.insert(model.part_names.at(model.triangle_part[t]));
        }
      }
      EXPECT_TRUE(around.contains(part->second)) << name << " " << keypoint.name;
    }
  }
}

TEST(SeedModel, RepeatsOnAnyNumberOfThreadsAndDiffersBySeed) {
  const SeedModel first = make_seed("jimai22", SizeSpread::literature, Rng(1));
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const SeedModel again = make_seed("jimai22", SizeSpread::literature, Rng(1));
    EXPECT_EQ(again.model.mesh.vertices_m, first.model.mesh.vertices_m);
    EXPECT_EQ(again.model.vertex_albedo, first.model.vertex_albedo);
  }
  EXPECT_NE(make_seed("jimai22", SizeSpread::literature, Rng(2)).model.mesh.vertices_m,
            first.model.mesh.vertices_m);
}

TEST(Specimen, AMeshThatIsNotClosedIsRefusedWithTheReason) {
  SeedModel seed = make_seed("jimai22", SizeSpread::literature, Rng(1));
  Mesh open = seed.model.mesh;
  open.triangles.pop_back();
  try {
    make_specimen("mesh:open.ply", open, 1250);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("mesh:open.ply"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("edge"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace cousin
