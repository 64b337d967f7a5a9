#include "scenes/apples/orchard_sward.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/apples/orchard_ground.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
constexpr double kFarPatch_m = 1.0;
constexpr int kGrassVariants = 3, kCloverVariants = 2, kFarVariants = 2, kWeedVariants = 2;

/// A ribbon that rises and bends over: a blade of grass, a stalk, a weed's leaf.
struct Ribbon {
  Vector3d foot_m;
  double azimuth_rad = 0;
  double length_m = 0, width_m = 0;
  double lean_rad = 0, bow_rad = 0;  ///< from upright at its foot; more of it at the tip
  double widest = 0;                 ///< share of the length; 0: a wedge from the foot on
  int steps = 4;
};

/// Meshes of a patch, coloured by shares of one material's albedo.
class PatchMesh {
 public:
  PatchMesh(const char* name, const Vector3d& base) : base_(base) { model_.name = name; }

  /// @param colour  at a share of the length
  template <class Colour>
  Vector3d add(const Ribbon& r, const Colour& colour) {
    const Vector3d out(std::cos(r.azimuth_rad), std::sin(r.azimuth_rad), 0),
        side(-out.y(), out.x(), 0);
    const std::uint32_t first = count();
    Vector3d at = r.foot_m;
    for (int k = 0; k <= r.steps; ++k) {
      const double t = static_cast<double>(k) / r.steps, angle = r.lean_rad + r.bow_rad * t;
      const double half_m =
          0.5 * r.width_m *
          (r.widest > 0 ? std::sin(kPi * std::pow(0.06 + 0.92 * t, 1 / (1.6 * r.widest)))
                        : 1 - t * t);
      const Rgbf share = share_of(colour(t));
      add_vertex(at - std::max(half_m, 5e-5) * side, share);
      add_vertex(at + std::max(half_m, 5e-5) * side, share);
      if (k > 0) {
        const std::uint32_t a = first + 2 * static_cast<std::uint32_t>(k - 1);
        model_.mesh.triangles.push_back({a, a + 1, a + 3});
        model_.mesh.triangles.push_back({a, a + 3, a + 2});
      }
      if (k < r.steps)
        at += r.length_m / r.steps * (std::sin(angle) * out + std::cos(angle) * Vector3d::UnitZ());
    }
    return at;
  }

  /// A leaflet of clover about a point: heart-shaped, with a pale chevron.
  void add_leaflet(const Vector3d& at_m, double azimuth_rad, double length_m, double tilt_rad,
                   const Vector3d& colour) {
    const Vector3d out(std::cos(azimuth_rad) * std::cos(tilt_rad),
                       std::sin(azimuth_rad) * std::cos(tilt_rad), std::sin(tilt_rad));
    const Vector3d side = Vector3d::UnitZ().cross(out).normalized();
    constexpr std::uint32_t kRim = 10;
    const std::uint32_t middle = count();
    add_vertex(at_m + 0.55 * length_m * out, share_of(1.7 * colour));
    for (std::uint32_t k = 0; k < kRim; ++k) {
      const double a = 2 * kPi * k / kRim;
      const double notch = k == 0 ? 0.80 : 1;
      add_vertex(at_m + length_m * (0.52 + 0.48 * notch * std::cos(a)) * out +
                     0.46 * length_m * std::sin(a) * (0.9 + 0.2 * std::cos(a)) * side,
                 share_of(colour));
      model_.mesh.triangles.push_back({middle, middle + 1 + k, middle + 1 + (k + 1) % kRim});
    }
  }

  ObjectModel take() { return std::move(model_); }

 private:
  std::uint32_t count() const { return static_cast<std::uint32_t>(model_.mesh.vertices_m.size()); }
  Rgbf share_of(const Vector3d& colour) const {
    return to_rgb(colour.cwiseQuotient(base_).cwiseMin(1.0));
  }
  void add_vertex(const Vector3d& at_m, const Rgbf& share) {
    model_.mesh.vertices_m.push_back(at_m);
    model_.vertex_albedo.push_back(share);
  }

  Vector3d base_;
  ObjectModel model_;
};

struct SwardColours {
  Vector3d fresh, dry, clover, base;
};
SwardColours colours_of(const OrchardConfig::Ground& c) {
  const Vector3d fresh = color_vector(c.grass), dry = color_vector(c.grass_dry),
                 clover = color_vector(c.clover);
  return {fresh, dry, clover, (1.15 * fresh).cwiseMax(dry).cwiseMax(1.7 * clover)};
}

