#include "sim/physics/bending_plant.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr double kLeastInertia_kg_m2 = 1e-15;  // mjMINVAL: the engine refuses less
constexpr int kMostSegments = 4000;

[[noreturn]] void refuse(const std::string& what, const char* key, double value,
                         const std::string& limit) {
  char number[32];
  std::snprintf(number, sizeof number, "%.6g", value);
  throw std::invalid_argument("bending plant: " + what + ": " + key + " is " + number + "; " +
                              limit);
}

void check(const std::string& what, const char* key, double value, double low, double high) {
  if (value >= low && value <= high) return;
  char limit[80];
  std::snprintf(limit, sizeof limit, "it must be in [%.6g, %.6g]", low, high);
  refuse(what, key, value, limit);
}

void check_point(const std::string& what, const Eigen::Vector3d& point_m) {
  for (int i = 0; i < 3; ++i) check(what, "a coordinate in m", point_m[i], -1e3, 1e3);
}

void check_stem(const BendingPlant& plant, std::size_t index) {
  const BendingStem& stem = plant.stems[index];
  const std::string what = "stem " + std::to_string(index);
  if (stem.parent < -1 || stem.parent >= static_cast<int>(index))
    refuse(what, "parent", stem.parent, "it must be -1 or an earlier stem");
  check(what, "parent_share", stem.parent_share, 0, 1);
  check(what, "segments", stem.segments, 1, 400);
  check(what, "young_modulus_pa", stem.young_modulus_pa, 1e4, 1e12);
  check(what, "poisson_ratio", stem.poisson_ratio, 0, 0.5);
  check(what, "density_kg_m3", stem.density_kg_m3, 1e-3, 2e4);
  check(what, "damping_time_s", stem.damping_time_s, 0, 10);
  if (!(stem.strength_pa > 0)) refuse(what, "strength_pa", stem.strength_pa, "it must be positive");
  if (stem.points_m.size() < 2 || stem.radii_m.size() != stem.points_m.size()) {
    throw std::invalid_argument("bending plant: " + what + " has " +
                                std::to_string(stem.points_m.size()) + " points and " +
                                std::to_string(stem.radii_m.size()) +
                                " radii; it needs the same number of both, at least 2");
  }
  for (const Eigen::Vector3d& p : stem.points_m) check_point(what, p);
  for (const double r : stem.radii_m) check(what, "a radius in m", r, 1e-9, 1);
  const double length = length_m(stem);
  if (!(length > 1e-6)) refuse(what, "length in m", length, "it must be above 1e-6");
  // The last section, half a segment, is the lightest; about its own axis, and twisting.
  for (int node = 1; node <= stem.segments; ++node) {
    const double share = static_cast<double>(node) / stem.segments;
    const double radius = radius_at_m(stem, share);
    const double span_m = length / stem.segments * (node == stem.segments ? 0.5 : 1);
    const double inertia =
        0.5 * stem.density_kg_m3 * std::numbers::pi * std::pow(radius, 4) * span_m;
    if (inertia < 2 * kLeastInertia_kg_m2) {
      char limit[200];
      std::snprintf(limit, sizeof limit,
                    "a section of %.3g mm of it has an inertia of %.2g kg m2 about its axis, and "
                    "the engine takes none below %.0e: use fewer segments, or leave it stiff",
                    1e3 * span_m, inertia, kLeastInertia_kg_m2);
      refuse(what, "radius in m", radius, limit);
    }
  }
  if (stem.parent < 0) return;
  const BendingStem& parent = plant.stems[static_cast<std::size_t>(stem.parent)];
  const double off_m = (stem.points_m[0] - point_at_m(parent, stem.parent_share)).norm();
  const double reach_m = 0.002 + 2 * radius_at_m(parent, stem.parent_share);
  if (off_m > reach_m) {
    char limit[80];
    std::snprintf(limit, sizeof limit, "it must be within %.3g", reach_m);
    refuse(what, "distance in m of its base from where it grows", off_m, limit);
  }
}

}  // namespace

void validate(const BendingPlant& plant) {
  int segments = 0;
  for (std::size_t i = 0; i < plant.stems.size(); ++i) {
    check_stem(plant, i);
    segments += plant.stems[i].segments;
  }
  check("all stems", "segments", segments, 0, kMostSegments);
  for (std::size_t i = 0; i < plant.loads.size(); ++i) {
    const BendingLoad& load = plant.loads[i];
    const std::string what = "load " + std::to_string(i);
    check(what, "stem", load.stem, 0, static_cast<double>(plant.stems.size()) - 1);
    check(what, "share", load.share, 0, 1);
    check(what, "mass_kg", load.mass_kg, 1e-9, 1e3);
    check(what, "drag_area_m2", load.drag_area_m2, 0, 100);
    check_point(what, load.centroid_m);
    check(what, "norm of world_from_hulls", load.world_from_hulls.norm(), 1 - 1e-6, 1 + 1e-6);
  }
  for (std::size_t i = 0; i < plant.obstacles.size(); ++i) {
    const std::string what = "obstacle " + std::to_string(i);
    check_point(what, plant.obstacles[i].world_from_box.translation_m);
    for (int k = 0; k < 3; ++k) check(what, "half_m", plant.obstacles[i].half_m[k], 1e-6, 1e3);
    check(what, "round_m", plant.obstacles[i].round_m, 1e-6, plant.obstacles[i].half_m.minCoeff());
  }
}

