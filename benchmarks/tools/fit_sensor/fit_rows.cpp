#include "benchmarks/tools/fit_sensor/fit_rows.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "benchmarks/score/distributions.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...) {
  char out[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(out, sizeof out, format, arguments);
  va_end(arguments);
  return out;
}

WithInterval interval(const Measured& m) {
  return {m.value, m.value - kSigmas95 * m.sigma, m.value + kSigmas95 * m.sigma};
}
WithInterval log_interval(const PowerLaw& law) {
  const double half = kSigmas95 * std::sqrt(law.covariance(0, 0));
  return {std::exp(law.log_value), std::exp(law.log_value - half), std::exp(law.log_value + half)};
}
WithInterval exponent_of(const PowerLaw& law) {
  const double half = kSigmas95 * std::sqrt(law.covariance(1, 1));
  return {law.exponent, law.exponent - half, law.exponent + half};
}

/// Rows of one fit, with what they have in common.
class Rows {
 public:
  explicit Rows(const std::string& rig) : rig_(rig) {}

  void add(const std::string& case_name, const std::string& metric, const WithInterval& v,
           const std::string& unit, std::int64_t n, bool is_solved = true) {
    ScoreRow row;
    row.suite = "fit-sensor";
    row.scene = rig_;
    row.case_name = case_name;
    row.method = "fit";
    row.metric = metric;
    row.unit = unit;
    row.n = n;
    row.value = v.value;
    row.ci_low = v.low;
    row.ci_high = v.high;
    if (!is_solved) {
      row.value = row.ci_low = row.ci_high = ScoreRow::kNone;
      row.status = ScoreStatus::not_solved;
    }
    rows.push_back(std::move(row));
  }
  void add(const std::string& case_name, const std::string& metric, double value,
           const std::string& unit, std::int64_t n, bool is_solved = true) {
    add(case_name, metric, WithInterval{.value = value}, unit, n, is_solved);
  }
  std::vector<ScoreRow> rows;

 private:
  std::string rig_;
};

void add_wall(const WallStatistics& w, Rows& out) {
  const bool ok = w.problem.empty();
  const std::string name = ok ? w.name : w.name + " (left out: " + w.problem + ")";
  out.add(name, "distance_stated", w.distance_m, "m", 1);
  out.add(name, "depth", w.depth_m, "m", w.pixels, w.depth_m > 0);
  out.add(name, "incidence", w.incidence_rad, "rad", w.pixels, w.depth_m > 0);
  out.add(name, "fill", interval(w.fill), "1", w.tiles);
  out.add(name, "wrong", w.wrong, "1", w.pixels);
  const double to_depth = w.disparity_px > 0 ? w.depth_m / w.disparity_px : 0;
  const WithInterval z = interval({w.sigma_px.value * to_depth, w.sigma_px.sigma * to_depth});
  out.add(name, "sigma_z", z, "m", w.tiles, ok);
  out.add(name, "sigma_d", interval(w.sigma_px), "px", w.tiles, ok);
  out.add(name, "spatial_d", interval(w.spatial_px), "px", w.tiles, ok);
  out.add(name, "temporal_d", interval(w.temporal_px), "px", w.tiles, ok);
  out.add(name, "depth_step_d", w.quantum_px, "px", 1, w.depth_m > 0);
  out.add(name, "drift_d", w.drift_px, "px", w.frames, w.depth_m > 0);
  out.add(name, "bend_d", w.bend_px, "px", w.tiles, ok);
}

void add_depth(const DepthFit& d, bool is_solved, Rows& out) {
  const auto n = static_cast<std::int64_t>(d.held_out.size());
  const std::string name = text("depth, laws at %.2f m", d.reference_m);
  if (n > 0) {
    out.add(name, "sigma_d", d.sigma_d_px, "px", n, is_solved);
    out.add(name, "sigma_z_exponent", d.sigma_z_exponent, "1", n);
    out.add(name, "spatial_d", log_interval(d.spatial), "px", n, is_solved);
    out.add(name, "spatial_d_exponent", exponent_of(d.spatial), "1", n, is_solved);
    const bool temporal = is_solved && d.temporal_solved;
    out.add(name, "temporal_d", log_interval(d.temporal), "px", n, temporal);
    out.add(name, "temporal_d_exponent", exponent_of(d.temporal), "1", n, temporal);
    out.add(name, "ripple_d", d.ripple_px, "px", n, is_solved && d.ripple_solved);
    out.add(name, "ripple_phase", d.ripple_phase_rad, "rad", n, is_solved && d.ripple_solved);
    out.add(name, "bias_d", d.bias_px, "px", n, is_solved && d.bias_solved);
    out.add(name, "disparity_scale", d.scale, "1", n);
    out.add(name, "stated_distances_p", d.distance_p, "1", n);
    out.add(name, "chi_square", d.chi2, "1", d.degrees);
    out.add(name, "chi_square_p", d.p, "1", d.degrees);
    out.add(name, "held_out_rms", d.held_out_rms, "1", n);
  }
  for (const HeldOut& h : d.held_out) {
    const double half = kSigmas95 * h.sigma;
    out.add(h.wall, "held_out_sigma_ratio",
            {h.ratio, h.ratio * std::exp(-half), h.ratio * std::exp(half)}, "1", n - 1);
  }
  for (const WallStatistics& w : d.walls) add_wall(w, out);
}

