#include "sim/physics/plant_model.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/physics/plant_reach.h"

namespace cousin {
namespace {

// Which kinds touch which: contype and conaffinity of the engine. Stems do not touch stems.
constexpr const char* kStemContact = "contype=\"1\" conaffinity=\"4\"";
constexpr const char* kLoadContact = "contype=\"2\" conaffinity=\"7\"";
constexpr const char* kObstacleContact = "contype=\"4\" conaffinity=\"0\"";
constexpr const char* kNoContact = "contype=\"0\" conaffinity=\"0\"";
// A load lies against the stem's end that carries it: that much of it, in radii, is not tested.
constexpr double kOwnStem = 10;

std::string xyz(const Eigen::Vector3d& v) { return xml_numbers({v.x(), v.y(), v.z()}); }

double share_of_node(const BendingStem& stem, double node) { return node / stem.segments; }

/// A vector across `along`, the same for the same direction.
Eigen::Vector3d across_of(const Eigen::Vector3d& along) {
  int least = 0;
  along.cwiseAbs().minCoeff(&least);
  return along.cross(Eigen::Vector3d::Unit(least)).normalized();
}

class Writer {
 public:
  Writer(const BendingPlant& plant, const PlantEngine& engine) : plant_(plant), engine_(engine) {
    contacts_ = engine.contacts && (!plant.obstacles.empty() || has_shapes());
    reaches_ = reaches_of(plant);
    for (const BendingStem& stem : plant.stems) {
      first_hinge_.push_back(hinges_.size());
      for (int node = 1; node <= stem.segments; ++node) hinges_.push_back(hinge(stem, node));
    }
  }

  std::string xml() {
    std::string body;
    for (std::size_t i = 0; i < plant_.obstacles.size(); ++i) body += obstacle(i);
    for (std::size_t s = 0; s < plant_.stems.size(); ++s) {
      if (plant_.stems[s].parent < 0) body += section(s, 0, Eigen::Vector3d::Zero());
    }
    return head() + assets() + "<worldbody>" + body + "</worldbody>" + exclusions_xml() +
           "</mujoco>";
  }

  std::vector<PlantHinge> hinges_;
  std::vector<std::size_t> first_hinge_;

 private:
  bool has_shapes() const {
    for (const BendingLoad& load : plant_.loads) {
      if (!load.hulls.empty()) return true;
    }
    return false;
  }

  PlantHinge hinge(const BendingStem& stem, int node) const {
    const double share = share_of_node(stem, node - 0.5);
    PlantHinge h;
    h.stem = first_hinge_.size() - 1;
    h.node = node;
    h.radius_m = radius_at_m(stem, share);
    h.stiffness_n_m = stem.young_modulus_pa * std::numbers::pi / 4 * std::pow(h.radius_m, 4) /
                      (length_m(stem) / stem.segments);
    h.at_m = point_at_m(stem, share);
    h.along = (point_at_m(stem, share_of_node(stem, node)) -
               point_at_m(stem, share_of_node(stem, node - 1)))
                  .normalized();
    return h;
  }

  std::string head() const {
    const double h = engine_.step_s;
    const std::size_t touching = contacts_ ? 40 * (plant_.loads.size() + 1) + hinges_.size() : 100;
    return "<mujoco><compiler angle=\"radian\" balanceinertia=\"false\"/><option timestep=\"" +
           xml_numbers({h}) + "\" gravity=\"0 0 " + xml_numbers({-engine_.gravity_m_s2}) +
           "\" integrator=\"" + engine_.integrator +
           "\" cone=\"elliptic\" solver=\"PGS\" iterations=\"50\" tolerance=\"1e-10\" "
           "impratio=\"10\" noslip_iterations=\"3\" "
           "mpr_tolerance=\"1e-9\" mpr_iterations=\"200\"/><size nconmax=\"" +
           std::to_string(touching) + "\" njmax=\"" + std::to_string(3 * touching) +
           "\"/><default><geom condim=\"3\" solref=\"" + xml_numbers({2 * h, 1}) +
           "\" solimp=\".99 .999 .0001\" friction=\"" + xml_numbers({engine_.friction, 0, 0}) +
           "\"/></default>";
  }

  std::string assets() const {
    std::string xml = "<asset>";
    for (std::size_t i = 0; contacts_ && i < plant_.loads.size(); ++i) {
      for (std::size_t k = 0; k < plant_.loads[i].hulls.size(); ++k) {
        xml += "<mesh name=\"" + hull_name(i, k) + "\" vertex=\"";
        for (const Eigen::Vector3d& v : plant_.loads[i].hulls[k].vertices_m) xml += xyz(v);
        xml += "\"/>";
      }
    }
    return xml + "</asset>";
  }

