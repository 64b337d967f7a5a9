#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

#include "sim/physics/convex_parts.h"
#include "sim/truth/scene.h"
#include "sim/types/mesh.h"
#include "sim/types/pose.h"

namespace cousin {

/// A round stem, petiole or fruit stalk that bends and twists: a chain of stiff sections about its
/// nodes, joined by hinges at the middle of its segments, so that the sag of a cantilever is short
/// by 1 / (4 segments^2) only.
struct BendingStem {
  int parent = -1;          ///< an earlier stem that carries it; -1: held fast by the world
  double parent_share = 1;  ///< where, as a share of the parent's length
  std::vector<Eigen::Vector3d> points_m;  ///< its centre line unloaded, base first, in the world
  std::vector<double> radii_m;            ///< one for each point
  double young_modulus_pa = 1e8;
  double poisson_ratio = 0.3;
  double density_kg_m3 = 950;
  double strength_pa = std::numeric_limits<double>::infinity();  ///< stress at which it breaks
  double damping_time_s = 0.004;  ///< tau of c = tau k: the damping ratio at f is pi f tau
  int segments = 20;              ///< 1..400
};

/// A fruit, a leaf or another mass, carried stiffly by a stem.
struct BendingLoad {
  int stem = 0;
  double share = 1;  ///< of the stem's length
  double mass_kg = 0;
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();  ///< unloaded, in the world
  /// Its shape: convex parts in its own frame, with the centroid as origin. Empty: a point that
  /// touches nothing.
  std::vector<Mesh> hulls = {};
  Eigen::Quaterniond world_from_hulls = Eigen::Quaterniond::Identity();  ///< unloaded
  double drag_area_m2 = 0;  ///< drag coefficient times area, for wind
};

/// A fixed box with rounded edges that stems and loads with a shape lie on, as a bed under film.
struct BendingObstacle {
  Pose world_from_box;
  Eigen::Vector3d half_m = Eigen::Vector3d::Constant(0.1);
  double round_m = 0.01;  ///< radius of its edges, above 0 and at most the least half
};
/// Depth of a point in an obstacle; negative outside: its distance.
double depth_m(const BendingObstacle& obstacle, const Eigen::Vector3d& in_world_m);

/// What physics bends: as it would be without weight. World: z up.
struct BendingPlant {
  std::vector<BendingStem> stems;
  std::vector<BendingLoad> loads;
  std::vector<BendingObstacle> obstacles;
};

/// Finite numbers, parents before children and where they say, stems of at least two points, radii
/// and moduli of plants, masses that are not negative, at most 4000 segments in all.
/// @throws std::invalid_argument naming the stem, load or obstacle, the value and the limit; so for
/// a stem whose segments are too light for the engine, which takes no inertia below 1e-15 kg m2.
void validate(const BendingPlant& plant);

/// Arc length of a stem's centre line.
double length_m(const BendingStem& stem);
/// The point, and the radius, at a share of a stem's arc length; linear between its points.
Eigen::Vector3d point_at_m(const BendingStem& stem, double share);
double radius_at_m(const BendingStem& stem, double share);

/// How a plant is bent at a time.
struct BentPlant {
  double time_s = 0;
  /// sections[stem][node], segments + 1 of them: takes the unloaded world to the bent one about
  /// that node.
  std::vector<std::vector<Pose>> sections;
  /// joints_rad[stem]: of each hinge the two bending angles and the twist.
  std::vector<std::vector<double>> joints_rad;
};

/// Nothing bent: every section where it was.
BentPlant unbent(const BendingPlant& plant);

/// Where things at a share of a stem went: of the section that holds it.
Pose bent_from_unbent(const BendingPlant& plant, const BentPlant& bent, int stem, double share);
/// A stem's bent centre line at its nodes, evenly spaced along it.
std::vector<Eigen::Vector3d> centre_line_m(const BendingPlant& plant, const BentPlant& bent,
                                           int stem);
/// A point fixed to a stem at a share of its length, between sections without a step: blends the
/// poses of the two nodes beside it. For the vertices of a stem's mesh.
Eigen::Vector3d bend_m(const BendingPlant& plant, const BentPlant& bent, int stem, double share,
                       const Eigen::Vector3d& point_m);
/// Motion of a thing that is `world_from_object` when unloaded and fixed to a stem: for
/// Instance::motion, so for blur and for captures at different times.
std::vector<TimedPose> motion_of(const BendingPlant& plant, std::span<const BentPlant> frames,
                                 int stem, double share, const Pose& world_from_object);

}  // namespace cousin