/// Tillers stand in tufts; the mower has cut the tallest at one height.
void add_grass(PatchMesh& mesh, const OrchardConfig::Ground& c, const SwardColours& colours,
               double half_m, int blades, double width, const Rng& rng) {
  constexpr int kTuft = 7;
  for (int b = 0; b < blades; ++b) {
    Rng own = rng.fork(static_cast<std::uint64_t>(b));
    Rng tuft = rng.fork("tuft").fork(static_cast<std::uint64_t>(b / kTuft));
    const Vector3d middle(uniform(tuft, -half_m, half_m), uniform(tuft, -half_m, half_m), -0.012);
    const double tall = uniform(tuft, 0.6, 1.25);
    Ribbon blade;
    blade.foot_m = middle + 0.014 * width * Vector3d(normal(own), normal(own), 0);
    blade.azimuth_rad = uniform(own, 0, 2 * kPi);
    blade.length_m = tall * c.grass_m * uniform(own, 0.45, 1.35);
    blade.width_m = width * uniform(own, 0.0016, 0.0038);
    blade.lean_rad = uniform(own, 0.05, 0.95);
    blade.bow_rad = uniform(own, 0.2, 1.4);
    blade.steps = width > 1 ? 2 : 4;
    const bool is_dry = uniform(own) < 0.10;
    const double tone = uniform(own, 0.7, 1.15);
    mesh.add(blade, [&](double t) {
      // Sheaths at the foot are pale and partly dead.
      const double low = (1 - t) * (1 - t);
      return Vector3d(
          tone * (is_dry ? colours.dry
                         : Vector3d(colours.fresh + 0.35 * low * (colours.dry - colours.fresh))));
    });
  }
}

ObjectModel grass_patch(const OrchardConfig::Ground& c, const Rng& rng) {
  const SwardColours colours = colours_of(c);
  PatchMesh mesh("sward", colours.base);
  add_grass(mesh, c, colours, 0.55 * c.patch_m, c.blades, 1, rng);
  return mesh.take();
}

ObjectModel clover_patch(const OrchardConfig::Ground& c, const Rng& rng) {
  const SwardColours colours = colours_of(c);
  PatchMesh mesh("sward with clover", colours.base);
  const double half = 0.5 * c.patch_m;
  add_grass(mesh, c, colours, half, c.blades / 3, 1, rng.fork("grass"));
  for (int i = 0; i < c.blades / 5; ++i) {
    Rng own = rng.fork(static_cast<std::uint64_t>(i));
    Ribbon stalk;
    stalk.foot_m = {uniform(own, -half, half), uniform(own, -half, half), -0.01};
    stalk.azimuth_rad = uniform(own, 0, 2 * kPi);
    stalk.length_m = c.grass_m * uniform(own, 0.45, 1.0);
    stalk.width_m = 0.0011;
    stalk.lean_rad = uniform(own, 0, 0.5);
    stalk.bow_rad = -0.3 * stalk.lean_rad;
    stalk.steps = 2;
    const double tone = uniform(own, 0.75, 1.1), length_m = uniform(own, 0.008, 0.016),
                 turn = uniform(own, 0, 2 * kPi);
    const Vector3d top = mesh.add(stalk, [&](double) { return Vector3d(tone * colours.fresh); });
    for (int k = 0; k < 3; ++k)
      mesh.add_leaflet(top, turn + 2 * kPi * k / 3, length_m, uniform(own, -0.25, 0.35),
                       tone * colours.clover);
  }
  return mesh.take();
}

/// Wide blades stand for several where a pixel is wider than one.
ObjectModel far_patch(const OrchardConfig::Ground& c, const Rng& rng) {
  const SwardColours colours = colours_of(c);
  PatchMesh mesh("sward far away", colours.base);
  const double per_m2 = c.blades / (c.patch_m * c.patch_m) / 12;
  add_grass(mesh, c, colours, 0.55 * kFarPatch_m,
            static_cast<int>(per_m2 * kFarPatch_m * kFarPatch_m), 3.5, rng);
  return mesh.take();
}

/// A rosette pressed to the ground, as dandelion and plantain survive mower and spray.
ObjectModel weed(const OrchardConfig::Ground& c, Rng rng) {
  const SwardColours colours = colours_of(c);
  PatchMesh mesh("weed", colours.base);
  const int leaves = 9 + static_cast<int>(uniform_index(rng, 6));
  for (int i = 0; i < leaves; ++i) {
    Ribbon leaf;
    leaf.foot_m = {0, 0, -0.004};
    leaf.azimuth_rad = 2.39996 * i + 0.2 * normal(rng);
    leaf.length_m = uniform(rng, 0.05, 0.13);
    leaf.width_m = leaf.length_m * uniform(rng, 0.2, 0.34);
    leaf.lean_rad = uniform(rng, 0.6, 1.15);
    leaf.bow_rad = uniform(rng, 0.2, 0.7);
    leaf.widest = 0.62;
    leaf.steps = 9;
    const double tone = uniform(rng, 0.8, 1.1);
    mesh.add(leaf, [&](double t) { return Vector3d(tone * (1.25 - 0.3 * t) * colours.clover); });
  }
  return mesh.take();
}

Material blade_material(const OrchardConfig::Ground& c) {
  Material blades;
  blades.name = "grass";
  blades.kind = SurfaceKind::leaf;
  blades.albedo = to_rgb(colours_of(c).base);
  blades.transmittance = to_rgb(Vector3d(0.6 * color_vector(c.grass)));
  blades.roughness = 0.5;
  blades.ior = 1.45;
  blades.infrared_albedo = 0.45F;
  blades.infrared_transmittance = 0.4F;
  return blades;
}

