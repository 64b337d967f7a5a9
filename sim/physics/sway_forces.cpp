#include "sim/physics/sway_forces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr double kGust_s = 0.002;

Eigen::Vector3d vector_at(const mjtNum* values, int body) {
  return Eigen::Map<const Eigen::Vector3d>(values + 3 * static_cast<std::ptrdiff_t>(body));
}

void add(mjData& data, int body, const Eigen::Vector3d& force_n, const Eigen::Vector3d& lever_m) {
  Eigen::Map<Eigen::Vector3d> force(data.xfrc_applied + 6 * static_cast<std::ptrdiff_t>(body));
  Eigen::Map<Eigen::Vector3d> torque(data.xfrc_applied + 6 * static_cast<std::ptrdiff_t>(body) + 3);
  force += force_n;
  torque += lever_m.cross(force_n);
}

}  // namespace

StemStrain strain_of(const PlantStress& stress) {
  return {stress.stress_pa, stress.ratio, stress.stem, stress.share};
}

void check_sway(const BendingPlant& plant, const std::vector<HandPush>& pushes,
                const SwayConfig& config) {
  validate(config);
  validate(plant);
  for (std::size_t s = 0; s < plant.stems.size(); ++s) {
    if (plant.stems[s].damping_time_s >= config.step_s) continue;
    throw std::invalid_argument("sway: stem " + std::to_string(s) + ": damping_time_s is " +
                                std::to_string(plant.stems[s].damping_time_s) +
                                "; it must be at least the step, " + std::to_string(config.step_s));
  }
  for (const HandPush& push : pushes) {
    const bool sound = push.stem >= 0 && push.stem < static_cast<int>(plant.stems.size()) &&
                       push.share >= 0 && push.share <= 1 && push.seconds > 0 &&
                       push.force_n.allFinite() && push.force_n.norm() <= 1000;
    if (!sound) {
      throw std::invalid_argument(
          "sway: a push needs a stem that exists, a share in [0, 1], a positive time and at most "
          "1000 N; it is of stem " +
          std::to_string(push.stem) + " at " + std::to_string(push.share) + " for " +
          std::to_string(push.seconds) + " s");
    }
  }
}

SwayForces::SwayForces(const BendingPlant& plant, const HingedPlant& engine,
                       const SwayConfig& config, const std::vector<HandPush>& pushes,
                       WindField wind)
    : plant_(plant), engine_(engine), config_(config), pushes_(pushes), wind_(std::move(wind)) {}

long SwayForces::hold_steps() const { return std::max(1L, std::lround(kGust_s / config_.step_s)); }

void SwayForces::fix_air(const mjData& rest) {
  const auto modes = static_cast<Eigen::Index>(wind_.modes.size());
  const auto bodies = static_cast<Eigen::Index>(engine_.model->nbody);
  amplitudes_m_s_.resize(3, modes);
  cosines_.resize(modes, bodies);
  sines_.resize(modes, bodies);
  for (Eigen::Index m = 0; m < modes; ++m) {
    const WindField::Mode& mode = wind_.modes[static_cast<std::size_t>(m)];
    amplitudes_m_s_.col(m) = mode.amplitude_m_s;
    for (Eigen::Index b = 0; b < bodies; ++b) {
      const double angle =
          mode.wave_rad_m.dot(vector_at(rest.xipos, static_cast<int>(b))) + mode.phase_rad;
      cosines_(m, b) = std::cos(angle);
      sines_(m, b) = std::sin(angle);
    }
  }
}

void SwayForces::advance_air(double time_s) {
  time_cosines_.resize(cosines_.rows());
  time_sines_.resize(cosines_.rows());
  for (Eigen::Index m = 0; m < cosines_.rows(); ++m) {
    const double angle = wind_.modes[static_cast<std::size_t>(m)].angular_rad_s * time_s;
    time_cosines_[m] = std::cos(angle);
    time_sines_[m] = std::sin(angle);
  }
}

Eigen::Vector3d SwayForces::air_m_s(const mjData& data, int body) const {
  if (cosines_.cols() == 0) return wind_m_s(wind_, vector_at(data.xipos, body), data.time);
  const Eigen::ArrayXd waves = time_cosines_ * cosines_.col(body) - time_sines_ * sines_.col(body);
  return wind_.mean_m_s + amplitudes_m_s_ * waves.matrix();
}

void SwayForces::apply(mjData& data) {
  if (cosines_.cols() > 0) advance_air(data.time);
  mju_zero(data.xfrc_applied, 6 * engine_.model->nbody);
  if (config_.air_density_kg_m3 > 0) {
    for (const PlantHinge& hinge : engine_.hinges) push_stem(data, hinge);
    for (std::size_t i = 0; i < plant_.loads.size(); ++i) push_load(data, i);
  }
  for (const HandPush& push : pushes_) push_by_hand(data, push);
}

/// 1/2 rho A |v| v of the air past a body's centre of mass.
Eigen::Vector3d SwayForces::drag_n(const mjData& data, int body, const Eigen::Vector3d& along,
                                   double drag_area_m2) const {
  mjtNum moving[6];  // rotation, then translation, at the centre of mass
  mj_objectVelocity(engine_.model.get(), &data, mjOBJ_BODY, body, moving, 0);
  Eigen::Vector3d past =
      air_m_s(data, body) - Eigen::Map<const Eigen::Vector3d>(static_cast<mjtNum*>(moving) + 3);
  past -= past.dot(along) * along;  // a stem feels what comes across it
  return 0.5 * config_.air_density_kg_m3 * drag_area_m2 * past.norm() * past;
}

void SwayForces::push_stem(mjData& data, const PlantHinge& hinge) const {
  const BendingStem& stem = plant_.stems[hinge.stem];
  const double span_m = length_m(stem) / stem.segments * (hinge.node == stem.segments ? 0.5 : 1);
  const mjtNum* q = data.xquat + 4 * static_cast<std::ptrdiff_t>(hinge.body);
  const Eigen::Vector3d along = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * hinge.along;
  add(data, hinge.body,
      drag_n(data, hinge.body, along, config_.drag_coefficient * 2 * hinge.radius_m * span_m),
      Eigen::Vector3d::Zero());
}

void SwayForces::push_load(mjData& data, std::size_t i) const {
  if (!(plant_.loads[i].drag_area_m2 > 0)) return;
  const int body = engine_.load_body[i];
  add(data, body, drag_n(data, body, Eigen::Vector3d::Zero(), plant_.loads[i].drag_area_m2),
      Eigen::Vector3d::Zero());
}

void SwayForces::push_by_hand(mjData& data, const HandPush& push) const {
  const double phase = (data.time - push.begin_s) / push.seconds;
  if (phase <= 0 || phase >= 1) return;
  const auto s = static_cast<std::size_t>(push.stem);
  const BendingStem& stem = plant_.stems[s];
  const int node = static_cast<int>(push.share * stem.segments + 0.5);
  if (node == 0) return;  // held by what carries it
  const PlantHinge& hinge =
      engine_.hinges[engine_.first_hinge[s] + static_cast<std::size_t>(node - 1)];
  const mjtNum* q = data.xquat + 4 * static_cast<std::ptrdiff_t>(hinge.body);
  const Eigen::Vector3d at =
      vector_at(data.xpos, hinge.body) +
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * (point_at_m(stem, push.share) - hinge.at_m);
  add(data, hinge.body, std::sin(std::numbers::pi * phase) * push.force_n,
      at - vector_at(data.xipos, hinge.body));
}

}  // namespace cousin
