#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "sim/types/image.h"
#include "sim/types/seams.h"

namespace cousin {

/// A number that belongs at the top of the page, with the limit it was held against.
struct Headline {
  std::string label;   ///< "RMSE of length, maize"
  WithInterval value;  ///< SI; shown in millimetres, degrees or per cent
  std::string unit;    ///< as in ScoreRow; "%" shows a ratio in per cent
  std::string limit;   ///< as text, "at most 0.15 mm"; empty if there is none
  ScoreStatus status = ScoreStatus::ok;
  std::string group;  ///< column of the table of limits: "maize"
};

struct ReportImage {
  std::string name;
  std::string caption;
  std::vector<std::uint8_t> png;  ///< the file's bytes; JPEG works too
};

/// One Gaussian of a trained model: covariance R diag(scale^2) R'.
struct ReportSplat {
  Eigen::Vector3f scale_m;      ///< along its own axes, > 0
  Eigen::Quaternionf rotation;  ///< axes -> world, unit norm
  float opacity = 0;            ///< 0..1
};

/// A cloud, a mesh or a model of Gaussians that the reader can turn. World: z up, metres.
struct ReportShape {
  std::string name;
  std::string caption;
  std::vector<Eigen::Vector3f> positions_m;
  std::vector<Rgb8> colors;                             ///< one for each position, or empty
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< empty: a cloud
  /// One for each position, or empty. They are blended by depth, in the colours given.
  std::vector<ReportSplat> splats = {};
};

/// Error over run time of methods whose knob was swept.
struct ErrorTimePoint {
  std::string method;
  std::string setting;  ///< "60 views"
  double wall_s = 0;    ///< > 0
  WithInterval error;
};
struct ErrorTimeCurve {
  std::string title;
  std::string metric;  ///< "RMSE of length"
  std::string unit;    ///< as in ScoreRow
  std::vector<ErrorTimePoint> points;
};

/// A quantity over another, with the laws it is held against.
struct PlotPoint {
  double x = 0;
  WithInterval y;
};
struct LineSeries {
  std::string name;
  std::vector<PlotPoint> points;  ///< in the order of x
  bool is_law = false;            ///< drawn dashed, without points
  bool is_joined = true;          ///< by a line; a law always is
  /// Colour in the palette, so that one thing is one colour on plots that lack others; none: its
  /// place among the series.
  std::optional<std::size_t> color = {};
};
struct LinePlot {
  std::string title;
  std::vector<std::string> caption;  ///< lines
  std::string x_label, y_label;      ///< with units, in which the points are
  bool log_x = false, log_y = false;
  std::vector<LineSeries> series;
  std::string section = {};  ///< heading that it stands under; empty: by whether there are laws
};

/// What remains of an error when truth replaces one seam after another, in the order of the
/// pipeline: the first step is the pipeline as it is, and each further one has truth in its own
/// seam and all before it.
struct AttributionStep {
  std::string stage;
  WithInterval error;
};
struct Attribution {
  std::string title;
  std::string metric;
  std::string unit;
  std::vector<AttributionStep> steps;
};

/// How a quantity is spread over the specimens of each group: a histogram a group over one axis.
struct DistributionGroup {
  std::string name;            ///< "photograph 1"
  std::string kind;            ///< groups of a kind have one colour: "real", "scene"
  std::vector<double> values;  ///< SI, finite
};
struct Distribution {
  std::string title;
  std::string quantity;  ///< "length"
  std::string unit;      ///< as in ScoreRow
  std::vector<DistributionGroup> groups;
};

/// A table as people read it, of numbers that are rows of the scores too.
struct ReportTable {
  std::string title;
  std::string caption;  ///< a line below the title
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> lines;  ///< a cell a column; an empty one: not measured
};
/// A cell of a number times `factor`; empty where there is no row or no number.
std::string table_cell(double value, double factor, int decimals);
std::string table_cell(const ScoreRow* row, double factor, int decimals);
/// The table for a terminal, columns aligned.
std::string table_text(const ReportTable& table);

struct ReportInput {
  std::string title;
  std::string summary;                ///< a paragraph of plain text, after the verdict
  std::string plan;                   ///< what ran and what was left out, folded; empty: none
  std::vector<std::string> commands;  ///< that made what is shown
  std::string config_toml;
  ScoreFile scores;
  std::vector<SpecimenRow> plotted;  ///< of the specimens, those among measured and true
  std::vector<Headline> headlines;   ///< many of them are folded below the plots
  std::vector<Headline> limits;      ///< all that is held against a limit: a line a label
  std::vector<ReportTable> tables;
  std::vector<ReportImage> images;
  std::vector<ReportShape> shapes;
  std::vector<Distribution> distributions;
  std::vector<ErrorTimeCurve> curves;
  std::vector<LinePlot> lines;
  std::vector<Attribution> attributions;
  std::vector<StageTiming> timings;  ///< of one run
  std::vector<std::string> notes;    ///< warnings, what was left out and why
};

struct ReportConfig {
  /// Folder with vega/ and three/ as Debian's libjs-vega and libjs-three lay them; empty: the
  /// folder compiled in (CMake: COUSIN_JAVASCRIPT).
  std::filesystem::path javascript;
  int max_points = 60000;  ///< of a cloud; a larger one is thinned evenly, and its caption says so
};

/// One HTML page that holds everything: text, tables, images, plots (Vega), shapes to turn
/// (three.js), and the data for download. It loads nothing from anywhere. Where Vega is missing, a
/// note stands in place of the plots; where three.js or WebGL is missing, shapes are drawn on a
/// plain canvas.
///
/// For tests the page's root element carries data-ready="true" when all is drawn and data-errors,
/// the number of errors; each plot data-plot-ok, each shape data-view-ok ("webgl" or "canvas").
/// @throws std::invalid_argument if an index or a size in a shape does not fit, a time is not
/// positive, or a table's line has not a cell a column.
std::string make_report(const ReportInput& input, const ReportConfig& config = {});

/// Which points no other one beats: none is at most as slow and at most as wrong, and better in
/// one. Points whose error is NaN are never on the front.
std::vector<bool> pareto_front(const std::vector<ErrorTimePoint>& points);

}  // namespace cousin
