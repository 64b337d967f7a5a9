#include "benchmarks/suites/calibration/study_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace cousin {
namespace {

std::string text_of(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

StudyMethod ours(LensModel model, std::vector<std::string> fixed = {}) {
  StudyMethod method;
  method.name = "ceres " + std::string(to_string(model));
  method.model = model;
  method.solve.fixed = std::move(fixed);
  return method;
}
StudyMethod ours() { return ours(LensModel::opencv5); }

/// What one has without calibrating: whether it is worth while.
StudyMethod factory() {
  StudyMethod method;
  method.name = "as the device reports";
  method.is_factory = true;
  return method;
}

/// Whether calibrating anew is worth while: after it, from few photographs and from many; before
/// it; not at all.
std::vector<StudyMethod> fresh_and_factory() {
  std::vector<StudyMethod> methods;
  for (const int views : {5, 12, 30}) {
    StudyMethod fresh = ours();
    fresh.views = views;
    fresh.is_fresh = true;
    fresh.name = "fresh, " + std::to_string(views) + " photographs";
    methods.push_back(fresh);
  }
  StudyMethod before = ours();
  before.name = "calibrated before";
  methods.push_back(before);
  methods.push_back(factory());
  return methods;
}

/// A study: its name, its unit, what it draws, and one point for each value.
struct Study {
  std::string axis, unit;
  std::vector<double> values, quick;
  std::function<void(double, StudyPoint&)> set;
};

std::string key(const std::string& name, double value) { return name + "=" + text_of(value); }

std::vector<Study> studies_of_views() {
  constexpr double kDegree = std::numbers::pi / 180;
  return {
      {"images",
       "1",
       {3, 5, 8, 12, 20, 30, 60},
       {5, 12},
       [](double n, StudyPoint& p) {
         p.views = static_cast<int>(n);
         StudyMethod opencv = ours();
         opencv.name = "opencv opencv5";
         opencv.solve.solver = CalibrationSolver::opencv;
         StudyMethod lean = ours(LensModel::opencv5, {"p1", "p2", "k3"});
         lean.name = "ceres k1 k2";
         p.methods = {ours(), lean, opencv, factory()};
       }},
      {"tilt",
       "deg",
       {3, 5, 10, 20, 45},
       {5, 45},
       [](double deg, StudyPoint& p) { p.sets = {key("poses.tilt_max_rad", deg * kDegree)}; }},
      {"size of the board in the picture",
       "1",
       {0.25, 0.5, 0.85},
       {0.25, 0.85},
       [](double fill, StudyPoint& p) {
         p.sets = {key("poses.fill_min", fill - 0.05), key("poses.fill_max", fill + 0.05)};
       }},
      {"coverage",
       "1",
       {0, 0.5, 1},
       {0, 1},
       [](double c, StudyPoint& p) {
         p.sets = {key("coverage", c), "poses.fill_min=0.25", "poses.fill_max=0.4"};
       }},
      {"squares",
       "m",
       {0.012, 0.022, 0.045},
       {0.012, 0.045},
       [](double side_m, StudyPoint& p) {
         // As many as fit on an A4 sheet.
         p.sets = {"board=chessboard_a4", key("target.pitch_m", side_m),
                   key("target.columns", std::floor(0.26 / side_m)),
                   key("target.rows", std::floor(0.18 / side_m))};
       }},
  };
}

std::vector<Study> studies_of_images() {
  return {
      {"noise",
       "e",
       {3, 10, 30, 100, 300},
       {10, 100},
       [](double e, StudyPoint& p) {
         p.sensor_sets = {key("rig.color.photosites.read_noise_e", e)};
       }},
      {"blur",
       "px",
       {0.3, 0.5, 1, 2, 3},
       {0.5, 2},
       [](double px, StudyPoint& p) { p.sensor_sets = {key("rig.color.lens.blur_sigma_px", px)}; }},
      {"rolling shutter",
       "s",
       {0, 0.01, 0.033},
       {0, 0.033},
       [](double s, StudyPoint& p) {
         p.sets = {key("rig.color.photosites.readout_s", s), "rig.hand_speed_m_per_s=0.05",
                   "rig.hand_rate_rad_per_s=0.1"};
       }},
      {"outliers",
       "1",
       {0, 0.01, 0.03, 0.1, 0.2, 0.3},
       {0, 0.1},
       [](double share, StudyPoint& p) {
         p.outlier_share = share;
         StudyMethod robust = ours();
         robust.name += ", Cauchy loss";
         robust.solve.loss = RobustLoss::cauchy;
         StudyMethod passes = robust;
         passes.name += ", rejected beyond 4 sigma";
         passes.solve.reject_sigmas = 4;
         p.methods = {ours(), robust, passes};
       }},
  };
}

std::vector<Study> studies_of_boards() {
  return {
      {"warp",
       "m",
       {0, 0.001, 0.004},
       {0, 0.004},
       [](double m, StudyPoint& p) {
         p.sets = {key("flaws.warp_x_m", m), key("flaws.warp_y_m", -0.5 * m)};
         StudyMethod bends = ours();
         bends.name += ", board bends";
         bends.solve.board_deformation = true;
         p.methods = {ours(), bends};
       }},
      {"print stretch",
       "1",
       {0, 0.003, 0.01},
       {0, 0.01},
       [](double s, StudyPoint& p) { p.sets = {key("flaws.stretch_x", 1 + s)}; }},
      {"warming",
       "K",
       {0, 5, 10, 20, 40},
       {0, 20},
       [](double kelvin, StudyPoint& p) {
         // The barrel of aluminium, 23e-6 / K, carries the lens: the image grows with it; the glue
         // moves the lens by a fiftieth of a pixel a kelvin (free).
         p.at_work = [kelvin](Camera camera) {
           camera.fx_px *= 1 + 23e-6 * kelvin;
           camera.fy_px *= 1 + 23e-6 * kelvin;
           camera.cx_px += 0.02 * kelvin;
           return camera;
         };
         p.methods = fresh_and_factory();
       }},
      {"knock",
       "px",
       {0, 0.5, 1, 2, 5},
       {0, 2},
       [](double px, StudyPoint& p) {
         p.at_work = [px](Camera camera) {
           camera.cx_px += 0.8 * px;
           camera.cy_px -= 0.6 * px;
           return camera;
         };
         p.methods = fresh_and_factory();
       }},
  };
}

StudyPoint kind(const std::string& axis, int number, const std::string& label,
                std::vector<std::string> sets, std::vector<StudyMethod> methods) {
  StudyPoint point;
  point.axis = axis;
  point.label = label;
  point.x = number;
  point.sets = std::move(sets);
  point.methods = std::move(methods);
  return point;
}

std::vector<std::string> with(std::vector<std::string> sets, const std::string& set) {
  sets.push_back(set);
  return sets;
}

/// The paper's two programs, each with its own corner finder as far as that is known, and ours.
std::vector<StudyMethod> paper_methods() {
  StudyMethod opencv = ours();
  opencv.name = "opencv opencv5, OpenCV's corners";
  opencv.solve.solver = CalibrationSolver::opencv;
  opencv.finder = CornerFinder::opencv;
  StudyMethod lean = ours(LensModel::opencv5, {"p1", "p2", "k3"});
  lean.name = "ceres k1 k2";
  return {opencv, lean, ours()};
}

void add_kinds(bool quick, std::vector<StudyPoint>& points) {
  int number = 0;
  for (const char* board :
       {"chessboard_a4", "charuco_a4", "aprilgrid_a4", "circles_a4", "acircles_a4"}) {
    points.push_back(kind("board", number++, board, {"board=" + std::string(board)}, {ours()}));
  }
  // A wider lens with more barrel than the D457's.
  const std::vector<std::string> wide = {"rig.color_focal_px=330",
                                         "rig.color_distortion=[-0.2,0.05,0.001,-0.0008,-0.004]"};
  std::vector<StudyMethod> models = {ours(LensModel::pinhole),
                                     ours(LensModel::opencv5, {"p1", "p2", "k3"}), ours()};
  models[1].name = "ceres k1 k2";
  for (const LensModel rich : {LensModel::opencv8, LensModel::opencv12, LensModel::kannala_brandt4,
                               LensModel::splined_stereographic})
    models.push_back(ours(rich));
  for (const int n : quick ? std::vector<int>{12} : std::vector<int>{8, 30}) {
    points.push_back(kind("lens model", number++, std::to_string(n) + " images", wide, models));
    points.back().views = n;
  }
  // The board and the number of photographs of the Strawberries paper; how far it was tilted is not
  // said.
  const std::vector<std::string> paper = {"board=chessboard_a4", "target.columns=6",
                                          "target.rows=9", "target.pitch_m=0.025"};
  const std::vector<std::string> little = {"poses.tilt_max_rad=0.07", "poses.fill_max=0.5"};
  const std::vector<std::string> more = {"poses.tilt_max_rad=0.175", "poses.fill_max=0.5"};
  struct Copy {
    const char* label;
    std::vector<std::string> sets, sensor_sets;
  };
  for (const Copy& copy :
       {Copy{"tilted up to 4 deg", little, {}},
        {"tilted up to 4 deg, blurred by 2 px", little, {"rig.color.lens.blur_sigma_px=2"}},
        {"tilted up to 10 deg", more, {}},
        {"tilted up to 45 deg, close", {}, {}},
        {"tilted up to 10 deg, paper bent by 2 mm", with(more, "flaws.warp_y_m=0.002"), {}}}) {
    std::vector<std::string> sets = paper;
    sets.insert(sets.end(), copy.sets.begin(), copy.sets.end());
    points.push_back(kind("strawberries", number++, copy.label, sets, paper_methods()));
    points.back().sensor_sets = copy.sensor_sets;
  }
  // A phone focuses anew for each picture: its focal length breathes.
  const int phone_views = quick ? 8 : 12;  // of three times as many pixels
  for (const auto& [label, sets] : {std::pair<std::string, std::vector<std::string>>{
                                        "held", {"rig=phone_video_720p", "rig.autofocus=false"}},
                                    {"breathes", {"rig=phone_video_720p", "rig.autofocus=true"}}}) {
    points.push_back(kind("focus", number++, label, sets, {ours()}));
    points.back().views = phone_views;
  }
}

}  // namespace

std::vector<StudyPoint> study_points(bool quick) {
  std::vector<StudyPoint> points;
  for (const auto& studies : {studies_of_views(), studies_of_images(), studies_of_boards()}) {
    for (const Study& study : studies) {
      for (const double value : quick ? study.quick : study.values) {
        StudyPoint point;
        point.axis = study.axis;
        point.x = value;
        point.unit = study.unit;
        point.label = text_of(value) + (study.unit == "1" ? "" : " " + study.unit);
        point.methods = {ours()};
        study.set(value, point);
        points.push_back(std::move(point));
      }
    }
  }
  add_kinds(quick, points);
  for (StudyPoint& point : points) {
    if (point.views == 0) point.views = quick ? 8 : 30;
  }
  return points;
}

std::vector<std::string> study_sets() { return {"rig=d457", "board=charuco_a4"}; }

std::string study_label(const std::string& axis) {
  static const std::array<std::pair<const char*, const char*>, 13> kLabels = {
      {{"images", "photographs"},
       {"tilt", "largest tilt (deg)"},
       {"size of the board in the picture", "share of the picture that the board spans"},
       {"coverage", "share of the picture that the board's middle goes to"},
       {"squares", "side of a square (m)"},
       {"noise", "read noise (electrons)"},
       {"blur", "blur (px, standard deviation)"},
       {"rolling shutter", "readout (s)"},
       {"outliers", "share of the corners that are wrong"},
       {"warp", "bend of the board (m)"},
       {"print stretch", "stretch of the print across"},
       {"warming", "warmer at work (K)"},
       {"knock", "principal point moved (px)"}}};
  for (const auto& [name, label] : kLabels) {
    if (axis == name) return label;
  }
  return {};
}

void spoil(std::vector<TargetView>& views, double share, Rng rng) {
  if (share <= 0) return;
  for (std::size_t v = 0; v < views.size(); ++v) {
    Rng draw = rng.fork(v);
    for (TargetObservation& point : views[v].points) {
      const bool is_wrong = uniform(draw) < share;
      const double far_px = uniform(draw, 2, 20), angle = uniform(draw, 0, 2 * std::numbers::pi);
      if (is_wrong) point.pixel_px += far_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
  }
}

}  // namespace cousin
