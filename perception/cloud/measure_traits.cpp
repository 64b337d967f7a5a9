#include "perception/cloud/measure_traits.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/config/limits.h"
#include "sim/geometry/measure.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

constexpr std::size_t kTraits = kSeedTraits.size();
using Values = std::array<double, kTraits>;

std::vector<Trait> traits_from(const Values& values, const Values& sigmas) {
  std::vector<Trait> traits;
  for (std::size_t i = 0; i < kTraits; ++i)
    traits.push_back({std::string(kSeedTraits[i]), std::string(trait_row(kSeedTraits[i]).unit),
                      values[i], sigmas[i]});
  return traits;
}

Values no_sigmas() {
  Values values;
  values.fill(kNaN);
  return values;
}

/// Mean of the finite points; NaN without any.
Eigen::Vector3d middle_of(const std::vector<Eigen::Vector3d>& points_m) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const Eigen::Vector3d& p : points_m) {
    if (!p.allFinite()) continue;
    sum += p;
    count += 1;
  }
  return count > 0 ? Eigen::Vector3d(sum / count) : Eigen::Vector3d::Constant(kNaN);
}

/// Not measured; where it stands is known by its points.
SpecimenTraits not_solved(const Surface& surface, std::string reason) {
  SpecimenTraits result;
  result.instance = surface.instance;
  result.reason = std::move(reason);
  result.centroid_in_world_m = middle_of(surface.points_m);
  return result;
}

SpecimenTraits paper_traits(const Surface& surface, double alpha_of_length) {
  if (surface.points_m.size() < 4) {
    return not_solved(surface,
                      std::to_string(surface.points_m.size()) + " points; at least 4 needed");
  }
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : surface.points_m) {
    if (!p.allFinite()) return not_solved(surface, "a point is not finite");
    centroid += (p - surface.points_m.front()) / static_cast<double>(surface.points_m.size());
  }
  const OrientedBox box = pca_box(surface.points_m);
  const double alpha_m = alpha_of_length * box.size_m.x();
  if (!(alpha_m > 0)) return not_solved(surface, "all points are one");
  const AlphaShape shape = alpha_shape(surface.points_m, alpha_m);
  if (shape.tetrahedra == 0) return not_solved(surface, "the alpha shape is empty");
  SpecimenTraits result;
  result.instance = surface.instance;
  result.status = TraitStatus::ok;
  result.centroid_in_world_m = surface.points_m.front() + centroid;
  result.traits =
      traits_from({box.size_m.x(), box.size_m.y(), box.size_m.z(), shape.area_m2, shape.volume_m3},
                  no_sigmas());
  return result;
}

Values values_of(const OrientedBox& box, const MassProperties& mass) {
  return {box.size_m.x(), box.size_m.y(), box.size_m.z(), mass.area_m2, mass.volume_m3};
}

/// Standard deviation of each trait over the samples. A sample's box is searched from the mesh's
/// own: they differ little.
Values sample_sigmas(const Surface& surface, const OrientedBox& box) {
  const std::size_t n = surface.samples_m.size();
  if (n < 2) return no_sigmas();
  std::vector<Values> values(n);
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
    values[i] = values_of(minimum_volume_box(surface.samples_m[i], box),
                          mass_properties({surface.samples_m[i], surface.mesh.triangles}));
  });
  Values sigmas{};
  for (std::size_t k = 0; k < kTraits; ++k) {
    double mean = 0, squares = 0;
    for (const Values& v : values) mean += v[k] / static_cast<double>(n);
    for (const Values& v : values) squares += (v[k] - mean) * (v[k] - mean);
    sigmas[k] = std::sqrt(squares / static_cast<double>(n - 1));
  }
  return sigmas;
}

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// Mean and standard deviation of a box's sizes over which of its local minima is the object's
/// own least.
struct BoxSizes {
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
};

