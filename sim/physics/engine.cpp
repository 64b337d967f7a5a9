#include "sim/physics/engine.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace cousin {
namespace {

thread_local int warning_count = 0;
thread_local std::string first_message;

void count_warning(const char* message) {
  if (warning_count++ == 0) first_message = message;
}
void throw_error(const char* message) {
  throw std::runtime_error(std::string("MuJoCo: ") + message);
}

using Matrix = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;

struct Corner {
  Eigen::Vector3d in_world_m;
  double height_m = 0;  ///< over the plane; negative below
};

/// mjfCollision of a plane (geom 1) and a mesh (geom 2).
int plane_mesh(const mjModel* model, const mjData* data, mjContact* contacts, int plane, int mesh,
               mjtNum margin) {
  const Eigen::Map<const Matrix> plane_axes(data->geom_xmat + 9 * plane);
  const Eigen::Map<const Eigen::Vector3d> plane_at(data->geom_xpos + 3 * plane);
  const Eigen::Map<const Matrix> mesh_axes(data->geom_xmat + 9 * mesh);
  const Eigen::Map<const Eigen::Vector3d> mesh_at(data->geom_xpos + 3 * mesh);
  const Eigen::Vector3d normal = plane_axes.col(2);
  const double centre_height_m = normal.dot(mesh_at - plane_at);
  if (centre_height_m > model->geom_rbound[mesh] + margin) return 0;

  thread_local std::vector<Corner> below;
  below.clear();
  const int shape = model->geom_dataid[mesh];
  const float* vertex =
      model->mesh_vert + 3 * static_cast<std::ptrdiff_t>(model->mesh_vertadr[shape]);
  const Eigen::Vector3d normal_in_mesh = mesh_axes.transpose() * normal;
  for (int i = 0; i < model->mesh_vertnum[shape]; ++i, vertex += 3) {
    const Eigen::Vector3d p(vertex[0], vertex[1], vertex[2]);
    const double height_m = centre_height_m + normal_in_mesh.dot(p);
    if (height_m < margin) below.push_back({mesh_at + mesh_axes * p, height_m});
  }
  if (below.empty()) return 0;

  constexpr int kDirections = 4;
  std::array<std::size_t, kDirections + 1> chosen{};
  const auto deeper = [](const Corner& a, const Corner& b) { return a.height_m < b.height_m; };
  chosen[0] = static_cast<std::size_t>(std::min_element(below.begin(), below.end(), deeper) -
                                       below.begin());
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * (k + 0.5) / kDirections;
    const Eigen::Vector3d side =
        std::cos(angle) * plane_axes.col(0) + std::sin(angle) * plane_axes.col(1);
    const auto outer = [&](const Corner& a, const Corner& b) {
      return side.dot(a.in_world_m) < side.dot(b.in_world_m);
    };
    chosen[static_cast<std::size_t>(k) + 1] = static_cast<std::size_t>(
        std::max_element(below.begin(), below.end(), outer) - below.begin());
  }
  int count = 0;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (std::find(chosen.begin(), chosen.begin() + static_cast<std::ptrdiff_t>(k), chosen[k]) !=
        chosen.begin() + static_cast<std::ptrdiff_t>(k)) {
      continue;
    }
    const Corner& corner = below[chosen[k]];
    mjContact& contact = contacts[count++];
    contact.dist = corner.height_m;
    const Eigen::Vector3d at = corner.in_world_m - 0.5 * corner.height_m * normal;  // midway
    Eigen::Map<Eigen::Vector3d>(contact.pos) = at;
    Eigen::Map<Eigen::Vector3d>(contact.frame) = normal;
    mju_zero(contact.frame + 3, 6);  // the engine completes the frame
  }
  return count;
}

}  // namespace

EngineWatch::EngineWatch() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_warning = count_warning;
    mju_user_error = throw_error;
  });
  warning_count = 0;
  first_message.clear();
}

int EngineWatch::warnings(const mjData& data) const {
  int counted = 0;
  for (const mjWarningStat& warning : data.warning) counted += warning.number;
  return std::max(counted, warning_count);
}

const std::string& EngineWatch::first_warning() const { return first_message; }

std::string xml_numbers(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.17g ", value);
    text += digits.data();
  }
  return text;
}

EngineModel load_model(const std::string& xml) {
  const auto files = std::make_unique<mjVFS>();  // 2 MB: not for the stack
  mj_defaultVFS(files.get());
  const char* name = "model.xml";
  if (mj_makeEmptyFileVFS(files.get(), name, static_cast<int>(xml.size())) != 0) {
    throw std::runtime_error("MuJoCo: no room for a model of " + std::to_string(xml.size()) +
                             " bytes");
  }
  const int slot = mj_findFileVFS(files.get(), name);
  std::copy(xml.begin(), xml.end(), static_cast<char*>(files->filedata[slot]));
  std::array<char, 1000> error{};
  EngineModel model(mj_loadXML(name, files.get(), error.data(), static_cast<int>(error.size())));
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(std::string("MuJoCo: ") + error.data());
  return model;
}

EngineData make_data(const mjModel& model) {
  EngineData data(mj_makeData(&model));
  if (!data) throw std::runtime_error("MuJoCo: no memory for the state");
  return data;
}

void install_plane_mesh_contacts() {
  static std::once_flag once;
  std::call_once(once, [] { mjCOLLISIONFUNC[mjGEOM_PLANE][mjGEOM_MESH] = plane_mesh; });
}

}  // namespace cousin
