#include "scenes/seeds/placing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "sim/physics/settle.h"
#include "sim/types/not_built.h"

namespace cousin {
namespace {

/// Release spots whose bounding spheres keep the gap, drawn one after the other; nothing if 2000
/// darts in a row miss.
std::optional<std::vector<Pose>> draw_spots(const std::vector<BoardSpecimen>& specimens,
                                            const SettingConfig& setting, Rng rng) {
  std::vector<Pose> poses;
  for (const BoardSpecimen& specimen : specimens) {
    const double reach_m = std::min(setting.spot_radius_m, setting.reach_m - specimen.radius_m);
    bool placed = false;
    for (int dart = 0; dart < 2000 && !placed; ++dart) {
      const double r = std::max(0.0, reach_m) * std::sqrt(uniform(rng));
      const double angle = 2 * std::numbers::pi * uniform(rng);
      const Eigen::Vector3d spot(r * std::cos(angle), r * std::sin(angle), 0);
      placed = true;
      for (std::size_t j = 0; j < poses.size() && placed; ++j) {
        const double apart_m = (poses[j].translation_m - spot).norm();
        placed = apart_m >= specimen.radius_m + specimens[j].radius_m + setting.spot_gap_m;
      }
      if (placed) poses.push_back({random_rotation(rng), spot});
    }
    if (!placed) return {};
  }
  return poses;
}

/// The outline seen from above, as the convex hull's corners at many directions: enough for gaps of
/// a millimetre.
std::vector<Eigen::Vector2d> outline(const Mesh& mesh, const Pose& world_from_body) {
  constexpr int kDirections = 64;
  std::vector<Eigen::Vector2d> corners(kDirections);
  std::vector<double> most(kDirections, -1e9);
  std::vector<Eigen::Vector2d> sides;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    sides.emplace_back(std::cos(angle), std::sin(angle));
  }
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    const Eigen::Vector2d p = (world_from_body * vertex).head<2>();
    for (std::size_t k = 0; k < kDirections; ++k) {
      const double d = sides[k].dot(p);
      if (d > most[k]) {
        most[k] = d;
        corners[k] = p;
      }
    }
  }
  return corners;
}

/// Gap between two convex outlines along the best of the directions that separate them; negative
/// where they overlap.
double gap_m(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  double widest = -1e9;
  constexpr int kDirections = 128;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    const Eigen::Vector2d side(std::cos(angle), std::sin(angle));
    double a_most = -1e9;
    double b_least = 1e9;
    for (const Eigen::Vector2d& p : a) a_most = std::max(a_most, side.dot(p));
    for (const Eigen::Vector2d& p : b) b_least = std::min(b_least, side.dot(p));
    widest = std::max(widest, b_least - a_most);
  }
  return widest;
}

/// Moves specimens that rest too near another, or too far out, to spots of their own. The board is
/// a plane: a body at rest that touches no other is at rest anywhere on it. Returns why that is not
/// possible; empty if it is done.
std::string slide_apart(const std::vector<BoardSpecimen>& specimens, const SettingConfig& setting,
                        Rng rng, std::vector<Pose>& poses) {
  constexpr double kLeaning_m = 2e-4;  // nearer than this, one may lean on the other
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    outlines.push_back(outline(specimens[i].seed.model.mesh, poses[i]));
    for (std::size_t j = 0; j < i; ++j) {
      if (gap_m(outlines[i], outlines[j]) < kLeaning_m) return "two specimens touch";
    }
  }
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    const auto fits = [&](const std::vector<Eigen::Vector2d>& shape) {
      for (const Eigen::Vector2d& p : shape) {
        if (p.norm() > setting.reach_m) return false;
      }
      for (std::size_t j = 0; j < i; ++j) {
        if (gap_m(shape, outlines[j]) < setting.rest_gap_m) return false;
      }
      return true;
    };
    bool placed = fits(outlines[i]);
    Rng darts = rng.fork(i);
    for (int dart = 0; dart < 2000 && !placed; ++dart) {
      const double r = setting.spot_radius_m * std::sqrt(uniform(darts));
      const double angle = 2 * std::numbers::pi * uniform(darts);
      const Eigen::Vector2d move = Eigen::Vector2d(r * std::cos(angle), r * std::sin(angle)) -
                                   Eigen::Vector2d(poses[i].translation_m.head<2>());
      std::vector<Eigen::Vector2d> moved = outlines[i];
      for (Eigen::Vector2d& p : moved) p += move;
      placed = fits(moved);
      if (!placed) continue;
      outlines[i] = std::move(moved);
      poses[i].translation_m.head<2>() += move;
    }
    if (!placed) return "no spot is left at placing.rest_gap_m from the others";
  }
  return {};
}

}  // namespace

Eigen::Quaterniond random_rotation(Rng& rng) {
  const double u = uniform(rng);
  const double a = 2 * std::numbers::pi * uniform(rng);
  const double b = 2 * std::numbers::pi * uniform(rng);
  return {std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
          std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b)};
}

std::vector<Pose> drop_apart(const std::vector<BoardSpecimen>& specimens,
                             const SettingConfig& setting, Rng rng) {
  SettleConfig settle_config;
  settle_config.drop_height_m = setting.drop_height_m;
  std::string problem =
      "no room for " + std::to_string(specimens.size()) + " specimens on the board";
  for (int attempt = 0; attempt < setting.attempts; ++attempt) {
    const auto spots =
        draw_spots(specimens, setting, rng.fork(static_cast<std::uint64_t>(attempt)));
    if (!spots) continue;
    std::vector<SettleBody> bodies;
    for (std::size_t i = 0; i < specimens.size(); ++i) {
      bodies.push_back({&specimens[i].seed.model.mesh, specimens[i].seed.mass_kg, (*spots)[i],
                        &specimens[i].parts});
    }
    SettleResult rest = settle(bodies, settle_config);
    if (rest.status == SettleStatus::not_built) {
      throw NotBuilt("seeds: MuJoCo is not built in (WITH_MUJOCO=OFF), so nothing can be dropped");
    }
    if (rest.status == SettleStatus::engine_warning) {
      throw std::runtime_error("seeds: the physics engine gave " + std::to_string(rest.warnings) +
                               " warnings; the first: " + rest.first_warning);
    }
    if (rest.status == SettleStatus::ok) {
      const Rng slide = rng.fork("slide").fork(static_cast<std::uint64_t>(attempt));
      problem = slide_apart(specimens, setting, slide, rest.world_from_body);
      if (problem.empty()) return rest.world_from_body;
    } else {
      problem = "they did not settle: " + std::string(to_string(rest.status));
    }
  }
  double largest_m = 0;
  for (const BoardSpecimen& specimen : specimens)
    largest_m = std::max(largest_m, specimen.radius_m);
  if (largest_m > setting.reach_m) {
    problem += "; a specimen is " + std::to_string(2 * largest_m) + " m across and " +
               std::to_string(2 * setting.reach_m) + " m have room (see specimen_scale)";
  }
  throw std::runtime_error("seeds: " + std::to_string(setting.attempts) +
                           " attempts to drop the specimens failed; the last: " + problem);
}

}  // namespace cousin
