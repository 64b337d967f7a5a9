#include "benchmarks/stability/contact_cases.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "sim/physics/engine.h"
#include "sim/physics/settle.h"

namespace cousin {
namespace {

constexpr double kGravity = 9.81;
constexpr double kDensity = 1250;  // kg/m3, maize

/// What the engine is told about contacts.
struct Contacts {
  double step_s = 0.002;
  double timeconst_s = 0.02;
  std::string solimp = ".9 .95 .001";
  std::string cone = "pyramidal";
  double friction = 1;
  double impratio = 1;
  int noslip = 0;
};

Contacts preset(double step_s, double friction) {
  return {step_s, 2 * step_s, ".99 .999 .0001", "elliptic", friction, 10, 3};
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
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
         " 1\" solimp=\"" + c.solimp + "\" friction=\"" + number(c.friction) + " 0 0\" density=\"" +
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

/// Depth r at which (1 - d) g = d k r, with k = d / (dmax tc)^2 and d(r) the impedance between .9
/// and .95 over 1 mm [MuJoCo documentation, Computation: Parameters].
double theory_depth_m() {
  double r = 1e-4;
  for (int i = 0; i < 100; ++i) {
    const double x = std::min(1.0, r / 0.001);
    const double y = x <= 0.5 ? 2 * x * x : 1 - 2 * (1 - x) * (1 - x);
    const double d = 0.9 + 0.05 * y;
    r = (1 - d) * kGravity * std::pow(0.95 * 0.02 / d, 2);
  }
  return r;
}

void rest_rows(std::vector<StabilityRow>& rows) {
  Contacts soft;
  soft.cone = "elliptic";
  const double seed_m = rest_depth_m(soft, 0.0015);
  rows.push_back(make_row("rest, engine defaults, elliptic cone, 3 mm sphere", "depth off theory",
                          "mm", 0.002, 1e3 * std::abs(seed_m - theory_depth_m())));
  rows.push_back(make_row("rest, engine defaults, elliptic cone, 3 mm sphere", "depth", "mm", 0.1,
                          1e3 * seed_m, false));
  const double rock_m = rest_depth_m(soft, 0.5);
  rows.push_back(make_row("rest, engine defaults, elliptic cone, 1 mm to 1 m",
                          "difference of depth", "mm", 0.002,
                          1e3 * std::abs(rock_m - rest_depth_m(soft, 0.0005))));
  for (const char* cone : {"elliptic", "pyramidal"}) {
    soft.cone = cone;
    soft.friction = 0.1;
    const double smooth_m = rest_depth_m(soft, 0.0015);
    soft.friction = 2;
    const double ratio = rest_depth_m(soft, 0.0015) / smooth_m;
    const bool elliptic = soft.cone == "elliptic";
    rows.push_back(
        make_row(std::string("rest, engine defaults, ") + cone + " cone, friction 0.1 to 2",
                 "ratio of depths", "", elliptic ? 1.01 : 100, ratio, elliptic));
  }
  rows.push_back(make_row("rest, settle preset, 3 mm sphere", "depth", "mm", 0.001,
                          1e3 * rest_depth_m(preset(0.0005, 0.5), 0.0015)));
}

/// Deepest point under the plane while a seed-sized ellipsoid falls from 50 mm on its flat side.
double impact_depth_m(const Contacts& contacts) {
  const double half_m = 0.0012;
  Simulation simulation(model_xml(
      contacts, kPlane, "<geom type=\"ellipsoid\" size=\"0.003 0.0015 0.0012\"/>", 0.05 + half_m));
  double deepest_m = 0;
  const auto steps = static_cast<long>(0.3 / contacts.step_s);
  for (long i = 0; i < steps; ++i) {
    mj_step(simulation.model.get(), simulation.data.get());
    deepest_m = std::max(deepest_m, half_m - simulation.z_m());
  }
  return deepest_m;
}

void impact_rows(std::vector<StabilityRow>& rows) {
  Contacts soft;
  soft.friction = 0.5;
  rows.push_back(make_row("50 mm drop, 6 x 3 x 2.4 mm ellipsoid, engine defaults", "deepest", "mm",
                          1, 1e3 * impact_depth_m(soft), false));
  // Contacts are seen at the ends of steps only, so a fall may go as deep as one step takes it.
  for (const double step_s : {0.0005, 0.0001}) {
    char name[80];
    std::snprintf(name, sizeof name,
                  "50 mm drop, 6 x 3 x 2.4 mm ellipsoid, settle preset, h %.1f ms", 1e3 * step_s);
    const double travel_m = std::sqrt(2 * kGravity * 0.05) * step_s;
    rows.push_back(
        make_row(name, "deepest", "mm", 1e3 * travel_m, 1e3 * impact_depth_m(preset(step_s, 0.5))));
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
  Contacts soft;
  rows.push_back(make_row("tunnelling, 3 mm sphere, 1 mm plate, engine defaults",
                          "speed that passes", "m/s", 0.5, passing_speed_m_s(soft, 0.001)));
  const std::vector<double> thicknesses_m =
      quick ? std::vector{0.001} : std::vector{0.0003, 0.001, 0.003, 0.01};
  const std::vector<double> steps_s =
      quick ? std::vector{0.0005} : std::vector{0.002, 0.0005, 0.0001};
  for (const double thickness_m : thicknesses_m) {
    for (const double step_s : steps_s) {
      const double rule = (0.0015 + thickness_m / 2) / step_s;
      char name[96];
      std::snprintf(name, sizeof name,
                    "tunnelling, 3 mm sphere, %.1f mm plate, solref 2h, h %.1f ms",
                    1e3 * thickness_m, 1e3 * step_s);
      rows.push_back(make_row(name, "speed that passes over (r + t/2) / h", "", 0.95,
                              passing_speed_m_s(preset(step_s, 0.5), thickness_m) / rule, false));
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
  const char* name = "creep, 4 mm box, slope 20 degrees, friction 1, ";
  Contacts contacts;
  contacts.step_s = 0.001;
  rows.push_back(make_row(std::string(name) + "engine defaults", "speed", "mm/s", 0.5,
                          1e3 * creep_m_s(contacts), false));
  contacts.cone = "elliptic";
  contacts.impratio = 100;
  contacts.noslip = 10;
  rows.push_back(make_row(std::string(name) + "elliptic, impratio 100, noslip 10", "speed", "mm/s",
                          1e-5, 1e3 * creep_m_s(contacts)));
  rows.push_back(make_row(std::string(name) + "settle preset", "speed", "mm/s", 1e-4,
                          1e3 * creep_m_s(preset(0.0005, 1))));
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
    const double height_m = result.world_from_body[0].translation_m.z();
    rows.push_back(make_row(name, "rest height off half a side", "mm", 0.02,
                            1e3 * std::abs(height_m - 0.0012)));
    // Above 0.5 ms contacts may ring for ever; there the row only shows what happens.
    const double required = step_s <= 0.0005 ? 1 : 0;
    rows.push_back(make_row(name, "comes to rest", "", required,
                            result.status == SettleStatus::ok ? 1 : 0, false));
    rows.push_back(make_row(name, "wall time", "s", 60, seconds));
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
