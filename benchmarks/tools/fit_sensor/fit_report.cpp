#include "benchmarks/tools/fit_sensor/fit_report.h"

#include <cmath>
#include <numbers>

#include "benchmarks/report/report.h"
#include "benchmarks/score/distributions.h"
#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace {

PlotPoint point(double x, const Measured& m, double factor = 1) {
  const double half = kSigmas95 * m.sigma;
  return {x, {factor * m.value, factor * (m.value - half), factor * (m.value + half)}};
}

/// Places along the walls' distances, evenly in the logarithm.
std::vector<double> places(const DepthFit& d) {
  double least = d.reference_m, most = d.reference_m;
  for (const HeldOut& h : d.held_out) {
    least = std::min(least, h.depth_m);
    most = std::max(most, h.depth_m);
  }
  std::vector<double> z;
  constexpr int kPlaces = 40;
  for (int i = 0; i <= kPlaces; ++i)
    z.push_back(least * std::pow(most / least, static_cast<double>(i) / kPlaces));
  return z;
}

LinePlot sigma_plot(const DepthFit& d, const DepthGeometry& g) {
  LinePlot plot{
      "Noise of the depth over distance",
      {"Standard deviation of one frame's depth about the wall's plane, without ripple and "
       "rounding; bars are 95 % intervals. Stereo's law is a slope of 2."},
      "distance (m)",
      "sigma_Z (mm)",
      true,
      true,
      {}};
  LineSeries measured{"measured", {}, false, false}, law{"law", {}, true};
  for (const WallStatistics& w : d.walls) {
    if (w.problem.empty())
      measured.points.push_back(point(w.depth_m, w.sigma_px, 1000 * w.depth_m / w.disparity_px));
  }
  if (!d.held_out.empty()) {
    for (const double z : places(d)) law.points.push_back({z, {1000 * sigma_z_m(d, g, z)}});
  }
  plot.series = {std::move(measured), std::move(law)};
  return plot;
}

LinePlot noise_plot(const DepthFit& d) {
  LinePlot plot{"What stays and what changes from frame to frame",
                {"Disparity's noise: spatial is fixed while scene and camera stand and does not "
                 "average out; temporal does. Lines are the power laws."},
                "distance (m)",
                "noise of the disparity (px)",
                true,
                true,
                {}};
  LineSeries spatial{"spatial", {}, false, false}, temporal{"temporal", {}, false, false},
      spatial_law{"spatial, law", {}, true}, temporal_law{"temporal, law", {}, true};
  for (const WallStatistics& w : d.walls) {
    if (!w.problem.empty()) continue;
    spatial.points.push_back(point(w.depth_m, w.spatial_px));
    temporal.points.push_back(point(w.depth_m, w.temporal_px));
  }
  if (!d.held_out.empty()) {
    for (const double z : places(d)) {
      spatial_law.points.push_back({z, {value_at(d.spatial, z)}});
      if (d.temporal_solved) temporal_law.points.push_back({z, {value_at(d.temporal, z)}});
    }
  }
  plot.series = {std::move(spatial), std::move(temporal), std::move(spatial_law),
                 std::move(temporal_law)};
  return plot;
}

LinePlot fill_plot(const DepthFit& d) {
  LinePlot plot{"Fill over distance",
                {"Share of pixels and frames with a depth."},
                "distance (m)",
                "fill (%)",
                false,
                false,
                {}};
  LineSeries fill{"measured", {}, false, false};
  for (const WallStatistics& w : d.walls) {
    if (w.depth_m > 0) fill.points.push_back(point(w.depth_m, w.fill, 100));
  }
  plot.series = {std::move(fill)};
  return plot;
}

