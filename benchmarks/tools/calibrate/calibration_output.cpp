#include "benchmarks/tools/calibrate/calibration_output.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "benchmarks/score/distributions.h"
#include "benchmarks/tools/calibrate/device_output.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/camera_files.h"
#include "sim/dataset/colmap_model.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string_view name_of(TargetStatus status) {
  switch (status) {
    case TargetStatus::ok:
      return "ok";
    case TargetStatus::half_turn_unknown:
      return "half_turn_unknown";
    case TargetStatus::not_seen:
      return "not_seen";
    case TargetStatus::too_few_points:
      return "too_few_points";
    case TargetStatus::disordered:
      return "disordered";
    case TargetStatus::wrong_target:
      return "wrong_target";
  }
  return "?";
}

/// The layout that was seen, for a ChArUco board that has two; else empty.
std::string layout_text(const CalibrationPhotos& photos) {
  if (!has_two_layouts(photos.target) || !photos.layout) return "";
  return *photos.layout == CharucoLayout::current
             ? "current: the upper left square is black, as OpenCV 4.6 and later draws it"
             : "legacy: the upper left square is white, as OpenCV up to 4.5 and setLegacyPattern "
               "draw it";
}

bool has_turned_photos(const CalibrationRun& run) {
  return std::any_of(run.photos.photos.begin(), run.photos.photos.end(),
                     [](const CalibrationPhoto& p) { return p.exif_orientation != 1; });
}

/// For files of other programs, whose readers pass over comments of this form.
std::string pixel_comment(const CalibrationRun& run) {
  if (!has_turned_photos(run)) return "";
  return "# Pixels as they are stored in the files: the EXIF orientation of the photographs was "
         "not "
         "applied.\n";
}

