#include "benchmarks/suites/stability/stem_cases.h"

#include <Eigen/Eigenvalues>
#include <chrono>
#include <cmath>
#include <complex>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/physics/plant_model.h"
#include "sim/physics/plant_motion.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kLength_m = 0.3;
constexpr double kRadius_m = 0.0015;
constexpr double kDensity = 900;

/// A stem of 0.3 m, 3 mm across, level, held at the origin.
BendingPlant one_stem(double modulus_pa, int segments, double tau_s) {
  BendingStem stem;
  stem.points_m = {{0, 0, 0}, {kLength_m, 0, 0}};
  stem.radii_m = {kRadius_m, kRadius_m};
  stem.young_modulus_pa = modulus_pa;
  stem.density_kg_m3 = kDensity;
  stem.damping_time_s = tau_s;
  stem.segments = segments;
  BendingPlant plant;
  plant.stems = {stem};
  return plant;
}

double bending_stiffness_n_m2(double modulus_pa) {
  return modulus_pa * kPi / 4 * std::pow(kRadius_m, 4);
}

double theory_rad_s(double modulus_pa) {
  const double mass_kg_m = kDensity * kPi * kRadius_m * kRadius_m;
  return std::pow(1.87510407 / kLength_m, 2) *
         std::sqrt(bending_stiffness_n_m2(modulus_pa) / mass_kg_m);
}

std::string stem_name(double modulus_pa, int segments) {
  char name[80];
  std::snprintf(name, sizeof name, "stem, E %.3g GPa, %d segments", 1e-9 * modulus_pa, segments);
  return name;
}

/// A stem without weight in the engine, bending only.
struct Swing {
  BendingPlant plant;
  HingedPlant engine;
  EngineData data;
  Swing(const BendingPlant& given, double step_s, const std::string& integrator)
      : plant(given),
        engine(make_plant_model(plant, {.step_s = step_s,
                                        .integrator = integrator,
                                        .gravity_m_s2 = 0,
                                        .contacts = false,
                                        .twists = false})),
        data(make_data(*engine.model)) {}
  void step() { mj_step(engine.model.get(), data.get()); }
  double tip_m() {
    mj_kinematics(engine.model.get(), data.get());
    return centre_line_m(plant, bent_plant(plant, engine, *data), 0).back().z();
  }
};

/// Whether a small kink of every hinge stays small for 1500 steps.
bool is_stable(const BendingPlant& plant, double step_s, const std::string& integrator) {
  const EngineWatch watch;
  Swing swing(plant, step_s, integrator);
  const auto angles = static_cast<std::size_t>(swing.engine.model->nq);
  for (std::size_t i = 0; i < angles; ++i) swing.data->qpos[i] = i % 4 < 2 ? 1e-7 : -1e-7;
  for (int i = 0; i < 1500; ++i) {
    swing.step();
    for (std::size_t k = 0; k < angles; ++k) {
      // A thousandfold: a stable chain's kinks add up to its number of hinges at most.
      if (!(std::abs(swing.data->qpos[k]) < 1e-4) || watch.warnings(*swing.data) > 0) return false;
    }
  }
  return true;
}

double longest_step_s(const BendingPlant& plant, const std::string& integrator) {
  double low = 1e-9;
  double high = 0.02;
  while (high / low > 1.02) {
    const double middle = std::sqrt(low * high);
    (is_stable(plant, middle, integrator) ? low : high) = middle;
  }
  return low;
}

/// The chain's modes, from its mass matrix and stiffness, without steps.
struct Modes {
  double first_rad_s = 0;
  double last_rad_s = 0;
  Eigen::VectorXd first_shape;  ///< angles
};

Modes modes_of(Swing& swing) {
  const mjModel& model = *swing.engine.model;
  mj_forward(&model, swing.data.get());
  const Eigen::Index n = model.nv;
  Eigen::Matrix<double, -1, -1, Eigen::RowMajor> mass(n, n);
  mj_fullM(&model, mass.data(), swing.data->qM);
  const Eigen::VectorXd stiffness = Eigen::Map<const Eigen::VectorXd>(model.jnt_stiffness, n);
  // 1 / omega^2 as eigenvalues of K^-1/2 M K^-1/2.
  const Eigen::VectorXd root = stiffness.cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(root.asDiagonal() * mass *
                                                              root.asDiagonal());
  Modes modes;
  modes.first_rad_s = 1 / std::sqrt(solver.eigenvalues()[n - 1]);
  modes.last_rad_s = 1 / std::sqrt(solver.eigenvalues()[0]);
  modes.first_shape = root.cwiseProduct(solver.eigenvectors().col(n - 1));
  // Bending has two equal modes; of their mixture keep the one that lifts the tip.
  for (Eigen::Index i = 0; i < n; ++i) {
    if (std::abs(model.jnt_axis[3 * i + 1]) < 0.5) modes.first_shape[i] = 0;
  }
  return modes;
}