double depth_m(const BendingObstacle& obstacle, const Eigen::Vector3d& in_world_m) {
  const Eigen::Vector3d p = inverse(obstacle.world_from_box) * in_world_m;
  const Eigen::Vector3d inner_m = obstacle.half_m.array() - obstacle.round_m;
  const Eigen::Vector3d out = p.cwiseAbs() - inner_m;
  const double beyond_m = out.maxCoeff() < 0 ? out.maxCoeff() : out.cwiseMax(0).norm();
  return obstacle.round_m - beyond_m;
}

double length_m(const BendingStem& stem) {
  double sum = 0;
  for (std::size_t i = 1; i < stem.points_m.size(); ++i)
    sum += (stem.points_m[i] - stem.points_m[i - 1]).norm();
  return sum;
}

namespace {

/// The piece of a centre line that holds a share of its length, and how far along that piece.
struct Place {
  std::size_t piece = 0;
  double fraction = 0;
};

Place place_of(const BendingStem& stem, double share) {
  double left = std::clamp(share, 0.0, 1.0) * length_m(stem);
  for (std::size_t i = 0; i + 1 < stem.points_m.size(); ++i) {
    const double piece = (stem.points_m[i + 1] - stem.points_m[i]).norm();
    if (left <= piece && piece > 0) return {i, left / piece};
    left -= piece;
  }
  return {stem.points_m.size() - 2, 1};
}

std::size_t section_of(const BendingStem& stem, double share) {
  return static_cast<std::size_t>(std::clamp(share, 0.0, 1.0) * stem.segments + 0.5);
}

}  // namespace

Eigen::Vector3d point_at_m(const BendingStem& stem, double share) {
  const Place at = place_of(stem, share);
  return stem.points_m[at.piece] +
         at.fraction * (stem.points_m[at.piece + 1] - stem.points_m[at.piece]);
}

double radius_at_m(const BendingStem& stem, double share) {
  const Place at = place_of(stem, share);
  return std::lerp(stem.radii_m[at.piece], stem.radii_m[at.piece + 1], at.fraction);
}

BentPlant unbent(const BendingPlant& plant) {
  BentPlant bent;
  for (const BendingStem& stem : plant.stems) {
    const auto segments = static_cast<std::size_t>(stem.segments);
    bent.sections.emplace_back(segments + 1);
    bent.joints_rad.emplace_back(3 * segments, 0.0);
  }
  return bent;
}

Pose bent_from_unbent(const BendingPlant& plant, const BentPlant& bent, int stem, double share) {
  const auto index = static_cast<std::size_t>(stem);
  return bent.sections.at(index).at(section_of(plant.stems.at(index), share));
}

std::vector<Eigen::Vector3d> centre_line_m(const BendingPlant& plant, const BentPlant& bent,
                                           int stem) {
  const auto index = static_cast<std::size_t>(stem);
  const BendingStem& unbent = plant.stems.at(index);
  std::vector<Eigen::Vector3d> line;
  for (int node = 0; node <= unbent.segments; ++node) {
    line.push_back(bent.sections.at(index).at(static_cast<std::size_t>(node)) *
                   point_at_m(unbent, static_cast<double>(node) / unbent.segments));
  }
  return line;
}

Eigen::Vector3d bend_m(const BendingPlant& plant, const BentPlant& bent, int stem, double share,
                       const Eigen::Vector3d& point_m) {
  const auto index = static_cast<std::size_t>(stem);
  const double at = std::clamp(share, 0.0, 1.0) * plant.stems.at(index).segments;
  const std::vector<Pose>& sections = bent.sections.at(index);
  const auto before = std::min(static_cast<std::size_t>(at), sections.size() - 2);
  const Eigen::Vector3d a = sections[before] * point_m;
  const Eigen::Vector3d b = sections[before + 1] * point_m;
  return a + (at - static_cast<double>(before)) * (b - a);
}

std::vector<TimedPose> motion_of(const BendingPlant& plant, std::span<const BentPlant> frames,
                                 int stem, double share, const Pose& world_from_object) {
  std::vector<TimedPose> motion;
  motion.reserve(frames.size());
  for (const BentPlant& frame : frames) {
    motion.push_back(
        {frame.time_s, bent_from_unbent(plant, frame, stem, share) * world_from_object});
  }
  return motion;
}

}  // namespace cousin