/// One square grid of patches on the floor.
class SwardPlacer {
 public:
  SwardPlacer(Scene& scene, const OrchardFloor& floor, int material)
      : scene_(scene), floor_(floor), material_(material) {}

  void add(const char* name, int model, double x_m, double y_m, double turn_rad) {
    add_instance(scene_, name, "ground", model, material_,
                 {Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Vector3d::UnitZ())),
                  Vector3d(x_m, y_m, floor_.height_m(x_m, y_m))});
  }

  /// @param place  called with the cell's middle and its stream where distance is in the range
  template <class Place>
  static void grid(double cell_m, double from_m, double to_m, const Rng& rng, const Place& place) {
    const int n = static_cast<int>(std::ceil(to_m / cell_m));
    for (int j = -n; j <= n; ++j) {
      for (int i = -n; i <= n; ++i) {
        const double x = i * cell_m, y = j * cell_m, distance = std::hypot(x, y);
        if (distance > to_m || distance <= from_m) continue;
        place(x, y, rng.fork(static_cast<std::uint64_t>((j + n) * (2 * n + 1) + i + n)));
      }
    }
  }

 private:
  Scene& scene_;
  const OrchardFloor& floor_;
  int material_;
};

template <class Make>
int add_models(Scene& scene, int count, const Rng& rng, const Make& make) {
  const int first = static_cast<int>(scene.models.size());
  for (int v = 0; v < count; ++v)
    scene.models.push_back(make(rng.fork(static_cast<std::uint64_t>(v))));
  return first;
}

}  // namespace

double OrchardFloor::alley(double x_m, double y_m) const {
  const double row_m = config.tree.row_m;
  const double off = std::abs(y_m - row_m * std::round(y_m / row_m));
  const double edge =
      config.ground.strip_m * (1 + 0.25 * noise3({x_m / 0.35, y_m / 0.35, 0.5}, key + 4));
  return smoothstep(edge - 0.06, edge + 0.06, off);
}

double OrchardFloor::height_m(double x_m, double y_m) const {
  const double clods = fractal_noise3({x_m / 0.11, y_m / 0.11, 0.3}, 4, key);
  const double swells = noise3({x_m / 1.3, y_m / 1.3, 0.8}, key + 1);
  // Trees stand on a low ridge.
  const double row_m = config.tree.row_m;
  const double off = std::abs(y_m - row_m * std::round(y_m / row_m));
  return 0.010 * clods + 0.02 * swells + 0.05 * std::exp(-std::pow(off / 0.6, 2)) - 0.05;
}

void add_sward(Scene& scene, const OrchardFloor& floor, const Rng& rng) {
  const auto& c = floor.config.ground;
  if (!(c.reach_m > 0)) return;
  scene.materials.push_back(blade_material(c));
  SwardPlacer placer(scene, floor, static_cast<int>(scene.materials.size()) - 1);
  const auto made = [&](const char* what, int count, auto make) {
    return add_models(scene, count, rng.fork(what), [&](const Rng& own) { return make(c, own); });
  };
  const int grass = made("grass", kGrassVariants, grass_patch);
  const int clover = made("clover", kCloverVariants, clover_patch);
  const int far = made("far", kFarVariants, far_patch);
  const int weeds = made("weed", kWeedVariants, weed);
  const auto variant = [](Rng& own, int count) {
    return static_cast<int>(uniform_index(own, static_cast<std::uint64_t>(count)));
  };
  SwardPlacer::grid(c.patch_m, -1, c.reach_m, rng.fork("near"), [&](double x, double y, Rng own) {
    const double turn = uniform(own, 0, 2 * kPi);
    // Fewer patches where the strip's edge frays.
    if (uniform(own) > floor.alley(x, y)) return;
    const double place = 0.5 + 0.9 * noise3({x / 0.8, y / 0.8, 0.4}, floor.key + 7);
    const bool is_clover = place < c.clover_share;
    const int model =
        is_clover ? clover + variant(own, kCloverVariants) : grass + variant(own, kGrassVariants);
    placer.add("sward", model, x, y, turn);
  });
  SwardPlacer::grid(kFarPatch_m, c.reach_m, 3 * c.reach_m, rng.fork("far"),
                    [&](double x, double y, Rng own) {
                      const double turn = uniform(own, 0, 2 * kPi);
                      if (floor.alley(x, y) < 0.5) return;
                      placer.add("sward", far + variant(own, kFarVariants), x, y, turn);
                    });
  for (int i = 0; i < c.weeds; ++i) {
    Rng own = rng.fork("weeds").fork(static_cast<std::uint64_t>(i));
    const double x = uniform(own, -3, 3),
                 y = c.strip_m * uniform(own, 0.35, 1.1) * (uniform(own) < 0.5 ? -1 : 1);
    placer.add("weed", weeds + variant(own, kWeedVariants), x, y, uniform(own, 0, 2 * kPi));
  }
}

}  // namespace cousin