/// Longest stable step for a mode of `omega` and c = tau k. Semi-implicit Euler with implicit
/// damping: h^2 omega^2 < 4 + 2 h tau omega^2. Runge and Kutta's fourth order: |R(h lambda)| < 1.
double theory_step_s(const std::string& integrator, double omega, double tau_s) {
  if (integrator != "RK4") return tau_s + std::sqrt(tau_s * tau_s + 4 / (omega * omega));
  const std::complex<double> half(-0.5 * tau_s * omega * omega, 0);
  const std::complex<double> root = std::sqrt(half * half - omega * omega);
  double low = 0;
  double high = 4 / omega;
  for (int i = 0; i < 60; ++i) {
    const double h = 0.5 * (low + high);
    double growth = 0;
    for (const std::complex<double> lambda : {half + root, half - root}) {
      const std::complex<double> z = h * lambda;
      growth =
          std::max(growth, std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))));
    }
    (growth < 1 ? low : high) = h;
  }
  return low;
}

void longest_step_rows(std::vector<StabilityRow>& rows, bool quick) {
  struct Case {
    double modulus_pa;
    int segments;
  };
  for (const Case& c : {Case{1e8, 10}, Case{1e9, 20}, Case{1e8, 40}, Case{5e9, 40}}) {
    if (quick && c.segments > 20) continue;
    for (const double tau_s : {0.0, 0.001}) {
      const BendingPlant plant = one_stem(c.modulus_pa, c.segments, tau_s);
      Swing swing(plant, 0.001, "Euler");
      const double omega = modes_of(swing).last_rad_s;
      for (const char* integrator : {"Euler", "implicit", "RK4"}) {
        const std::string name = stem_name(c.modulus_pa, c.segments) +
                                 (tau_s > 0 ? ", c = tau k, tau 1 ms, " : ", no damping, ") +
                                 integrator;
        const double longest_s = longest_step_s(plant, integrator);
        rows.push_back(make_row(name, "longest stable step", "s", kNone, longest_s));
        // The search stops at 2 %; growth of a part in two hundred a step takes it all 1500.
        rows.push_back(make_row(name, "off theory of the fastest mode, relative", "", 0.03,
                                std::abs(longest_s / theory_step_s(integrator, omega, tau_s) - 1)));
      }
    }
  }
}

void theory_rows(std::vector<StabilityRow>& rows) {
  for (const int segments : {5, 10, 20, 40}) {
    const std::string name = stem_name(1e10, segments);
    BendingPlant plant = one_stem(1e10, segments, 0.004);
    Swing swing(plant, 0.001, "Euler");
    // The limit is 1 % at 20; theory of the chain, 1 / (4 N^2), is far inside it.
    const double limit = segments >= 20 ? 0.01 : kNone;
    rows.push_back(make_row(name, "first frequency off theory, relative", "", limit,
                            std::abs(modes_of(swing).first_rad_s / theory_rad_s(1e10) - 1)));
    const double mass_kg = 0.0005;
    plant.loads = {{.stem = 0, .share = 1, .mass_kg = mass_kg, .centroid_m = {kLength_m, 0, 0}}};
    const SagResult result = sag(plant, {.rest_m = 1e-7});
    const double weight_n_m = kDensity * kPi * kRadius_m * kRadius_m * 9.81;
    const double theory_m =
        (mass_kg * 9.81 * std::pow(kLength_m, 3) / 3 + weight_n_m * std::pow(kLength_m, 4) / 8) /
        bending_stiffness_n_m2(1e10);
    const double tip_m = -centre_line_m(plant, result.bent, 0).back().z();
    rows.push_back(make_row(name, "tip's sag off P L^3 / 3 E I + w L^4 / 8 E I, relative", "",
                            limit, std::abs(tip_m / theory_m - 1)));
  }
}