  static std::string hull_name(std::size_t load, std::size_t hull) {
    return "hull" + std::to_string(load) + "_" + std::to_string(hull);
  }

  /// Three boxes, each as far as the sides that it reaches, and a rod along each edge: bodies that
  /// slide over a sharp edge of the engine's boxes never come to rest. Sides and edges that nothing
  /// can come to are left out: the engine would hold every stem against each of them.
  std::string obstacle(std::size_t i) const {
    if (!contacts_) return "";
    const BendingObstacle& box = plant_.obstacles[i];
    const auto geom = [&](const std::string& type, const Eigen::Vector3d& size,
                          const Eigen::Vector3d& at, const Eigen::Quaterniond& turn) {
      const Pose pose = box.world_from_box * Pose{turn, at};
      const Eigen::Quaterniond& q = pose.rotation;
      return "<geom type=\"" + type + "\" size=\"" + xyz(size) + "\" pos=\"" +
             xyz(pose.translation_m) + "\" quat=\"" + xml_numbers({q.w(), q.x(), q.y(), q.z()}) +
             "\" " + kObstacleContact + "/>";
    };
    const Eigen::Vector3d inner = (box.half_m.array() - box.round_m).cwiseMax(1e-9);
    std::string xml;
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::Vector3d half = inner;
      half[axis] = box.half_m[axis];
      Eigen::Vector3d side_low = -inner, side_high = inner;
      side_low[axis] = half[axis];
      side_high[axis] = half[axis];
      if (is_reached(reaches_, box, side_low, side_high) ||
          is_reached(reaches_, box, -side_high, -side_low))
        xml += geom("box", half, Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity());
      const auto turn =
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Unit(axis));
      for (const int edge : {0, 1, 2, 3}) {
        Eigen::Vector3d at = Eigen::Vector3d::Zero();
        at[(axis + 1) % 3] = (edge & 1) != 0 ? inner[(axis + 1) % 3] : -inner[(axis + 1) % 3];
        at[(axis + 2) % 3] = (edge & 2) != 0 ? inner[(axis + 2) % 3] : -inner[(axis + 2) % 3];
        Eigen::Vector3d end = Eigen::Vector3d::Zero();
        end[axis] = inner[axis];
        const Eigen::Vector3d round = Eigen::Vector3d::Constant(box.round_m);
        if (is_reached(reaches_, box, at - end - round, at + end + round))
          xml += geom("capsule", {box.round_m, inner[axis], 0}, at, turn);
      }
    }
    return xml;
  }

  /// A straight piece of a stem between shares, in a body at `origin`.
  std::string piece(std::size_t s, double from, double to, const Eigen::Vector3d& origin) const {
    const BendingStem& stem = plant_.stems[s];
    const Eigen::Vector3d a = point_at_m(stem, from);
    const Eigen::Vector3d b = point_at_m(stem, to);
    const double radius = radius_at_m(stem, 0.5 * (from + to));
    const double mass = stem.density_kg_m3 * std::numbers::pi * radius * radius * (b - a).norm();
    const std::string line = "fromto=\"" + xyz(a - origin) + xyz(b - origin) + "\" size=\"" +
                             xml_numbers({radius}) + "\" ";
    std::string xml = "<geom type=\"cylinder\" " + line + "mass=\"" + xml_numbers({mass}) + "\" " +
                      kNoContact + "/>";
    if (contacts_) xml += "<geom type=\"capsule\" " + line + "mass=\"0\" " + kStemContact + "/>";
    return xml;
  }

  static std::string body_name(std::size_t stem, int node) {
    return "s" + std::to_string(stem) + "_" + std::to_string(node);
  }

  std::string hinge_xml(const PlantHinge& h) const {
    const BendingStem& stem = plant_.stems[h.stem];
    const Eigen::Vector3d first = across_of(h.along);
    const double tau = std::max(stem.damping_time_s, engine_.least_damping_s);
    const auto joint = [&](const Eigen::Vector3d& axis, double k) {
      return "<joint type=\"hinge\" axis=\"" + xyz(axis) + "\" stiffness=\"" + xml_numbers({k}) +
             "\" damping=\"" + xml_numbers({tau * k}) + "\" armature=\"" +
             xml_numbers({engine_.inertia_time_s * engine_.inertia_time_s * k}) + "\"/>";
    };
    std::string xml = joint(first, h.stiffness_n_m) + joint(h.along.cross(first), h.stiffness_n_m);
    // G J / segment with J = 2 I.
    if (engine_.twists) xml += joint(h.along, h.stiffness_n_m / (1 + stem.poisson_ratio));
    return xml;
  }

