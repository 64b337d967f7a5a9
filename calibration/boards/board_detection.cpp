#include "calibration/boards/board_detection.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "calibration/boards/board_template.h"
#include "calibration/boards/board_turns.h"
#include "calibration/boards/corner_refinement.h"
#include "calibration/boards/grid_growth.h"
#include "calibration/boards/homography.h"
#include "calibration/boards/plate_outline.h"
#include "calibration/boards/print_match.h"
#include "sim/config/limits.h"
#include "sim/imaging/color.h"
#include "sim/types/pose.h"

namespace cousin {
namespace {

// Saddles of the plate turned upright: squares ten pixels wide, blurred along one axis.
constexpr double kUprightSmoothingPx = 2.0, kUprightContrast = 0.001;

/// Linear luma (Rec. 709 weights) and the perceptual luma that saddles are sought in, both in [0,
/// 1].
struct Planes {
  Image<float> linear;
  Image<float> perceptual;
};

Planes planes_of(const Image<Rgb8>& color) {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = linear_from_srgb8(static_cast<std::uint8_t>(i));
  Planes planes{Image<float>(color.width(), color.height()),
                Image<float>(color.width(), color.height())};
  for (std::size_t i = 0; i < color.size(); ++i) {
    const Rgb8 c = color.data()[i];
    planes.linear.data()[i] = 0.2126F * table[c.r] + 0.7152F * table[c.g] + 0.0722F * table[c.b];
    planes.perceptual.data()[i] = (0.299F * c.r + 0.587F * c.g + 0.114F * c.b) / 255.0F;
  }
  return planes;
}

/// A frame's board as far as its own image tells.
struct BoardView {
  BoardStatus status = BoardStatus::not_seen;
  Eigen::Matrix3d normalized_from_board = Eigen::Matrix3d::Identity();
  std::vector<CornerObservation> corners;
};

std::optional<Eigen::Vector2d> normalized(const Camera& camera, const Eigen::Vector2d& pixel) {
  const std::optional<Eigen::Vector3d> ray = unproject(camera, pixel);
  if (!ray || ray->z() < 1e-3) return std::nullopt;
  return Eigen::Vector2d(ray->head<2>() / ray->z());
}

/// The lattice's homography (plane in lattice steps), without the corners that do not follow it.
HomographyFit fit_lattice(const Camera& camera, std::vector<LatticeCorner>& lattice) {
  constexpr double kMaxResidualPx = 1.5;
  HomographyFit fit;
  for (int round = 0; round < 4; ++round) {
    std::vector<PlanePoint> points;
    std::vector<LatticeCorner> kept;
    for (const LatticeCorner& c : lattice) {
      const std::optional<Eigen::Vector2d> n = normalized(camera, c.pixel_px);
      if (!n) continue;
      points.push_back({Eigen::Vector2d(c.column, c.row), *n, 0.3 / camera.fx_px});
      kept.push_back(c);
    }
    lattice = kept;
    fit = fit_homography(points);
    if (!fit.ok) return fit;
    std::vector<LatticeCorner> good;
    for (std::size_t i = 0; i < lattice.size(); ++i) {
      if (fit.residual[i] * 0.3 < kMaxResidualPx) good.push_back(lattice[i]);
    }
    if (good.size() == lattice.size()) return fit;
    lattice = good;
  }
  return fit;
}

/// Board corner = turn (quarter turns counter-clockwise) of the lattice, then a shift.
struct Placement {
  int turn = 0;
  int column = 0;
  int row = 0;
};

std::array<int, 2> turned(int turn, int column, int row) {
  switch (turn % 4) {
    case 1:
      return {-row, column};
    case 2:
      return {-column, -row};
    case 3:
      return {row, -column};
    default:
      return {column, row};
  }
}

Eigen::Matrix3d lattice_from_board(const SeedBoard& board, const Placement& p) {
  // corner_in_world_m(c, r) = (c + 1) square - half, so c = x / square + squares / 2 - 1.
  const double s = 1 / board.square_m, middle = 0.5 * board.squares - 1;
  Eigen::Matrix3d corner_from_board;
  corner_from_board << s, 0, middle, 0, s, middle, 0, 0, 1;
  const auto ex = turned(p.turn, 1, 0), ey = turned(p.turn, 0, 1);
  Eigen::Matrix3d corner_from_lattice;
  corner_from_lattice << ex[0], ey[0], p.column, ex[1], ey[1], p.row, 0, 0, 1;
  return corner_from_lattice.inverse() * corner_from_board;
}

/// Placements that keep the lattice on the board and squares on their colour.
std::vector<Placement> placements(const SeedBoard& board,
                                  const std::vector<LatticeCorner>& lattice) {
  std::vector<Placement> result;
  const int last = board.squares - 2;
  for (int turn = 0; turn < 4; ++turn) {
    std::array<int, 2> low{1 << 20, 1 << 20}, high{-(1 << 20), -(1 << 20)};
    for (const LatticeCorner& c : lattice) {
      const auto p = turned(turn, c.column, c.row);
      low = {std::min(low[0], p[0]), std::min(low[1], p[1])};
      high = {std::max(high[0], p[0]), std::max(high[1], p[1])};
    }
    const auto first = turned(turn, lattice.front().column, lattice.front().row);
    for (int row = -low[1]; row <= last - high[1]; ++row) {
      for (int column = -low[0]; column <= last - high[0]; ++column) {
        const bool dark = (first[0] + column + first[1] + row + turn) % 2 == 0;
        if (dark == lattice.front().dark_ahead) result.push_back({turn, column, row});
      }
    }
  }
  return result;
}

struct Choice {
  Placement placement;
  BoardStatus status = BoardStatus::not_seen;
  double correlation = -1;
};

/// The placement that correlates best. A plain board's turns tie, so only shifts compete there.
Choice choose_placement(const Planes& planes, LensMap& lens, const SeedBoard& board,
                        const BoardPattern& pattern, const std::vector<LatticeCorner>& lattice,
                        const Eigen::Matrix3d& normalized_from_lattice,
                        const BoardDetectionConfig& config) {
  struct Scored {
    Placement placement;
    double score = -1;
    BoardTemplate print;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< of the board, on the lattice
  };
  Scored best, next;
  for (const Placement& p : placements(board, lattice)) {
    const Eigen::Matrix3d from_board = lattice_from_board(board, p);
    const Eigen::Matrix3d h = normalized_from_lattice * from_board;
    const PixelBox box = plate_box(board, lens.camera(), h);
    if (box.empty()) continue;
    Scored one{p, 0, render_board(pattern, lens, box, h, kStartBlurPx, TemplateQuality::coarse),
               from_board.col(2).head<2>()};
    one.score = correlation(planes.linear, pattern, one.print);
    const bool same =
        !board.has_markers && best.score > -1 && (one.middle - best.middle).norm() < 0.1;
    if (same) continue;
    if (one.score > best.score) {
      next = std::move(best);
      best = std::move(one);
    } else if (one.score > next.score) {
      next = std::move(one);
    }
  }
  Choice choice{best.placement};
  choice.correlation = best.score;
  if (best.score < config.min_correlation) return choice;
  const bool clear = next.score < 0 || preference(planes.linear, pattern, best.print, next.print) >=
                                           config.min_preference;
  choice.status = clear ? BoardStatus::ok : BoardStatus::ambiguous;
  return choice;
}

double quantile(std::vector<double> values, double share) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

double median(const std::vector<double>& values) { return quantile(values, 0.5); }

/// Pixels a board square spans about a corner, as the matrix d(pixel)/d(square).
Eigen::Matrix2d pixels_per_square(const Camera& camera, const SeedBoard& board,
                                  const Eigen::Matrix3d& h, const Eigen::Vector3d& at) {
  const double d = 0.25 * board.square_m;
  const auto seen = [&](double x, double y) {
    return project(camera, h * Eigen::Vector3d(at.x() + x, at.y() + y, 1))
        .value_or(Eigen::Vector2d::Zero());
  };
  Eigen::Matrix2d m;
  m << 2 * (seen(d, 0) - seen(-d, 0)), 2 * (seen(0, d) - seen(0, -d));
  return m;
}

/// Corners whose window shows the print and nothing else, and whose shift is a fraction of a
/// square.
std::vector<CornerFit> accept(const std::vector<CornerFit>& fits, const Camera& camera,
                              const SeedBoard& board, const Eigen::Matrix3d& h) {
  constexpr double kMaxShiftSquares = 0.3, kMinContrast = 0.3, kNoiseFactor = 2.0, kClean = 0.2;
  if (fits.empty()) return {};
  std::vector<double> noises, contrasts;
  for (const CornerFit& f : fits) {
    noises.push_back(f.noise);
    contrasts.push_back(f.contrast);
  }
  // In low views seeds touch most windows, so the clean ones set the scale: the lowest fifth.
  const double max_noise = kNoiseFactor * quantile(noises, kClean);
  const double min_contrast = kMinContrast * median(contrasts);
  std::vector<CornerFit> result;
  for (const CornerFit& f : fits) {
    if (f.noise > max_noise || f.contrast < min_contrast) continue;
    const Eigen::Matrix2d scale =
        pixels_per_square(camera, board, h, corner_in_world_m(board, f.column, f.row));
    if (!((scale.inverse() * f.shift_px).norm() < kMaxShiftSquares)) continue;
    result.push_back(f);
  }
  return result;
}

/// Drops corners that do not follow the plane; updates the homography. False if the rest is not a
/// plane's.
bool fit_plane(const Camera& camera, const SeedBoard& board, std::vector<CornerFit>& fits,
               Eigen::Matrix3d& h) {
  constexpr double kMaxResidual = 5;  // times the larger of the predicted and the view's own spread
  std::vector<PlanePoint> points;
  for (const CornerFit& f : fits) {
    const std::optional<Eigen::Vector2d> n = normalized(camera, f.pixel_px);
    if (!n) return false;
    const double sigma = std::max(0.01, f.noise * rms_sigma_px(f.covariance_px2));
    points.push_back(
        {corner_in_world_m(board, f.column, f.row).head<2>(), *n, sigma / camera.fx_px});
  }
  for (int round = 0; round < 3; ++round) {
    const HomographyFit fit = fit_homography(points);
    if (!fit.ok) return false;
    h = fit.normalized_from_plane;
    // Median of a 2D residual over its sigma is 1.18; a larger one is the view's model error.
    const double spread = std::max(1.0, median(fit.residual) / 1.18);
    std::vector<CornerFit> kept;
    std::vector<PlanePoint> kept_points;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      if (fit.residual[i] >= kMaxResidual * spread) continue;
      kept.push_back(fits[i]);
      kept_points.push_back(points[i]);
    }
    if (kept.size() == fits.size()) return true;
    fits = kept;
    points = kept_points;
  }
  return fits.size() >= 4;
}

/// Measures all corners by template, outward from those that follow the homography found so far.
void refine(const Planes& planes, LensMap& lens, const SeedBoard& board,
            const BoardPattern& pattern, const BoardDetectionConfig& config, BoardView& view) {
  const Camera& camera = lens.camera();
  constexpr int kMaxRounds = 6;
  std::vector<CornerFit> fits;
  double blur_px = kStartBlurPx;
  std::size_t before = 0;
  bool last = false;
  for (int round = 0; round < kMaxRounds; ++round) {
    const PixelBox box = plate_box(board, camera, view.normalized_from_board);
    if (box.empty()) return;
    last = last || round == kMaxRounds - 1;
    const BoardTemplate t = render_board(pattern, lens, box, view.normalized_from_board, blur_px,
                                         last ? TemplateQuality::fine : TemplateQuality::coarse);
    fits = accept(fit_corners(planes.linear, board, camera, view.normalized_from_board, t,
                              config.window_squares),
                  camera, board, view.normalized_from_board);
    if (fits.size() < 4 || !fit_plane(camera, board, fits, view.normalized_from_board)) return;
    if (last) break;
    blur_px = refined_blur_px(planes.linear, t, fits, config.window_squares, blur_px);
    last = round >= 1 && fits.size() <= before + before / 50;
    before = fits.size();
  }
  if (fits.empty()) return;
  std::vector<double> noises;
  for (const CornerFit& f : fits) noises.push_back(f.noise);
  const double typical = median(noises);
  for (const CornerFit& f : fits) {
    // A window of few pixels knows its own noise badly: it is pooled with the view's.
    constexpr double kPooledPixels = 30, kFloorPx = 1e-3;
    const double variance = (f.pixels * f.noise * f.noise + kPooledPixels * typical * typical) /
                            (f.pixels + kPooledPixels);
    const Eigen::Matrix2d covariance_px2 = variance * f.covariance_px2;
    if (rms_sigma_px(covariance_px2) <= config.max_sigma_px) {
      view.corners.push_back(
          {f.column, f.row, f.pixel_px, covariance_px2 + isotropic_px2(kFloorPx)});
    }
  }
  view.status = static_cast<int>(view.corners.size()) >= config.min_corners
                    ? BoardStatus::ok
                    : BoardStatus::too_few_corners;
}

/// Chooses again among all placements of the corners found, through the homography they gave. A
/// lattice that grew askew fits the print badly wherever it is placed, and the best of bad fits may
/// be refined onto the squares a turn and two squares from the truth.
void confirm_placement(const Planes& planes, LensMap& lens, const SeedBoard& board,
                       const BoardPattern& pattern, const BoardDetectionConfig& config,
                       BoardView& view) {
  std::vector<LatticeCorner> found;
  for (const CornerObservation& c : view.corners) {
    found.push_back({.column = c.column,
                     .row = c.row,
                     .pixel_px = c.pixel_px,
                     .dark_ahead = (c.column + c.row) % 2 == 0});
  }
  const Eigen::Matrix3d from_lattice =
      view.normalized_from_board * lattice_from_board(board, {}).inverse();
  const Choice choice = choose_placement(planes, lens, board, pattern, found, from_lattice, config);
  const Placement& p = choice.placement;
  if (choice.status == BoardStatus::ok && p.turn == 0 && p.column == 0 && p.row == 0) return;
  view.corners.clear();
  view.status = choice.status;
  if (choice.status != BoardStatus::ok) return;
  view.normalized_from_board = from_lattice * lattice_from_board(board, p);
  view.status = BoardStatus::not_seen;
  refine(planes, lens, board, pattern, config, view);
}

/// Places a lattice on the board and measures the corners.
BoardView measure(const Planes& planes, LensMap& lens, const SeedBoard& board,
                  const BoardPattern& pattern, const BoardDetectionConfig& config,
                  std::vector<LatticeCorner> lattice) {
  constexpr int kLeastLattice = 8;
  constexpr double kClearCorrelation = 0.8;  // a lattice that fits reaches 0.9 in sharp views
  BoardView view;
  if (static_cast<int>(lattice.size()) < kLeastLattice) return view;
  const HomographyFit fit = fit_lattice(lens.camera(), lattice);
  if (!fit.ok || static_cast<int>(lattice.size()) < kLeastLattice) return view;
  const Choice choice =
      choose_placement(planes, lens, board, pattern, lattice, fit.normalized_from_plane, config);
  view.status = choice.status;
  if (choice.status != BoardStatus::ok) return view;
  view.normalized_from_board =
      fit.normalized_from_plane * lattice_from_board(board, choice.placement);
  view.status = BoardStatus::not_seen;
  refine(planes, lens, board, pattern, config, view);
  if (view.status == BoardStatus::ok && choice.correlation < kClearCorrelation) {
    confirm_placement(planes, lens, board, pattern, config, view);
  }
  return view;
}

/// The board from the plate's outline: each turn of the print is moved onto the image as a whole.
BoardView measure_plate(const Planes& planes, const Image<Rgb8>& color, LensMap& lens,
                        const SeedBoard& board, const BoardPattern& pattern,
                        const BoardDetectionConfig& config) {
  BoardView view;
  std::vector<PrintMatch> turns;
  for (const auto& starts : boards_in_outline(color, lens.camera(), board)) {
    turns.push_back(best_print(planes.linear, pattern, lens, board, starts));
  }
  const auto best =
      std::max_element(turns.begin(), turns.end(),
                       [](const PrintMatch& a, const PrintMatch& b) { return a.score < b.score; });
  if (best == turns.end() || best->score < config.min_correlation) return view;
  const auto clear = [&](const PrintMatch& other) {
    return other.score < 0 ||
           preference(planes.linear, pattern, best->print, other.print) >= config.min_preference;
  };
  for (auto other = turns.begin(); other != turns.end(); ++other) {
    if (other != best && !clear(*other)) view.status = BoardStatus::ambiguous;
  }
  // Shifts that keep squares on their colour.
  for (const auto& [columns, rows] :
       {std::array{1, 1}, {1, -1}, {-1, 1}, {-1, -1}, {2, 0}, {-2, 0}, {0, 2}, {0, -2}}) {
    Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
    shift.col(2) << columns * board.square_m, rows * board.square_m, 1;
    if (!clear(match_print(planes.linear, pattern, lens, board, best->normalized_from_board * shift,
                           kStartBlurPx))) {
      view.status = BoardStatus::ambiguous;
    }
  }
  if (view.status == BoardStatus::ambiguous) return view;
  view.normalized_from_board = best->normalized_from_board;
  refine(planes, lens, board, pattern, config, view);
  return view;
}

BoardView detect_in_frame(const SensorFrame& frame, const SeedBoard& board,
                          const BoardPattern& pattern, const BoardDetectionConfig& config) {
  BoardView view;
  if (frame.color.empty()) {
    view.status = BoardStatus::no_image;
    return view;
  }
  const Planes planes = planes_of(frame.color);
  LensMap lens(frame.reported);
  const std::vector<Saddle> saddles =
      find_saddles(planes.perceptual, config.saddle_smoothing_px, config.saddle_contrast);
  view = measure(planes, lens, board, pattern, config,
                 grow_lattice(planes.perceptual, saddles, board.squares - 1));
  if (view.status == BoardStatus::ok) return view;
  const auto keep = [&view](BoardView other) {
    if (other.status == BoardStatus::ok || view.status == BoardStatus::not_seen)
      view = std::move(other);
    return view.status == BoardStatus::ok;
  };
  if (keep(measure(planes, lens, board, pattern, config,
                   lattice_of_upright_plate(frame.color, planes.perceptual, board,
                                            kUprightSmoothingPx, kUprightContrast)))) {
    return view;
  }
  keep(measure_plate(planes, frame.color, lens, board, pattern, config));
  return view;
}

/// Turns a view's axes by quarters: rotation of its camera, and the corners' places on the board.
void turn_axes(const SeedBoard& board, int turn, BoardView& view) {
  const int end = board.squares - 2;
  const Eigen::AngleAxisd about_z(0.5 * M_PI * turn, Eigen::Vector3d::UnitZ());
  view.normalized_from_board = view.normalized_from_board * about_z.toRotationMatrix();
  // The axes turn by +k quarters, so a corner's place on the board turns by -k about the middle.
  for (CornerObservation& c : view.corners) {
    const auto p = turned(4 - turn, 2 * c.column - end, 2 * c.row - end);
    c.column = (p[0] + end) / 2;
    c.row = (p[1] + end) / 2;
  }
}

/// A plain board looks the same after a quarter turn: chooses the turns of all views together.
void resolve_turns(const Capture& capture, const SeedBoard& board,
                   const BoardDetectionConfig& config, std::vector<BoardView>& views) {
  std::vector<BoardView*> found;
  std::vector<PlacedBoard> placed;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].status != BoardStatus::ok) continue;
    const SensorFrame& frame = capture.frames[i].sensors.front();
    found.push_back(&views[i]);
    placed.push_back({&frame.color, frame.reported, views[i].normalized_from_board});
  }
  const auto turns = quarter_turns(placed, board, config.max_turn_rad);
  for (std::size_t v = 0; v < found.size(); ++v) {
    if (turns[v]) {
      turn_axes(board, *turns[v], *found[v]);
    } else {
      found[v]->status = BoardStatus::ambiguous;
      found[v]->corners.clear();
    }
  }
}

}  // namespace