/// Two boxes whose volumes differ by d, known to s, are in the other order with probability
/// Phi(-d / s); the odds of each against the least weigh it. s is that of the sizes along axes that
/// the two boxes do not share, as errors along a shared axis change both alike.
BoxSizes sizes_of(const std::vector<OrientedBox>& boxes, const Eigen::Vector3d& sigma_m) {
  const double shared = std::cos(15 * std::numbers::pi / 180);
  const OrientedBox& least = boxes.front();
  std::vector<double> weights;
  double sum = 0;
  for (const OrientedBox& box : boxes) {
    double variance = 0;  // of the relative difference of volumes
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d dots = (box.axes.transpose() * least.axes.col(k)).cwiseAbs();
      if (dots.maxCoeff() > shared) continue;
      const double relative = sigma_m[k] / least.size_m[k];
      variance += 2 * relative * relative;
    }
    const double difference = box.size_m.prod() / least.size_m.prod() - 1;
    const double x = variance > 0 ? std::max(0.0, difference) / std::sqrt(variance) : 0;
    const bool is_least = &box == &least;
    const double odds = is_least ? 1 : variance > 0 ? normal_cdf(-x) / normal_cdf(x) : 0;
    weights.push_back(odds);
    sum += odds;
  }
  BoxSizes result;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    result.mean_m += weights[i] / sum * boxes[i].size_m;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    result.sigma_m += weights[i] / sum * (boxes[i].size_m - result.mean_m).cwiseAbs2();
  }
  result.sigma_m = result.sigma_m.cwiseSqrt();
  return result;
}

SpecimenTraits mesh_traits(const Surface& surface, double pixel_m, const MeshTraitConfig& config) {
  if (surface.status != SurfaceStatus::ok) {
    return not_solved(surface, "surface: " + std::string(to_string(surface.status)));
  }
  if (surface.mesh.triangles.empty()) return not_solved(surface, "the surface has no mesh");
  SpecimenTraits result;
  result.instance = surface.instance;
  const MassProperties mass = mass_properties(surface.mesh);
  const OrientedBox box = minimum_volume_box(surface.mesh.vertices_m);
  result.centroid_in_world_m = mass.centroid_m;
  Values values = values_of(box, mass);
  if (!(values[kTraits - 1] > 0)) return not_solved(surface, "the mesh encloses no volume");
  result.status = TraitStatus::ok;
  Values sigmas = sample_sigmas(surface, box);
  const Values beyond_fit = {config.length_sigma_px * pixel_m, config.width_sigma_px * pixel_m,
                             config.height_sigma_px * pixel_m, config.area_sigma * mass.area_m2,
                             config.volume_sigma * mass.volume_m3};
  for (std::size_t k = 0; k < kTraits; ++k) sigmas[k] = std::hypot(sigmas[k], beyond_fit[k]);
  const Eigen::Vector3d length_sigmas(sigmas[0], sigmas[1], sigmas[2]);
  if (length_sigmas.allFinite() && box.size_m.z() > 0) {
    const BoxSizes sizes = sizes_of(rival_boxes(surface.mesh.vertices_m, box), length_sigmas);
    for (int k = 0; k < 3; ++k) {
      const auto trait = static_cast<std::size_t>(k);
      values[trait] = sizes.mean_m[k];
      sigmas[trait] = std::hypot(sigmas[trait], sizes.sigma_m[k]);
    }
  }
  result.traits = traits_from(values, sigmas);
  return result;
}

}  // namespace

Fields fields(PaperTraitConfig& c) {
  return {{"alpha_of_length", &c.alpha_of_length,
           "largest circumscribed radius of a kept tetrahedron over the box's length", 1e-3, 1e6}};
}

void validate(const PaperTraitConfig& config) {
  PaperTraitConfig copy = config;
  check_limits(fields(copy), "paper_traits");
}

Traits traits_as_paper(const Surfaces& surfaces, const PaperTraitConfig& config) {
  validate(config);
  Traits traits(surfaces.size());
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    traits[i] = paper_traits(surfaces[i], config.alpha_of_length);
  return traits;
}

Fields fields(MeshTraitConfig& c) {
  return {{"length_sigma_px", &c.length_sigma_px, "of lengths, beyond the fit's", 0, 100},
          {"width_sigma_px", &c.width_sigma_px, "of widths, beyond the fit's", 0, 100},
          {"height_sigma_px", &c.height_sigma_px, "of heights, beyond the fit's", 0, 100},
          {"area_sigma", &c.area_sigma, "relative, beyond the fit's", 0, 1},
          {"volume_sigma", &c.volume_sigma, "relative, beyond the fit's", 0, 1}};
}

void validate(const MeshTraitConfig& config) {
  MeshTraitConfig copy = config;
  check_limits(fields(copy), "traits");
}

Traits traits_of_meshes(const Surfaces& surfaces, double pixel_m, const MeshTraitConfig& config) {
  validate(config);
  if (std::isinf(pixel_m) || pixel_m < 0) {
    throw std::invalid_argument("traits: pixel_m = " + std::to_string(pixel_m) +
                                " is not a length");
  }
  Traits traits(surfaces.size());
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    traits[i] = mesh_traits(surfaces[i], pixel_m, config);
  return traits;
}

}  // namespace cousin
