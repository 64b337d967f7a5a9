#pragma once

#include <mujoco/mujoco.h>

#include <initializer_list>
#include <memory>
#include <string>

// MuJoCo's C interface with owners and exceptions. Only .cpp files and tests of built-in physics
// include this.

namespace cousin {

struct EngineModelDelete {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct EngineDataDelete {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using EngineModel = std::unique_ptr<mjModel, EngineModelDelete>;
using EngineData = std::unique_ptr<mjData, EngineDataDelete>;

/// Counts the engine's warnings on this thread from construction on, and turns its errors into
/// std::runtime_error (by itself it would end the program). One alive per thread.
class EngineWatch {
 public:
  EngineWatch();
  /// Messages since construction, or the counts that `data` holds if they are more.
  int warnings(const mjData& data) const;
  /// Text of the first of them; empty if there was none.
  const std::string& first_warning() const;
};

/// Numbers for the engine's XML, a space after each, that read back equal.
std::string xml_numbers(std::initializer_list<double> values);

/// @throws std::runtime_error with the engine's message.
EngineModel load_model(const std::string& xml);
EngineData make_data(const mjModel& model);

/// Makes plane-mesh contacts at up to five corners of the hull below the plane: the deepest and the
/// outermost in four directions. The engine itself takes the deepest corner and its neighbours
/// only, so a finely cornered body rocks on one point for ever. Changes the engine's table for the
/// whole process; idempotent.
void install_plane_mesh_contacts();

}  // namespace cousin