/// Five swings in the first mode, 1 mm at the tip: the largest difference from the beam's damped
/// cosine over the last of them, as a share of the amplitude there.
void swing_row(std::vector<StabilityRow>& rows, int segments, double step_s,
               const std::string& integrator) {
  const double modulus_pa = 1e9;
  const double tau_s = 0.001;
  char name[120];
  std::snprintf(name, sizeof name, "%s, tau 1 ms, swing of 1 mm, h %.3g ms, %s",
                stem_name(modulus_pa, segments).c_str(), 1e3 * step_s, integrator.c_str());
  const EngineWatch watch;
  Swing swing(one_stem(modulus_pa, segments, tau_s), step_s, integrator);
  const Modes modes = modes_of(swing);
  Eigen::Map<Eigen::VectorXd> angles(swing.data->qpos, swing.engine.model->nq);
  angles = 1e-5 * modes.first_shape / modes.first_shape.cwiseAbs().maxCoeff();
  angles *= 0.001 / swing.tip_m();
  const double omega = theory_rad_s(modulus_pa);
  const double decay_per_s = 0.5 * tau_s * omega * omega;
  const double damped = std::sqrt(omega * omega - decay_per_s * decay_per_s);
  const double end_s = 5 * 2 * kPi / omega;
  double off_m = 0;
  const auto start = std::chrono::steady_clock::now();
  while (swing.data->time < end_s) {
    swing.step();
    const double t = swing.data->time;
    if (t < 0.8 * end_s) continue;
    const double theory_m = 0.001 * std::exp(-decay_per_s * t) *
                            (std::cos(damped * t) + decay_per_s / damped * std::sin(damped * t));
    off_m = worse(off_m, std::abs(swing.tip_m() - theory_m));
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double off = off_m / (0.001 * std::exp(-decay_per_s * 0.8 * end_s));
  const bool sound = watch.warnings(*swing.data) == 0;
  // 10 pi of phase times the chain's 0.06 % and the step's (omega h)^2 / 24, twice for the rest.
  const bool preset = segments == 20 && step_s <= 0.0005 && integrator == "Euler";
  rows.push_back(make_row(name, "off theory in the fifth swing, of its amplitude", "",
                          preset ? 0.05 : kNone,
                          sound ? off : std::numeric_limits<double>::infinity()));
  rows.push_back(make_row(name, "wall time", "s", kNone, seconds));
}

void swing_rows(std::vector<StabilityRow>& rows, bool quick) {
  for (const int segments : {5, 10, 20, 40}) {
    if (!quick || segments == 20) swing_row(rows, segments, 0.0005, "Euler");
  }
  for (const double step_s : {0.001, 0.00025, 0.0001}) {
    if (!quick) swing_row(rows, 20, step_s, "Euler");
  }
  for (const double step_s : {0.001, 0.0005, 0.00025}) {
    if (!quick) swing_row(rows, 20, step_s, "implicit");
  }
  // With its explicit damping Runge-Kutta takes a coarse chain and short steps.
  for (const double step_s : {0.0001, 0.00005}) {
    if (!quick) swing_row(rows, 5, step_s, "RK4");
  }
}

double refuses(const BendingPlant& plant) {
  try {
    sag(plant);
  } catch (const std::invalid_argument&) {
    return 1;
  }
  return 0;
}

void refusal_rows(std::vector<StabilityRow>& rows) {
  BendingPlant thin = one_stem(1e9, 20, 0.004);
  thin.stems[0].radii_m = {1e-5, 1e-5};
  rows.push_back(make_row("stem of 0.01 mm radius", "is refused", "", 1, refuses(thin), false));
  BendingPlant heavy = one_stem(5e8, 20, 0.004);
  heavy.stems[0].strength_pa = 5e6;
  heavy.loads = {{.stem = 0, .share = 1, .mass_kg = 0.2, .centroid_m = {kLength_m, 0, 0}}};
  rows.push_back(make_row("fruit of 200 g on a stalk of 5 MPa", "status is broke", "", 1,
                          sag(heavy).status == PlantStatus::broke ? 1 : 0, false));
  BendingPlant upright = one_stem(1e9, 20, 0.004);
  upright.stems[0].points_m = {{0, 0, 0}, {0, 0, kLength_m}};
  const BentPlant rest = sag(upright).bent;
  double refused = 0;
  try {
    sway(upright, rest, {}, {.wind = {.mean_speed_m_s = 40}}, Rng(1));
  } catch (const std::invalid_argument&) {
    refused = 1;
  }
  rows.push_back(make_row("wind of 40 m/s", "is refused", "", 1, refused, false));
  const SwayResult storm =
      sway(upright, rest, {}, {.duration_s = 1, .wind = {.mean_speed_m_s = 30}}, Rng(1));
  rows.push_back(make_row("wind of 30 m/s on an upright stem, 1 s", "engine's warnings", "", 0,
                          storm.warnings));
}

}  // namespace

std::vector<StabilityRow> stem_cases(bool quick) {
  const EngineWatch watch;  // engine errors become exceptions
  std::vector<StabilityRow> rows;
  longest_step_rows(rows, quick);
  theory_rows(rows);
  swing_rows(rows, quick);
  refusal_rows(rows);
  return rows;
}

}  // namespace cousin
