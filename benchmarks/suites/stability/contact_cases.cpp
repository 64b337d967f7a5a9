#include "benchmarks/suites/stability/contact_cases.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "sim/physics/engine.h"
#include "sim/physics/settle.h"

namespace cousin {
namespace {

constexpr double kGravity = 9.81;
constexpr double kDensity = 1250;  // kg/m3, maize

// Where limits come from. "Table": what MuJoCo 2.2.2 was measured to do at a seed's size
// (sensors.md C4, 1-3 and 7), with half of the last digit quoted as the limit. "Theory":
// the contact model in MuJoCo's documentation, Computation: Parameters.

/// What the engine is told about contacts.
struct Contacts {
  double step_s = 0.002;
  double timeconst_s = 0.02;
  double impedance_min = 0.9;
  double impedance_max = 0.95;
  double impedance_width_m = 0.001;
  std::string cone = "pyramidal";
  double friction = 1;
  double impratio = 1;
  int noslip = 0;
};

Contacts preset(double step_s, double friction) {
  return {step_s, 2 * step_s, 0.99, 0.999, 0.0001, "elliptic", friction, 10, 3};
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// One free body over `ground`; both are geom elements without contact attributes.
std::string model_xml(const Contacts& c, const std::string& ground, const std::string& body,
                      double height_m, double slope_rad = 0) {
  return "<mujoco><compiler angle=\"radian\"/><option timestep=\"" + number(c.step_s) +
         "\" gravity=\"" + number(kGravity * std::sin(slope_rad)) + " 0 " +
         number(-kGravity * std::cos(slope_rad)) + "\" cone=\"" + c.cone +
         "\" tolerance=\"1e-12\" impratio=\"" + number(c.impratio) + "\" noslip_iterations=\"" +
         std::to_string(c.noslip) + "\"/><default><geom solref=\"" + number(c.timeconst_s) +
         " 1\" solimp=\"" + number(c.impedance_min) + " " + number(c.impedance_max) + " " +
         number(c.impedance_width_m) + "\" friction=\"" + number(c.friction) + " 0 0\" density=\"" +
         number(kDensity) + "\"/></default><worldbody>" + ground + "<body pos=\"0 0 " +
         number(height_m) + "\"><freejoint/>" + body + "</body></worldbody></mujoco>";
}

const char* const kPlane = "<geom type=\"plane\" size=\"1 1 1\"/>";

std::string sphere(double radius_m) {
  return "<geom type=\"sphere\" size=\"" + number(radius_m) + "\"/>";
}

/// A body of one free joint in the engine.
struct Simulation {
  EngineModel model;
  EngineData data;
  explicit Simulation(const std::string& xml) : model(load_model(xml)), data(make_data(*model)) {}
  void run(double seconds) {
    const auto steps = static_cast<long>(std::lround(seconds / model->opt.timestep));
    for (long i = 0; i < steps; ++i) mj_step(model.get(), data.get());
  }
  double z_m() const { return data->qpos[2]; }
};

double rest_depth_m(const Contacts& contacts, double radius_m) {
  Simulation simulation(model_xml(contacts, kPlane, sphere(radius_m), radius_m));
  simulation.run(2);
  return radius_m - simulation.z_m();
}

/// Theory: the depth r of one contact at rest, (1 - d) g = d k r with k = d / (dmax tc)^2 and d(r)
/// the impedance, which rises from its least to its greatest value over the width.
double theory_depth_m(const Contacts& c) {
  double r = 1e-4;
  for (int i = 0; i < 100; ++i) {
    const double x = std::min(1.0, r / c.impedance_width_m);
    const double y = x <= 0.5 ? 2 * x * x : 1 - 2 * (1 - x) * (1 - x);
    const double d = c.impedance_min + (c.impedance_max - c.impedance_min) * y;
    r = (1 - d) * kGravity * std::pow(c.impedance_max * c.timeconst_s / d, 2);
  }
  return r;
}

void rest_rows(std::vector<StabilityRow>& rows) {
  constexpr double kRounding_mm = 1e-6;  // of the solver: the engine does what the theory says
  const char* name = "rest, engine defaults, elliptic cone, 3 mm sphere";
  Contacts soft;
  soft.cone = "elliptic";
  const double seed_m = rest_depth_m(soft, 0.0015);
  rows.push_back(make_row(name, "depth off theory", "mm", kRounding_mm,
                          1e3 * std::abs(seed_m - theory_depth_m(soft))));
  rows.push_back(  // table: 0.367 mm
      make_row(name, "depth off 0.367 mm", "mm", 0.0005, std::abs(1e3 * seed_m - 0.367)));
  // Theory: neither size nor mass is in the depth.
  rows.push_back(make_row("rest, engine defaults, elliptic cone, 1 mm to 1 m",
                          "difference of depth", "mm", kRounding_mm,
                          1e3 * std::abs(rest_depth_m(soft, 0.5) - rest_depth_m(soft, 0.0005))));
  // With elliptic cones friction is not in it either; with pyramidal ones, the engine's default, it
  // is. Table: 0.0022, 0.021, 0.068, 0.367 and 1.96 mm; half a digit of the first is 2.3 %.
  const std::vector<std::pair<double, double>> table_mm = {
      {0.1, 0.0022}, {0.3, 0.021}, {0.5, 0.068}, {1, 0.367}, {2, 1.96}};
  double elliptic_mm = 0;
  double pyramidal = 0;
  for (const auto& [friction, depth_mm] : table_mm) {
    soft.friction = friction;
    soft.cone = "elliptic";
    elliptic_mm = std::max(elliptic_mm, 1e3 * std::abs(rest_depth_m(soft, 0.0015) - seed_m));
    soft.cone = "pyramidal";
    pyramidal = std::max(pyramidal, std::abs(1e3 * rest_depth_m(soft, 0.0015) / depth_mm - 1));
  }
  rows.push_back(make_row("rest, engine defaults, elliptic cone, friction 0.1 to 2",
                          "difference of depth", "mm", kRounding_mm, elliptic_mm));
  rows.push_back(make_row("rest, engine defaults, pyramidal cone, friction 0.1 to 2",
                          "depth off 0.0022 to 1.96 mm, relative", "", 0.025, pyramidal));
  const Contacts stiff = preset(0.0005, 0.5);
  const double stiff_m = rest_depth_m(stiff, 0.0015);
  rows.push_back(make_row("rest, settle preset, 3 mm sphere", "depth off theory", "mm",
                          kRounding_mm, 1e3 * std::abs(stiff_m - theory_depth_m(stiff))));
  rows.push_back(  // table: below 1e-4 mm
      make_row("rest, settle preset, 3 mm sphere", "depth", "mm", 1e-4, 1e3 * stiff_m));
}

/// A fall onto the plane.
struct Impact {
  double first_m = 0;    ///< depth at the end of the step that first sees the contact
  double deepest_m = 0;  ///< of all steps
};

/// A seed-sized ellipsoid falls 50 mm on its flat side.
Impact impact(const Contacts& contacts, double height_m) {
  const double half_m = 0.0012;
  Simulation simulation(model_xml(contacts, kPlane,
                                  "<geom type=\"ellipsoid\" size=\"0.003 0.0015 0.0012\"/>",
                                  height_m + half_m));
  Impact result;
  const auto steps = static_cast<long>(0.3 / contacts.step_s);
  for (long i = 0; i < steps; ++i) {
    mj_step(simulation.model.get(), simulation.data.get());
    const double depth_m = half_m - simulation.z_m();
    if (result.first_m <= 0) result.first_m = depth_m;
    result.deepest_m = std::max(result.deepest_m, depth_m);
  }
  return result;
}

/// Falls from heights that differ by eighths of a step's travel: contacts are seen at the ends of
/// steps only.
std::vector<Impact> impacts(const Contacts& contacts, double travel_m) {
  std::vector<Impact> falls;
  for (int i = 0; i < 8; ++i) falls.push_back(impact(contacts, 0.05 + travel_m * i / 8));
  return falls;
}

void impact_rows(std::vector<StabilityRow>& rows) {
  const double speed_m_s = std::sqrt(2 * kGravity * 0.05);
  Contacts soft;
  soft.friction = 0.5;
  double mean_m = 0;
  for (const Impact& fall : impacts(soft, speed_m_s * soft.step_s)) mean_m += fall.deepest_m / 8;
  // Table: 6.5 mm in one fall; where its steps end moves the depth by 0.7 mm either way.
  rows.push_back(make_row("50 mm drop, 6 x 3 x 2.4 mm ellipsoid, engine defaults",
                          "mean depth off 6.5 mm", "mm", 0.7, std::abs(1e3 * mean_m - 6.5)));
  for (const double step_s : {0.0005, 0.0001}) {
    char name[80];
    std::snprintf(name, sizeof name,
                  "50 mm drop, 6 x 3 x 2.4 mm ellipsoid, settle preset, h %.1f ms", 1e3 * step_s);
    const Contacts stiff = preset(step_s, 0.5);
    const double travel_m = speed_m_s * step_s;
    double deepest_m = 0;
    double further_m = 0;
    for (const Impact& fall : impacts(stiff, travel_m)) {
      deepest_m = std::max(deepest_m, fall.deepest_m);
      further_m = std::max(further_m, fall.deepest_m - fall.first_m);
    }
    // Theory: a fall goes as deep as one step takes it unseen; the next step, with solref of two
    // steps, leaves at most 1 - d of its speed.
    rows.push_back(make_row(name, "deepest", "mm", 1e3 * travel_m, 1e3 * deepest_m));
    rows.push_back(make_row(name, "deeper than when first seen", "mm",
                            1e3 * (1 - stiff.impedance_min) * travel_m, 1e3 * further_m));
  }
}

bool passes_plate(const Contacts& contacts, double thickness_m, double speed_m_s, double start_m) {
  const double radius_m = 0.0015;
  const std::string plate = "<geom type=\"box\" size=\".05 .05 " + number(thickness_m / 2) +
                            "\" pos=\"0 0 " + number(-thickness_m / 2) + "\"/>";
  Simulation simulation(model_xml(contacts, plate, sphere(radius_m), radius_m + start_m));
  simulation.data->qvel[2] = -speed_m_s;
  simulation.model->opt.gravity[2] = 0;
  const auto steps = static_cast<long>((start_m + 0.02) / speed_m_s / contacts.step_s) + 200;
  for (long i = 0; i < steps; ++i) {
    mj_step(simulation.model.get(), simulation.data.get());
    if (simulation.z_m() < -thickness_m - radius_m) return true;
  }
  return false;
}

/// Lowest speed, by bisection to 2 %, at which the sphere passes from at least one of eight
/// heights: the step falls at another place in the plate.
double passing_speed_m_s(const Contacts& contacts, double thickness_m) {
  double low = 0.02;
  double high = 200;
  while (high / low > 1.02) {
    const double speed = std::sqrt(low * high);
    bool passes = false;
    for (int i = 0; i < 8 && !passes; ++i) {
      passes = passes_plate(contacts, thickness_m, speed, 0.001 + speed * contacts.step_s * i / 8);
    }
    (passes ? high : low) = speed;
  }
  return high;
}

void tunnelling_rows(std::vector<StabilityRow>& rows, bool quick) {
  // Table: speeds that pass with the engine's defaults, from one height each; the lowest of eight
  // is up to 7 % less.
  const std::vector<std::pair<double, double>> table_m_s = {
      {0.001, 0.27}, {0.0003, 0.23}, {0.003, 0.41}, {0.01, 0.82}};
  Contacts soft;
  char name[96];
  for (const auto& [thickness_m, speed_m_s] : table_m_s) {
    std::snprintf(name, sizeof name, "tunnelling, 3 mm sphere, %.1f mm plate, engine defaults",
                  1e3 * thickness_m);
    rows.push_back(make_row(name, "speed that passes off the table's, relative", "", 0.08,
                            std::abs(passing_speed_m_s(soft, thickness_m) / speed_m_s - 1)));
    if (quick) break;
  }
  // Table: the step does not matter, the contact is too soft. The search stops at 2 %, twice.
  const double long_m_s = passing_speed_m_s(soft, 0.001);
  soft.step_s = 0.0005;
  rows.push_back(make_row("tunnelling, 3 mm sphere, 1.0 mm plate, engine defaults, h 2 and 0.5 ms",
                          "difference of speed, relative", "", 0.04,
                          std::abs(passing_speed_m_s(soft, 0.001) / long_m_s - 1)));
  const std::vector<double> thicknesses_m =
      quick ? std::vector{0.001} : std::vector{0.0003, 0.001, 0.003, 0.01};
  const std::vector<double> steps_s =
      quick ? std::vector{0.0005} : std::vector{0.002, 0.0005, 0.0001};
  for (const double thickness_m : thicknesses_m) {
    for (const double step_s : steps_s) {
      // Table: nothing slower than (r + t/2) / h passes. The value is a speed that does.
      const double rule_m_s = (0.0015 + thickness_m / 2) / step_s;
      std::snprintf(name, sizeof name,
                    "tunnelling, 3 mm sphere, %.1f mm plate, solref 2h, h %.1f ms",
                    1e3 * thickness_m, 1e3 * step_s);
      rows.push_back(make_row(name, "speed that passes over (r + t/2) / h", "", 1 - 1e-9,
                              passing_speed_m_s(preset(step_s, 0.5), thickness_m) / rule_m_s,
                              false));
    }
  }
}

/// Mean speed of a 4 mm box down a slope of 20 degrees with friction 1, after it has come to rest.
double creep_m_s(const Contacts& contacts) {
  Simulation simulation(model_xml(contacts, kPlane, "<geom type=\"box\" size=\".002 .002 .002\"/>",
                                  0.002, 20 * std::numbers::pi / 180));
  simulation.run(1);
  const double start_m = simulation.data->qpos[0];
  simulation.run(2);
  return std::abs(simulation.data->qpos[0] - start_m) / 2;
}

void creep_rows(std::vector<StabilityRow>& rows) {
  struct Remedy {
    const char* name;
    const char* cone;
    double impratio;
    int noslip;
    double table_mm_s;
    double half_digit_mm_s;
  };
  for (const Remedy& remedy : {Remedy{"engine defaults", "pyramidal", 1, 0, 1.86, 0.005},
                               Remedy{"impratio 10", "pyramidal", 10, 0, 0.19, 0.005},
                               Remedy{"noslip 10", "pyramidal", 1, 10, 6.5e-4, 5e-6},
                               Remedy{"elliptic, impratio 100", "elliptic", 100, 0, 0.0087, 5e-5},
                               Remedy{"all three", "elliptic", 100, 10, 1e-7, 5e-8}}) {
    Contacts contacts;
    contacts.step_s = 0.001;
    contacts.cone = remedy.cone;
    contacts.impratio = remedy.impratio;
    contacts.noslip = remedy.noslip;
    rows.push_back(
        make_row(std::string("creep, 4 mm box, slope 20 degrees, friction 1, ") + remedy.name,
                 "speed off " + short_number(remedy.table_mm_s) + " mm/s", "mm/s",
                 remedy.half_digit_mm_s, std::abs(1e3 * creep_m_s(contacts) - remedy.table_mm_s)));
  }
  // No worse than the best of the table.
  rows.push_back(make_row("creep, 4 mm box, slope 20 degrees, friction 1, settle preset", "speed",
                          "mm/s", 1e-7, 1e3 * creep_m_s(preset(0.0005, 1))));
}

/// A box as a closed mesh about its centre.
Mesh box_mesh(const Eigen::Vector3d& size_m) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices_m.emplace_back(
        Eigen::Vector3d((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, ((i >> 2) & 1) - 0.5)
            .cwiseProduct(size_m));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// The step of the settle preset against error (a box at rest stands half its height above the
/// board) and time.
void step_rows(std::vector<StabilityRow>& rows, bool quick) {
  const Eigen::Vector3d size_m(0.006, 0.003, 0.0024);
  const Mesh mesh = box_mesh(size_m);
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 0).normalized());
  const std::vector<double> steps_s =
      quick ? std::vector{0.0005} : std::vector{0.002, 0.001, 0.0005, 0.00025, 0.0001};
  for (const double step_s : steps_s) {
    SettleConfig config;
    config.step_s = step_s;
    const auto start = std::chrono::steady_clock::now();
    const SettleResult result = settle({{&mesh, kDensity * size_m.prod(), pose}}, config);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    char name[64];
    std::snprintf(name, sizeof name, "settle, 6 x 3 x 2.4 mm box, h %.2f ms", 1e3 * step_s);
    const double off_m = std::abs(result.world_from_body[0].translation_m.z() - 0.0012);
    // Above 0.5 ms contacts may ring for ever: there the rows only show what happens.
    const bool used = step_s <= 0.0005;
    const double none = std::numeric_limits<double>::quiet_NaN();
    // Theory: the depth of one contact, which goes with the square of the step; on several it
    // stands higher.
    rows.push_back(make_row(name, "rest height off half a side", "mm",
                            used ? 1e3 * theory_depth_m(preset(step_s, 0.5)) : none, 1e3 * off_m));
    rows.push_back(make_row(name, "comes to rest", "", used ? 1 : none,
                            result.status == SettleStatus::ok ? 1 : 0, false));
    rows.push_back(make_row(name, "wall time", "s", none, seconds));
  }
}

}  // namespace

std::vector<StabilityRow> contact_cases(bool quick) {
  const EngineWatch watch;  // engine errors become exceptions
  std::vector<StabilityRow> rows;
  rest_rows(rows);
  impact_rows(rows);
  tunnelling_rows(rows, quick);
  creep_rows(rows);
  step_rows(rows, quick);
  return rows;
}

}  // namespace cousin