/// The text with the comment in front, or behind YAML's first line where that is a directive.
std::string commented(const std::string& comment, const std::string& text) {
  constexpr std::string_view kBegin = "---\n";
  const std::size_t at = text.starts_with("%YAML") ? text.find(kBegin) : std::string::npos;
  if (at == std::string::npos) return comment + text;
  return text.substr(0, at + kBegin.size()) + comment + text.substr(at + kBegin.size());
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json pose_json(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation_m;
  return {{"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}},
          {"translation_m", {t.x(), t.y(), t.z()}}};
}

/// Of each of the input's views; NaN where nothing was used.
std::vector<double> view_rms_px(const CalibrationRun& run) {
  std::vector<double> squares(run.input.views.size(), 0);
  std::vector<int> counts(run.input.views.size(), 0);
  for (const CalibrationResidual& r : run.result.residuals) {
    if (r.rejected) continue;
    squares[static_cast<std::size_t>(r.view)] += r.residual_px.squaredNorm();
    ++counts[static_cast<std::size_t>(r.view)];
  }
  for (std::size_t i = 0; i < squares.size(); ++i)
    squares[i] = counts[i] > 0 ? std::sqrt(squares[i] / (2 * counts[i])) : std::nan("");
  return squares;
}

Json camera_json(const CalibrationRun& run, std::size_t c) {
  const Camera& lens = run.result.cameras[c];
  const CameraVerdict& v = run.verdicts[c];
  Json json{{"name", run.photos.cameras[c]},
            {"model", to_string(lens.model)},
            {"width_px", lens.width_px},
            {"height_px", lens.height_px}};
  Json parameters = Json::object();
  const std::string prefix = "camera" + std::to_string(c) + ".";
  for (std::size_t i = 0; i < run.result.parameters.size(); ++i) {
    const std::string& name = run.result.parameters[i];
    if (!name.starts_with(prefix)) continue;
    parameters[name.substr(prefix.size())] = {
        {"value", number(run.result.values(static_cast<Eigen::Index>(i)))},
        {"deviation", number(deviation(run.result, name))}};
  }
  json["parameters"] = parameters;
  if (lens.model != LensModel::splined_stereographic) {
    json["camera_matrix"] = {lens.fx_px, 0, lens.cx_px, 0, lens.fy_px, lens.cy_px, 0, 0, 1};
    json["distortion"] = std::vector<double>(
        lens.distortion.begin(), lens.distortion.begin() + distortion_count(lens.model));
  }
  json["camera_from_rig"] = pose_json(run.result.camera_from_rig[c]);
  json["rms_px"] = number(v.rms_px);
  json["predicted_corner_deviation_px"] = number(v.predicted_px);
  json["coverage"] = number(v.coverage);
  json["tilt_spread_rad"] = number(v.tilt_spread_rad);
  if (!v.uncertainty.covariance_px2.empty()) {
    json["projection_deviation_median_px"] = number(v.deviation_px);
    json["projection_deviation_rms_px"] = number(rms_deviation_px(v.uncertainty));
    json["valid_share"] = number(v.valid_share);
  }
  if (v.next) {
    json["next_view"] = {{"words", v.next->words},
                         {"camera_from_target", pose_json(v.next->camera_from_target)},
                         {"now_px", number(v.next->now_px)},
                         {"then_px", number(v.next->then_px)}};
  }
  return json;
}

std::string line_of(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::vector<CalibratedCamera> calibrated(const CalibrationRun& run) {
  std::vector<CalibratedCamera> cameras;
  for (std::size_t c = 0; c < run.result.cameras.size(); ++c)
    cameras.push_back(
        {run.photos.cameras[c], run.result.cameras[c], run.result.camera_from_rig[c]});
  return cameras;
}

using FileTexts = std::vector<std::pair<std::string, std::string>>;  ///< name, what it holds

FileTexts colmap_texts(const CalibrationRun& run) {
  ColmapModel model;
  for (std::size_t c = 0; c < run.result.cameras.size(); ++c)
    model.cameras[static_cast<int>(c) + 1] = run.result.cameras[c];
  // Views of the target's frame.
  int id = 1;
  for (std::size_t i = 0; i < run.input.views.size(); ++i) {
    const TargetView& view = run.input.views[i];
    if (!is_usable(view)) continue;
    for (const CalibrationFrame& f : run.result.frames) {
      if (f.frame != view.frame) continue;
      model.images[id++] = {
          run.photos.photos[i].name, view.camera + 1,
          run.result.camera_from_rig[static_cast<std::size_t>(view.camera)] * f.rig_from_target};
    }
  }
  const ColmapFiles files = colmap_text(model);
  return {{"cameras.txt", pixel_comment(run) + files.cameras},
          {"images.txt", files.images},
          {"points3D.txt", files.points}};
}

}  // namespace

std::string calibration_json(const CalibrationRun& run) {
  Json json{{"schema", 1},
            {"status", to_string(run.result.status)},
            {"usable", run.problems.empty()},
            {"board", to_text(run.photos.target)},
            {"board_layout", layout_text(run.photos)},
            {"model", to_string(run.config.model)},
            {"solver", to_string(run.config.calibration.solver)},
            {"rms_px", number(run.result.rms_px)},
            {"sigma_px", number(run.result.sigma_px)},
            {"noise_factor", number(run.result.noise_factor)},
            {"solver_rms_px", number(run.result.solver_rms_px)},
            {"solver_rms_name", run.result.solver_rms_name},
            {"observations", run.result.observations},
            {"rejected", run.result.rejected},
            {"outliers", run.result.outliers},
            {"detect_s", number(run.detect_s)},
            {"solve_s", number(run.result.seconds)}};
  if (layout_text(run.photos).empty()) json.erase("board_layout");
  if (has_turned_photos(run)) json["pixels"] = "as stored: the EXIF orientation is not applied";
  json["problems"] = run.problems;
  json["warnings"] = run.warnings;
  json["not_determined"] = run.result.not_determined;
  json["cameras"] = Json::array();
  for (std::size_t c = 0; c < run.verdicts.size(); ++c)
    json["cameras"].push_back(camera_json(run, c));
  if (run.cross) {
    json["cross_validation"] = {{"difference_rms_px", number(run.cross->difference.rms_px)},
                                {"predicted_rms_px", number(run.cross->predicted_rms_px)}};
  }
  add_device(run, json);
  json["images"] = Json::array();
  const std::vector<double> rms = view_rms_px(run);
  for (std::size_t i = 0; i < run.input.views.size(); ++i) {
    const TargetView& view = run.input.views[i];
    Json image{{"file", run.photos.photos[i].name},
               {"camera", run.photos.cameras[static_cast<std::size_t>(view.camera)]},
               {"frame", view.frame},
               {"status", name_of(view.status)},
               {"points", view.points.size()},
               {"rms_px", number(rms[i])}};
    const int orientation = run.photos.photos[i].exif_orientation;
    if (orientation != 1) image["exif_orientation"] = orientation;
    if (!view.reason.empty()) image["reason"] = view.reason;
    json["images"].push_back(image);
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string calibration_table(const CalibrationRun& run) {
  std::string text = "board      " + to_text(run.photos.target) + "\n";
  if (!layout_text(run.photos).empty()) text += "layout     " + layout_text(run.photos) + "\n";
  const auto used = std::count_if(run.input.views.begin(), run.input.views.end(),
                                  [](const TargetView& v) { return is_usable(v); });
  text += line_of("images     %d of %d show it, %d points", static_cast<int>(used),
                  static_cast<int>(run.input.views.size()), run.result.observations);
  text += line_of("\nresiduals  %.4f px RMS a coordinate; %d rejected\n", run.result.rms_px,
                  run.result.rejected);
  for (std::size_t c = 0; c < run.verdicts.size(); ++c) {
    const CameraVerdict& v = run.verdicts[c];
    const Camera& lens = run.result.cameras[c];
    text += "\n" + terminal_text(run.photos.cameras[c]) + ": " +
            std::string(to_string(lens.model)) +
            line_of(", %d x %d pixels\n", lens.width_px, lens.height_px);
    const std::string prefix = "camera" + std::to_string(c) + ".";
    for (std::size_t i = 0; i < run.result.parameters.size(); ++i) {
      const std::string& name = run.result.parameters[i];
      if (!name.starts_with(prefix)) continue;
      if (lens.model == LensModel::splined_stereographic && name.find(".u") != name.npos) continue;
      text += line_of("  %-6s %14.6g +- %.3g\n", name.substr(prefix.size()).c_str(),
                      run.result.values(static_cast<Eigen::Index>(i)), deviation(run.result, name));
    }
    if (c > 0) {
      const Pose& p = run.result.camera_from_rig[c];
      text += line_of(
          "  baseline %.4f mm, turned by %.4f degrees\n", 1000 * p.translation_m.norm(),
          p.rotation.angularDistance(Eigen::Quaterniond::Identity()) * 180 / std::numbers::pi);
    }
    text += line_of(
        "  residuals %.4f px (detection predicts %.4f), coverage %.0f %%, tilts over "
        "%.0f degrees\n",
        v.rms_px, v.predicted_px, 100 * v.coverage, v.tilt_spread_rad * 180 / std::numbers::pi);
    if (!v.uncertainty.covariance_px2.empty())
      text +=
          line_of("  projection known to %.4f px, the median over the image; %.0f %% of it valid\n",
                  v.deviation_px, 100 * v.valid_share);
    if (v.next)
      text += "  next: " + terminal_text(v.next->words) +
              line_of(" (%.4f px becomes %.4f px)\n", v.next->now_px, v.next->then_px);
  }
  if (run.cross)
    text +=
        line_of("\nhalves of the images differ by %.4f px RMS; their deviations predict %.4f px\n",
                run.cross->difference.rms_px, run.cross->predicted_rms_px);
  text += device_table(run);
  for (const std::string& warning : run.warnings)
    text += "warning: " + terminal_text(warning) + "\n";
  for (const std::string& problem : run.problems)
    text += "REFUSED: " + terminal_text(problem) + "\n";
  return text;
}

std::vector<ScoreRow> calibration_rows(const CalibrationRun& run) {
  std::vector<ScoreRow> rows;
  for (std::size_t i = 0; i < run.result.parameters.size(); ++i) {
    const std::string& name = run.result.parameters[i];
    const std::size_t dot = name.find('.');
    ScoreRow row;
    row.suite = "calibrate";
    row.scene = std::string(to_string(run.photos.target.kind));
    row.case_name = dot == name.npos ? "board" : name.substr(0, dot);
    row.method = std::string(to_string(run.config.calibration.solver));
    row.metric = dot == name.npos ? name : name.substr(dot + 1);
    row.value = run.result.values(static_cast<Eigen::Index>(i));
    row.unit = row.metric.ends_with("_px")    ? "px"
               : row.metric.ends_with("_s")   ? "s"
               : row.metric.starts_with("t_") ? "m"
                                              : "1";
    row.n = run.result.observations;
    const double half = kSigmas95 * deviation(run.result, name);
    row.ci_low = row.value - half;
    row.ci_high = row.value + half;
    row.wall_s = run.detect_s + run.result.seconds;
    if (!run.problems.empty()) row.status = ScoreStatus::not_solved;
    rows.push_back(row);
  }
  return rows;
}

std::vector<std::string> calibration_names() {
  return {"calibration.json", "opencv", "ros", "kalibr", "mrcal", "colmap"};
}

std::vector<std::string> write_calibration_files(const fs::path& folder,
                                                 const CalibrationRun& run) {
  std::vector<std::string> lines;
  if (!run.problems.empty()) return lines;
  const std::vector<CalibratedCamera> cameras = calibrated(run);
  const std::string comment = pixel_comment(run);
  const auto attempt = [&](const char* format, const std::function<FileTexts()>& make) {
    FileTexts texts;
    try {
      texts = make();
    } catch (const std::invalid_argument& error) {  // the format has no such lens
      lines.push_back(std::string(format) + ": not written: " + error.what());
      return;
    }
    for (const auto& [file, text] : texts) write_file(folder / format / file, text);
    lines.push_back(std::string(format) + ": " + (folder / format).string());
  };
  const auto each = [&](const char* ending, const auto& text_of) {
    FileTexts texts;
    for (const CalibratedCamera& c : cameras)
      texts.emplace_back(c.name + ending, commented(comment, text_of(c)));
    return texts;
  };
  attempt("opencv", [&] {
    return each(".yaml",
                [&](const CalibratedCamera& c) { return opencv_yaml(c, cameras.front()); });
  });
  attempt("ros", [&] { return each(".yaml", ros_camera_info); });
  attempt("kalibr", [&] {
    return FileTexts{{"camchain.yaml", commented(comment, kalibr_camchain(cameras))}};
  });
  attempt("mrcal", [&] { return each(".cameramodel", mrcal_cameramodel); });
  attempt("colmap", [&] { return colmap_texts(run); });
  return lines;
}

}  // namespace cousin