  std::string load(std::size_t i, const Eigen::Vector3d& origin) const {
    const BendingLoad& given = plant_.loads[i];
    const Eigen::Quaterniond& q = given.world_from_hulls;
    std::string xml = "<body name=\"load" + std::to_string(i) + "\" pos=\"" +
                      xyz(given.centroid_m - origin) + "\" quat=\"" +
                      xml_numbers({q.w(), q.x(), q.y(), q.z()}) + "\">";
    // As a ball of water: the inertia of a fruit about its own middle is a small part of its whole.
    const double radius = std::cbrt(given.mass_kg / 1000 * 3 / (4 * std::numbers::pi));
    xml += "<geom type=\"sphere\" size=\"" + xml_numbers({radius}) + "\" mass=\"" +
           xml_numbers({given.mass_kg}) + "\" " + kNoContact + "/>";
    for (std::size_t k = 0; contacts_ && k < given.hulls.size(); ++k) {
      xml +=
          "<geom type=\"mesh\" mesh=\"" + hull_name(i, k) + "\" mass=\"0\" " + kLoadContact + "/>";
    }
    return xml + "</body>";
  }

  /// The contents of a section in a body at `origin`, and in it the next section as a body.
  std::string section(std::size_t s, int node, const Eigen::Vector3d& origin) {
    const BendingStem& stem = plant_.stems[s];
    const auto share = [&](double n) { return share_of_node(stem, n); };
    std::string xml;
    if (node > 0) xml += piece(s, share(node - 0.5), share(node), origin);
    if (node < stem.segments) xml += piece(s, share(node), share(node + 0.5), origin);
    const auto here = [&](double at) { return static_cast<int>(at * stem.segments + 0.5) == node; };
    for (std::size_t i = 0; i < plant_.loads.size(); ++i) {
      const BendingLoad& carried = plant_.loads[i];
      if (carried.stem != static_cast<int>(s) || !here(carried.share)) continue;
      xml += load(i, origin);
      exclude_own_stem(i, node);
    }
    for (std::size_t c = s + 1; c < plant_.stems.size(); ++c) {
      if (plant_.stems[c].parent == static_cast<int>(s) && here(plant_.stems[c].parent_share))
        xml += section(c, 0, origin);
    }
    if (node == stem.segments) return xml;
    const PlantHinge& next = hinges_[first_hinge_[s] + static_cast<std::size_t>(node)];
    xml += "<body name=\"" + body_name(s, node + 1) + "\" pos=\"" + xyz(next.at_m - origin) +
           "\">" + hinge_xml(next) + section(s, node + 1, next.at_m) + "</body>";
    return xml;
  }

  void exclude_own_stem(std::size_t load_index, int node) {
    const BendingLoad& carried = plant_.loads[load_index];
    const auto s = static_cast<std::size_t>(carried.stem);
    const BendingStem& stem = plant_.stems[s];
    const double segment_m = length_m(stem) / stem.segments;
    const int near = 2 + static_cast<int>(kOwnStem * radius_at_m(stem, carried.share) / segment_m);
    for (int n = std::max(1, node - near); n <= std::min(stem.segments, node + near); ++n) {
      exclusions_ += "<exclude body1=\"load" + std::to_string(load_index) + "\" body2=\"" +
                     body_name(s, n) + "\"/>";
    }
  }

  std::string exclusions_xml() const {
    return exclusions_.empty() || !contacts_ ? "" : "<contact>" + exclusions_ + "</contact>";
  }

  const BendingPlant& plant_;
  const PlantEngine& engine_;
  std::vector<Reach> reaches_;
  bool contacts_ = false;
  std::string exclusions_;
};

Pose body_pose(const mjData& data, int body) {
  const mjtNum* p = data.xpos + 3 * body;
  const mjtNum* q = data.xquat + 4 * body;
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(),
          Eigen::Vector3d(p[0], p[1], p[2])};
}

}  // namespace

HingedPlant make_plant_model(const BendingPlant& plant, const PlantEngine& engine) {
  validate(plant);
  Writer writer(plant, engine);
  HingedPlant result;
  result.model = load_model(writer.xml());
  result.hinges = std::move(writer.hinges_);
  result.first_hinge = std::move(writer.first_hinge_);
  result.axes = engine.twists ? 3 : 2;
  mjModel& model = *result.model;
  for (PlantHinge& hinge : result.hinges) {
    const std::string name = "s" + std::to_string(hinge.stem) + "_" + std::to_string(hinge.node);
    hinge.body = mj_name2id(&model, mjOBJ_BODY, name.c_str());
    hinge.first_angle = model.jnt_qposadr[model.body_jntadr[hinge.body]];
  }
  for (std::size_t i = 0; i < plant.loads.size(); ++i) {
    result.load_body.push_back(
        mj_name2id(&model, mjOBJ_BODY, ("load" + std::to_string(i)).c_str()));
  }
  return result;
}

