#include "sim/dataset/colmap_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "sim/dataset/colmap_model.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

struct ModelRow {
  const char* name;
  int id;
  std::size_t focals;  ///< 1: f, 2: fx fy; then cx cy
  LensModel lens;
  /// Place in Camera::distortion of each of COLMAP's coefficients.
  std::vector<std::size_t> places;
};

/// COLMAP 3.8, src/base/camera_models.h. FOV (7) and THIN_PRISM_FISHEYE (10) have no lens of ours.
const std::array<ModelRow, 9>& model_rows() {
  static const std::array<ModelRow, 9> kRows = {{
      {"SIMPLE_PINHOLE", 0, 1, LensModel::pinhole, {}},
      {"PINHOLE", 1, 2, LensModel::pinhole, {}},
      {"SIMPLE_RADIAL", 2, 1, LensModel::opencv5, {0}},
      {"RADIAL", 3, 1, LensModel::opencv5, {0, 1}},
      {"OPENCV", 4, 2, LensModel::opencv5, {0, 1, 2, 3}},
      {"OPENCV_FISHEYE", 5, 2, LensModel::kannala_brandt4, {0, 1, 2, 3}},
      {"FULL_OPENCV", 6, 2, LensModel::opencv8, {0, 1, 2, 3, 4, 5, 6, 7}},
      {"SIMPLE_RADIAL_FISHEYE", 8, 1, LensModel::kannala_brandt4, {0}},
      {"RADIAL_FISHEYE", 9, 1, LensModel::kannala_brandt4, {0, 1}},
  }};
  return kRows;
}

const ModelRow& row_named(const std::string& name) {
  for (const ModelRow& row : model_rows()) {
    if (name == row.name) return row;
  }
  throw std::logic_error("no COLMAP model " + name);
}

[[noreturn]] void refuse_model(const std::string& given, const std::string& where) {
  std::string names;
  for (const ModelRow& row : model_rows())
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  throw std::runtime_error(where + "the camera model " + given + " is not one of " + names);
}

ColmapCamera empty_camera(const ModelRow& row) {
  return {row.name, row.id, std::vector<double>(row.focals + 2 + row.places.size())};
}

std::string name_of_lens(const Camera& camera, const std::string& who) {
  switch (camera.model) {
    case LensModel::pinhole:
      return "PINHOLE";
    case LensModel::opencv5:
      return camera.distortion[4] == 0 ? "OPENCV" : "FULL_OPENCV";
    case LensModel::opencv8:
      return "FULL_OPENCV";
    case LensModel::kannala_brandt4:
      return "OPENCV_FISHEYE";
    case LensModel::opencv12:
    case LensModel::splined_stereographic:
      break;
  }
  throw std::invalid_argument(who + " has the lens model " + std::string(to_string(camera.model)) +
                              ", which COLMAP does not have");
}

}  // namespace

ColmapCamera to_colmap(const Camera& camera, const std::string& who) {
  const ModelRow& row = row_named(name_of_lens(camera, who));
  ColmapCamera colmap = empty_camera(row);
  // From a pixel's centre to the image's corner.
  const std::array<double, 4> head = {camera.fx_px, camera.fy_px, camera.cx_px + 0.5,
                                      camera.cy_px + 0.5};
  std::copy(head.begin(), head.end(), colmap.parameters.begin());
  for (std::size_t i = 0; i < row.places.size(); ++i)
    colmap.parameters[4 + i] = camera.distortion[row.places[i]];
  return colmap;
}

ColmapCamera colmap_model_named(const std::string& model, const std::string& where) {
  for (const ModelRow& row : model_rows()) {
    if (model == row.name) return empty_camera(row);
  }
  refuse_model("\"" + cut_utf8(model, 60) + "\"", where);
}

ColmapCamera colmap_model_numbered(int model_id, const std::string& where) {
  for (const ModelRow& row : model_rows()) {
    if (model_id == row.id) return empty_camera(row);
  }
  refuse_model(std::to_string(model_id), where);
}

Camera from_colmap(const ColmapCamera& colmap, int width_px, int height_px,
                   const std::string& where) {
  const ModelRow& row = row_named(colmap.model);
  const std::vector<double>& p = colmap.parameters;
  Camera camera{.model = row.lens, .width_px = width_px, .height_px = height_px};
  camera.fx_px = p[0];
  camera.fy_px = p[row.focals - 1];
  camera.cx_px = p[row.focals] - 0.5;
  camera.cy_px = p[row.focals + 1] - 0.5;
  for (std::size_t i = 0; i < row.places.size(); ++i)
    camera.distortion[row.places[i]] = p[row.focals + 2 + i];
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    const bool is_finite =
        std::all_of(p.begin(), p.end(), [](double value) { return std::isfinite(value); });
    if (!is_finite) throw std::runtime_error(where + error.what());
    throw ColmapLensError(where + error.what());
  }
  return camera;
}

}  // namespace cousin