Fields fields(BoardDetectionConfig& config) {
  return {
      {"min_corners", &config.min_corners, "views with fewer corners are not used", 4, 1e6},
      {"window_squares", &config.window_squares, "half of a corner's window, in squares", 0.2, 0.5},
      {"max_sigma_px", &config.max_sigma_px, "corners predicted worse than this are dropped", 1e-3,
       10},
      {"saddle_smoothing_px", &config.saddle_smoothing_px, "Gaussian before the search for saddles",
       0.3, 10},
      {"saddle_contrast", &config.saddle_contrast,
       "least sqrt(-det Hessian) of a saddle, of the sRGB range", 1e-6, 1},
      {"min_correlation", &config.min_correlation,
       "of the image with the print for a board to be accepted", 0, 1},
      {"min_preference", &config.min_preference,
       "least correlation with the two best placements' difference", 0, 1},
      {"max_turn_rad", &config.max_turn_rad, "plain board: largest turn between two views used", 0,
       0.78},
  };
}

void validate(const BoardDetectionConfig& config) {
  BoardDetectionConfig copy = config;
  check_limits(fields(copy));
}

Corners detect_board(const Capture& capture, const SeedBoard& board,
                     const BoardDetectionConfig& config) {
  validate(config);
  validate(board);
  for (const Frame& frame : capture.frames) {
    if (frame.sensors.empty()) {
      throw std::invalid_argument("frame " + std::to_string(frame.id) + " has no sensor");
    }
    const SensorFrame& sensor = frame.sensors.front();
    validate(sensor.reported);
    if (!sensor.color.empty() && (sensor.color.width() != sensor.reported.width_px ||
                                  sensor.color.height() != sensor.reported.height_px)) {
      throw std::invalid_argument(
          "frame " + std::to_string(frame.id) + ": the image is " +
          std::to_string(sensor.color.width()) + " x " + std::to_string(sensor.color.height()) +
          " px, its reported camera " + std::to_string(sensor.reported.width_px) + " x " +
          std::to_string(sensor.reported.height_px));
    }
  }
  const BoardPattern pattern(board);
  std::vector<BoardView> views(capture.frames.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    views[i] = detect_in_frame(capture.frames[i].sensors.front(), board, pattern, config);
  });
  if (!board.has_markers) resolve_turns(capture, board, config, views);

  Corners corners;
  for (std::size_t i = 0; i < views.size(); ++i) {
    FrameCorners frame{capture.frames[i].id, views[i].status, {}};
    if (views[i].status == BoardStatus::ok) frame.corners = std::move(views[i].corners);
    corners.push_back(std::move(frame));
  }
  return corners;
}

}  // namespace cousin
