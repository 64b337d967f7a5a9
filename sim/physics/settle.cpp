#include "sim/physics/settle.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/geometry/measure.h"
#include "sim/physics/convex_parts.h"
#include "sim/physics/engine.h"
#include "sim/physics/penetration.h"

namespace cousin {
namespace {

constexpr double kHold_s = 0.05;  // rest must last as long

struct Body {
  const SettleBody* given = nullptr;
  ConvexParts parts;
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Identity();
  double radius_m = 0;  ///< of the sphere around the centroid that holds the mesh
};

Body prepare(const SettleBody& given, std::size_t index) {
  const std::string name = "settle: body " + std::to_string(index);
  if (given.mesh == nullptr) throw std::invalid_argument(name + " has no mesh");
  if (!(given.mass_kg > 0)) {
    throw std::invalid_argument(name + " has mass " + std::to_string(given.mass_kg) +
                                " kg; it must be positive");
  }
  Body body;
  body.given = &given;
  body.parts = given.parts != nullptr ? *given.parts : convex_parts(*given.mesh);
  const MassProperties mass = mass_properties(*given.mesh);
  for (const Eigen::Vector3d& v : given.mesh->vertices_m)
    body.radius_m = std::max(body.radius_m, v.norm());
  if (mass.centroid_m.norm() > 1e-3 * body.radius_m) {
    throw std::invalid_argument(name + " does not have its centroid at the origin");
  }
  body.inertia_kg_m2 = given.mass_kg / mass.volume_m3 * mass.inertia_m5;
  return body;
}

double lowest_m(const Mesh& mesh, const Pose& world_from_body) {
  const Eigen::Vector3d up_in_body =
      world_from_body.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  double low = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& v : mesh.vertices_m) low = std::min(low, v.dot(up_in_body));
  return low + world_from_body.translation_m.z();
}

/// Heights of release: drop_height above the board, or above earlier bodies that may lie below.
std::vector<Pose> release_poses(const std::vector<Body>& bodies, double drop_height_m) {
  std::vector<Pose> poses;
  for (const Body& body : bodies) {
    Pose pose = body.given->world_from_body;
    double ground_m = 0;
    for (std::size_t j = 0; j < poses.size(); ++j) {
      const Eigen::Vector3d offset = poses[j].translation_m - pose.translation_m;
      if (offset.head<2>().norm() < body.radius_m + bodies[j].radius_m) {
        ground_m = std::max(ground_m, poses[j].translation_m.z() + bodies[j].radius_m);
      }
    }
    pose.translation_m.z() += ground_m + drop_height_m - lowest_m(*body.given->mesh, pose);
    poses.push_back(pose);
  }
  return poses;
}

std::string model_xml(const std::vector<Body>& bodies, const std::vector<Pose>& poses,
                      const SettleConfig& config) {
  const double h = config.step_s;
  // Too little room is a warning, which is fatal.
  const std::size_t contacts =
      static_cast<std::size_t>(config.contacts_per_body) * bodies.size() + 20;
  std::string xml =
      "<mujoco><compiler angle=\"radian\" balanceinertia=\"false\"/><option timestep=\"" +
      xml_numbers({h}) +
      "\" gravity=\"0 0 -9.81\" integrator=\"Euler\" cone=\"elliptic\" solver=\"Newton\" "
      "iterations=\"60\""
      " tolerance=\"1e-12\" impratio=\"10\" noslip_tolerance=\"1e-12\" noslip_iterations=\"" +
      std::to_string(config.noslip_iterations) +
      "\" mpr_tolerance=\"1e-9\" mpr_iterations=\"200\"><flag multiccd=\"enable\"/></option>"
      "<size nconmax=\"" +
      std::to_string(contacts) + "\" njmax=\"" + std::to_string(6 * contacts) +
      "\"/><default><geom condim=\"6\" solref=\"" + xml_numbers({2 * h, 1}) +
      "\" solimp=\".99 .999 .0001\" friction=\"" +
      xml_numbers({config.friction, config.spinning_friction_m, config.rolling_friction_m}) +
      "\"/></default><asset>";
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t k = 0; k < bodies[i].parts.hulls.size(); ++k) {
      xml += "<mesh name=\"m" + std::to_string(i) + "_" + std::to_string(k) + "\" vertex=\"";
      for (const Eigen::Vector3d& v : bodies[i].parts.hulls[k].vertices_m)
        xml += xml_numbers({v.x(), v.y(), v.z()});
      xml += "\"/>";
    }
  }
  xml += "</asset><worldbody><geom type=\"plane\" size=\"1 1 1\"/>";
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Vector3d& t = poses[i].translation_m;
    const Eigen::Quaterniond& q = poses[i].rotation;
    const Eigen::Matrix3d& inertia = bodies[i].inertia_kg_m2;
    xml += "<body pos=\"" + xml_numbers({t.x(), t.y(), t.z()}) + "\" quat=\"" +
           xml_numbers({q.w(), q.x(), q.y(), q.z()}) +
           "\"><freejoint/><inertial pos=\"0 0 0\" mass=\"" +
           xml_numbers({bodies[i].given->mass_kg}) + "\" fullinertia=\"" +
           xml_numbers({inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(0, 2),
                        inertia(1, 2)}) +
           "\"/>";
    for (std::size_t k = 0; k < bodies[i].parts.hulls.size(); ++k) {
      xml += "<geom type=\"mesh\" mesh=\"m" + std::to_string(i) + "_" + std::to_string(k) + "\"/>";
    }
    xml += "</body>";
  }
  return xml + "</worldbody></mujoco>";
}

