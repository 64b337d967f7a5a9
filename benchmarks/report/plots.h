#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "benchmarks/report/report.h"

namespace cousin {

/// A Vega 5 specification and the words around it. Specifications take their ink from the signals
/// `ink`, `muted` and `grid`, which the page sets to its light or dark colours.
struct Plot {
  std::string title;
  std::vector<std::string> caption;  ///< lines
  nlohmann::ordered_json spec;
};

/// Measured over true with the line of equality, one plot a trait in the order of first appearance;
/// bars are 95 % intervals of the reported sigmas. Traits without a solved specimen are left out.
std::vector<Plot> scatter_plots(const std::vector<SpecimenRow>& rows);
/// Histogram of measured - true, one plot a trait.
std::vector<Plot> error_histograms(const std::vector<SpecimenRow>& rows);
/// Histograms of groups, one below the other over the same axis.
Plot distribution_plot(const Distribution& distribution);
/// Error over seconds, both logarithmic, with intervals and the Pareto front.
Plot error_time_plot(const ErrorTimeCurve& curve);
/// Series over x with intervals; laws are dashed. Points that an axis cannot show are left out.
Plot line_plot(const LinePlot& plot);
/// Error left after each seam, as bars that hang between successive levels.
Plot waterfall_plot(const Attribution& attribution);
/// Seconds of each stage: wall and CPU.
Plot timing_plot(const std::vector<StageTiming>& timings);

}  // namespace cousin