BentPlant bent_plant(const BendingPlant& plant, const HingedPlant& plant_model,
                     const mjData& data) {
  BentPlant bent;
  bent.time_s = data.time;
  for (std::size_t s = 0; s < plant.stems.size(); ++s) {
    const BendingStem& stem = plant.stems[s];
    std::vector<Pose> sections;
    std::vector<double> angles_rad;
    // The first half segment is a part of what carries the stem.
    sections.push_back(
        stem.parent < 0 ? Pose{} : bent_from_unbent(plant, bent, stem.parent, stem.parent_share));
    for (int node = 1; node <= stem.segments; ++node) {
      const PlantHinge& hinge =
          plant_model.hinges[plant_model.first_hinge[s] + static_cast<std::size_t>(node - 1)];
      sections.push_back(body_pose(data, hinge.body) *
                         Pose{Eigen::Quaterniond::Identity(), -hinge.at_m});
      for (int k = 0; k < 3; ++k)
        angles_rad.push_back(k < plant_model.axes ? data.qpos[hinge.first_angle + k] : 0);
    }
    bent.sections.push_back(std::move(sections));
    bent.joints_rad.push_back(std::move(angles_rad));
  }
  return bent;
}

void set_bent(const HingedPlant& plant_model, const BentPlant& bent, mjData& data) {
  if (bent.joints_rad.size() != plant_model.first_hinge.size())
    throw std::invalid_argument("bending plant: the bent shape is of another plant");
  for (std::size_t s = 0; s < bent.joints_rad.size(); ++s) {
    const std::size_t first = plant_model.first_hinge[s];
    const std::size_t end = s + 1 < plant_model.first_hinge.size() ? plant_model.first_hinge[s + 1]
                                                                   : plant_model.hinges.size();
    if (bent.joints_rad[s].size() != 3 * (end - first))
      throw std::invalid_argument("bending plant: the bent shape is of another plant");
    for (std::size_t h = first; h < end; ++h) {
      for (int k = 0; k < plant_model.axes; ++k) {
        data.qpos[plant_model.hinges[h].first_angle + k] =
            bent.joints_rad[s][3 * (h - first) + static_cast<std::size_t>(k)];
      }
    }
  }
}

PlantStress largest_stress(const BendingPlant& plant, const HingedPlant& plant_model,
                           const mjData& data) {
  PlantStress largest;
  const mjModel& model = *plant_model.model;
  for (const PlantHinge& hinge : plant_model.hinges) {
    const BendingStem& stem = plant.stems[hinge.stem];
    const double angle_rad =
        std::hypot(data.qpos[hinge.first_angle], data.qpos[hinge.first_angle + 1]);
    const double segment_m = length_m(stem) / stem.segments;
    const Eigen::Vector3d along = body_pose(data, hinge.body).rotation * hinge.along;
    const double hung_n =
        model.body_subtreemass[hinge.body] * -model.opt.gravity[2] * std::abs(along.z());
    const double stress_pa = stem.young_modulus_pa * hinge.radius_m * angle_rad / segment_m +
                             hung_n / (std::numbers::pi * hinge.radius_m * hinge.radius_m);
    if (largest.stem >= 0 && !(stress_pa / stem.strength_pa > largest.ratio)) continue;
    largest = {stress_pa / stem.strength_pa, stress_pa, static_cast<int>(hinge.stem),
               (hinge.node - 0.5) / stem.segments};
  }
  return largest;
}

PlantEnergy energy_of(const HingedPlant& plant_model, const mjData& data) {
  PlantEnergy energy;
  const mjModel& model = *plant_model.model;
  for (int j = 0; j < model.njnt; ++j)
    energy.elastic_j += 0.5 * model.jnt_stiffness[j] * std::pow(data.qpos[model.jnt_qposadr[j]], 2);
  std::vector<mjtNum> momentum(static_cast<std::size_t>(model.nv));
  mj_mulM(&model, &data, momentum.data(), data.qvel);
  for (std::size_t i = 0; i < momentum.size(); ++i)
    energy.kinetic_j += 0.5 * momentum[i] * data.qvel[i];
  return energy;
}

}  // namespace cousin