/// Position and velocity of the free joint of body i: the bodies' frames have their centroid as
/// origin.
Pose body_pose(const mjData& data, std::size_t i) {
  const mjtNum* q = data.qpos + 7 * i;
  return {Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized(),
          Eigen::Vector3d(q[0], q[1], q[2])};
}

double kinetic_energy_j(const std::vector<Body>& bodies, const mjData& data) {
  double energy = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const mjtNum* v = data.qvel + 6 * i;
    const Eigen::Vector3d linear(v[0], v[1], v[2]);
    const Eigen::Vector3d angular(v[3], v[4], v[5]);  // in the body's frame
    energy += 0.5 * bodies[i].given->mass_kg * linear.squaredNorm() +
              0.5 * angular.dot(bodies[i].inertia_kg_m2 * angular);
  }
  return energy;
}

/// Linear drag on both velocities, each with the same decay rate.
void set_drag(const std::vector<Body>& bodies, mjModel& model, double drag_per_s) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(
                                        bodies[i].inertia_kg_m2, Eigen::EigenvaluesOnly)
                                        .eigenvalues();
    for (std::size_t k = 0; k < 3; ++k) {
      model.dof_damping[6 * i + k] = drag_per_s * bodies[i].given->mass_kg;
      model.dof_damping[6 * i + 3 + k] = drag_per_s * moments.mean();
    }
  }
}

/// How deep the deepest vertex of `a` is inside the convex `hull` of another body; 0 if none is.
double depth_in_hull_m(const Mesh& a, const Pose& hull_from_a, double a_radius_m,
                       const Mesh& hull) {
  const ConvexBody body(hull);
  if (body.depth_m(hull_from_a.translation_m, -a_radius_m) < -a_radius_m) return 0;
  double deepest = 0;
  for (const Eigen::Vector3d& vertex : a.vertices_m)
    deepest = std::max(deepest, body.depth_m(hull_from_a * vertex, deepest));
  return deepest;
}

double max_penetration_m(const std::vector<Body>& bodies, const std::vector<Pose>& poses) {
  double deepest = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    deepest = std::max(deepest, -lowest_m(*bodies[i].given->mesh, poses[i]));
    for (std::size_t j = 0; j < bodies.size(); ++j) {
      const double apart_m = (poses[i].translation_m - poses[j].translation_m).norm();
      if (i == j || apart_m > bodies[i].radius_m + bodies[j].radius_m) continue;
      for (const Mesh& hull : bodies[j].parts.hulls) {
        deepest =
            std::max(deepest, depth_in_hull_m(*bodies[i].given->mesh, inverse(poses[j]) * poses[i],
                                              bodies[i].radius_m, hull));
      }
    }
  }
  return deepest;
}

bool all_on_board(const std::vector<Pose>& poses, double half_m) {
  return std::all_of(poses.begin(), poses.end(), [&](const Pose& pose) {
    return pose.translation_m.head<2>().cwiseAbs().maxCoeff() <= half_m &&
           pose.translation_m.z() > 0;
  });
}

}  // namespace

SettleResult settle(const std::vector<SettleBody>& given, const SettleConfig& config) {
  validate(config);
  SettleResult result;
  std::vector<Body> bodies(given.size());
  tbb::parallel_for(std::size_t{0}, given.size(),
                    [&](std::size_t i) { bodies[i] = prepare(given[i], i); });
  if (bodies.empty()) {
    result.status = SettleStatus::ok;
    return result;
  }

  const EngineWatch watch;
  install_plane_mesh_contacts();
  const EngineModel model =
      load_model(model_xml(bodies, release_poses(bodies, config.drop_height_m), config));
  set_drag(bodies, *model, config.drag_per_s);
  const EngineData data = make_data(*model);
  const auto steps = static_cast<long>(config.max_time_s / config.step_s);
  const auto hold = static_cast<long>(std::ceil(kHold_s / config.step_s));
  long quiet = 0;
  for (long step = 0; step < steps && quiet < hold; ++step) {
    mj_step(model.get(), data.get());
    result.kinetic_energy_j = kinetic_energy_j(bodies, *data);
    // A body just released is slow too: rest needs contact.
    const bool touching = data->ncon >= static_cast<int>(bodies.size());
    quiet = result.kinetic_energy_j < config.rest_energy_j && touching ? quiet + 1 : 0;
  }

  for (std::size_t i = 0; i < bodies.size(); ++i)
    result.world_from_body.push_back(body_pose(*data, i));
  result.time_s = data->time;
  result.warnings = watch.warnings(*data);
  result.first_warning = watch.first_warning();
  result.max_penetration_m = max_penetration_m(bodies, result.world_from_body);
  if (result.warnings > 0) {
    result.status = SettleStatus::engine_warning;
  } else if (!all_on_board(result.world_from_body, config.board_half_m)) {
    result.status = SettleStatus::left_board;
  } else if (quiet < hold) {
    result.status = SettleStatus::not_at_rest;
  } else if (result.max_penetration_m > config.max_penetration_m) {
    result.status = SettleStatus::penetrates;
  } else {
    result.status = SettleStatus::ok;
  }
  return result;
}

}  // namespace cousin