LinePlot ripple_plot(const DepthFit& d) {
  LinePlot plot{
      "Sub-pixel ripple",
      {"Mean error of the disparity over the fraction of the disparity, all walls; the line "
       "is the fitted sine."},
      "fraction of the disparity (px)",
      "error (px)",
      false,
      false,
      {}};
  LineSeries measured{"measured", {}, false, false}, sine{"fitted", {}, true};
  std::vector<RippleBin> bins(kRippleBins);
  for (const WallStatistics& w : d.walls) {
    for (std::size_t i = 0; i < w.ripple_bins.size() && w.problem.empty(); ++i) {
      bins[i].sum_px += w.ripple_bins[i].sum_px;
      bins[i].pixels += w.ripple_bins[i].pixels;
    }
  }
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const double x = (static_cast<double>(i) + 0.5) / kRippleBins;
    if (bins[i].pixels > 0) measured.points.push_back({x, {bins[i].sum_px / bins[i].pixels}});
    if (d.ripple_solved)
      sine.points.push_back(
          {x, {d.ripple_px.value * std::sin(2 * std::numbers::pi * x + d.ripple_phase_rad)}});
  }
  plot.series = {std::move(measured), std::move(sine)};
  return plot;
}

LinePlot transfer_plot(const GainFit& g) {
  LinePlot plot{
      "Photon transfer",
      {"Half the variance of the difference of two frames over their mean above black; the "
       "slope is the gain K, the intercept the read noise."},
      "mean above black (codes)",
      "variance (codes²)",
      false,
      false,
      {}};
  LineSeries used{"used", {}, false, false}, left{"left out", {}, false, false},
      line{"line", {}, true};
  double most = 0;
  const auto add = [&](const FlatLevel& l) {
    (l.left_out.empty() ? used : left).points.push_back(point(l.mean - g.black_code, l.variance));
    if (l.left_out.empty()) most = std::max(most, l.mean - g.black_code);
  };
  add(g.dark);
  for (const FlatLevel& l : g.flats) add(l);
  if (g.degrees > 0) {
    const double k = g.gain.value;
    const double read = g.read_noise_solved ? k * g.read_noise_e.value : 0;
    for (const double x : {0.0, most}) line.points.push_back({x, {k * x + read * read + 1.0 / 12}});
  }
  plot.series = {std::move(used), std::move(line)};
  if (!left.points.empty()) plot.series.push_back(std::move(left));
  return plot;
}

void add_headlines(const SensorFit& fit, ReportInput& input) {
  const auto add = [&](const std::string& label, const WithInterval& v, const std::string& unit,
                       bool is_solved) {
    if (is_solved) input.headlines.push_back({label, v, unit, "", ScoreStatus::ok, ""});
  };
  if (fit.depth && !fit.depth->held_out.empty()) {
    const DepthFit& d = *fit.depth;
    const bool ok = d.problems.empty();
    add("sigma_d of a frame", d.sigma_d_px, "px", ok);
    add("exponent of sigma_Z", d.sigma_z_exponent, "1", true);
    add("ripple", d.ripple_px, "px", ok && d.ripple_solved);
    input.headlines.push_back(
        {"held-out sigma_Z, RMS off",
         {.value = d.held_out_rms},
         "%",
         "at most 10 %",
         d.held_out_rms <= kHeldOutLimit ? ScoreStatus::pass : ScoreStatus::fail,
         ""});
  }
  if (fit.gain && fit.gain->problems.empty()) {
    add("gain K", fit.gain->gain, "DN/e", true);
    add("read noise", fit.gain->read_noise_e, "e", fit.gain->read_noise_solved);
  }
}

}  // namespace

void write_fit_report(const std::filesystem::path& file, const SensorFit& fit,
                      const ScoreFile& scores, const std::string& command_line) {
  ReportInput input;
  input.title = "Cousin: fit-sensor, rig " + fit.rig;
  input.summary =
      "Fitted to " + fit.data +
      ". Intervals are of 95 %, from covariances: numbers of a wall from tiles of its image, laws "
      "from the walls. Agreement with the camera's own recordings, not accuracy: nobody measured "
      "the wall by other means than the stated distances.";
  if (!command_line.empty()) input.commands = {command_line};
  input.config_toml = fit.preset_toml;
  input.scores = scores;
  for (const std::string& problem : fit.problems) input.notes.push_back("Rejected: " + problem);
  add_headlines(fit, input);
  if (fit.depth) {
    input.lines = {sigma_plot(*fit.depth, fit.geometry), noise_plot(*fit.depth),
                   fill_plot(*fit.depth), ripple_plot(*fit.depth)};
  }
  if (fit.gain) input.lines.push_back(transfer_plot(*fit.gain));
  write_file(file, make_report(input));
}

}  // namespace cousin