void add_gain(const GainFit& g, Rows& out) {
  const bool is_solved = g.problems.empty();
  const auto n = static_cast<std::int64_t>(g.degrees + 2);
  out.add("colour", "gain", g.gain, "DN/e", n, is_solved);
  out.add("colour", "read_noise", g.read_noise_e, "e", n, is_solved && g.read_noise_solved);
  out.add("colour", "black_level", g.black_code, "DN", 1);
  out.add("colour", "chi_square", g.chi2, "1", g.degrees, g.degrees > 0);
  out.add("colour", "chi_square_p", g.p, "1", g.degrees, g.degrees > 0);
  const auto level = [&](const FlatLevel& l) {
    const std::string name =
        l.left_out.empty() ? l.name : l.name + " (left out: " + l.left_out + ")";
    out.add(name, "mean", l.mean, "DN", 1);
    out.add(name, "variance", interval(l.variance), "DN2", 1);
    out.add(name, "saturated", l.saturated, "1", 1);
  };
  level(g.dark);
  for (const FlatLevel& l : g.flats) level(l);
}

std::string shown(const WithInterval& v, const char* unit) {
  return text("%9.4g [%.4g, %.4g] %s", v.value, v.low, v.high, unit);
}

std::string depth_table(const DepthFit& d) {
  std::string out;
  if (!d.held_out.empty()) {
    out += text("sigma_d at %.2f m      ", d.reference_m) + shown(d.sigma_d_px, "px") + "\n";
    out += "exponent of sigma_Z    " + shown(d.sigma_z_exponent, "") + "\n";
    out += "spatial sigma_d        " + shown(log_interval(d.spatial), "px, times Z^") +
           text("%.3f\n", d.spatial.exponent);
    out += "temporal sigma_d       " + (d.temporal_solved
                                            ? shown(log_interval(d.temporal), "px, times Z^") +
                                                  text("%.3f\n", d.temporal.exponent)
                                            : "not solved: hidden by the depth's steps\n");
    out += "ripple                 " +
           (d.ripple_solved ? shown(d.ripple_px, "px\n")
                            : "not solved: turn the wall, so that disparities span a pixel\n");
    out += "bias of the disparity  " + (d.bias_solved
                                            ? shown(d.bias_px, "px\n")
                                            : "not solved: the stated distances are too coarse\n");
    out += text("law                    chi-square %.1f of %d, p = %.2g; held out: %.1f %% RMS\n\n",
                d.chi2, d.degrees, d.p, 100 * d.held_out_rms);
  }
  out +=
      "wall                     depth m   fill %   sigma_Z mm   sigma_d px  spatial  temporal  "
      "held-out ratio\n";
  for (const WallStatistics& w : d.walls) {
    const double z_mm =
        w.disparity_px > 0 ? 1000 * w.sigma_px.value * w.depth_m / w.disparity_px : 0;
    out += text("%-24s %7.3f  %7.2f  %11.3f  %11.4f  %7.4f  %8.4f", terminal_text(w.name).c_str(),
                w.depth_m, 100 * w.fill.value, z_mm, w.sigma_px.value, w.spatial_px.value,
                w.temporal_px.value);
    for (const HeldOut& h : d.held_out) {
      if (h.wall == w.name) out += text("  %14.3f", h.ratio);
    }
    out += w.problem.empty() ? "\n" : "  left out: " + terminal_text(w.problem) + "\n";
  }
  return out + "\n";
}

std::string gain_table(const GainFit& g) {
  std::string out = "gain K                 " + shown(g.gain, "codes an electron\n");
  out += "read noise             " + (g.read_noise_solved
                                          ? shown(g.read_noise_e, "electrons\n")
                                          : "not solved: below the rounding to codes\n");
  out += text("line                   chi-square %.1f of %d, p = %.2g\n", g.chi2, g.degrees, g.p);
  out += "field                        mean DN    variance DN2\n";
  const auto row = [&](const FlatLevel& l) {
    out += text("%-24s %11.2f  %14.3f", terminal_text(l.name).c_str(), l.mean, l.variance.value);
    out += l.left_out.empty() ? "\n" : "  left out: " + terminal_text(l.left_out) + "\n";
  };
  row(g.dark);
  for (const FlatLevel& l : g.flats) row(l);
  return out + "\n";
}

}  // namespace

ScoreFile fit_rows(const SensorFit& fit) {
  Rows out(fit.rig);
  ScoreFile file;
  out.add("verdict", "solved", fit.problems.empty() ? 1 : 0, "1", 1);
  if (!fit.problems.empty()) out.rows.back().status = ScoreStatus::not_solved;
  if (fit.depth) add_depth(*fit.depth, fit.depth->problems.empty(), out);
  if (fit.gain) add_gain(*fit.gain, out);
  file.scores = std::move(out.rows);
  file.header.more["verdict"] = fit.problems.empty() ? "solved" : "rejected";
  file.header.more["data"] = fit.data;
  for (std::size_t i = 0; i < fit.problems.size(); ++i)
    file.header.more["problem_" + std::to_string(i + 1)] = fit.problems[i];
  return file;
}

std::string fit_table(const SensorFit& fit) {
  std::string out = "rig " + terminal_text(fit.rig) + ", " + terminal_text(fit.data) +
                    "; intervals are of 95 %\n\n";
  if (fit.depth) out += depth_table(*fit.depth);
  if (fit.gain) out += gain_table(*fit.gain);
  if (fit.problems.empty()) return out + "verdict: solved\n";
  out += "verdict: rejected, no preset is written\n";
  for (const std::string& p : fit.problems) out += "  " + terminal_text(p) + "\n";
  return out;
}

}  // namespace cousin
