#include "benchmarks/report/report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/report/html.h"
#include "benchmarks/report/javascript_libraries.h"
#include "benchmarks/report/plots.h"
#include "benchmarks/report/report_assets.h"
#include "benchmarks/report/shape_json.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/report/verdict.h"

namespace cousin {
namespace {

/// The page as it grows. Plots and shapes get numbers; their data stands beside them in script
/// elements.
struct Page {
  Html html;
  std::vector<std::pair<std::string, std::string>> sections;  ///< id, title: the page's navigation
  int plots = 0;
  int shapes = 0;
};

void open_section(Page& page, const std::string& id, const std::string& title) {
  page.sections.emplace_back(id, title);
  page.html += "<h2 id=\"" + html_text(id) + "\">" + html_text(title) + "</h2>\n";
}

Html data_script(const std::string& id, const nlohmann::ordered_json& json) {
  return "<script type=\"application/json\" id=\"" + html_text(id) + "\">" + html_json(json) +
         "</script>\n";
}

void add_plot(Page& page, const Plot& plot) {
  const std::string id = "plot-" + std::to_string(page.plots++);
  page.html += "<section><h3>" + html_text(plot.title) + "</h3><div class=\"plot\" data-spec=\"" +
               html_text(id) + "\"></div>";
  for (const std::string& line : plot.caption)
    page.html += "<p class=\"caption\">" + html_text(line) + "</p>";
  page.html += "</section>\n" + data_script(id, plot.spec);
}

void add_plots(Page& page, const std::string& id, const std::string& title,
               const std::vector<Plot>& plots, bool wide) {
  if (plots.empty()) return;
  open_section(page, id, title);
  page.html += wide ? Markup("<div class=\"plots wide\">\n") : Markup("<div class=\"plots\">\n");
  for (const Plot& plot : plots) add_plot(page, plot);
  page.html += "</div>\n";
}

Html number_cell(std::string_view text) {
  return "<td class=\"number\">" + html_text(text) + "</td>";
}
Html status_class(ScoreStatus status) { return html_text(to_string(status)); }
Html text_cell(std::string_view text) { return "<td>" + html_text(text) + "</td>"; }

/// More than these would push the plots off the screen: only those that failed come first.
constexpr std::size_t kOpenTiles = 12;

bool failed(const Headline& headline) {
  return headline.status != ScoreStatus::ok && headline.status != ScoreStatus::pass;
}

void add_headlines(Page& page, const std::vector<Headline>& headlines) {
  if (headlines.empty()) return;
  page.html += "<div class=\"tiles\">\n";
  for (const Headline& h : headlines) {
    const ShownUnit unit = shown_unit(h.unit, h.label);
    const Html status = status_class(h.status);
    page.html += "<div class=\"tile " + status + "\"><div class=\"muted\">" + html_text(h.label) +
                 "</div><div class=\"value\">" +
                 html_text(shown_precisely(unit.factor * h.value.value)) + " <small>" +
                 html_text(unit.name);
    if (std::isfinite(h.value.low) && std::isfinite(h.value.high)) {
      page.html += html_text(" [" + shown_precisely(unit.factor * h.value.low) + ", " +
                             shown_precisely(unit.factor * h.value.high) + "]");
    }
    page.html += "</small></div>";
    if (!h.limit.empty() || h.status != ScoreStatus::ok) {
      page.html += "<div class=\"muted\">" + html_text(h.limit) + " <span class=\"status " +
                   status + "\">" + (h.status == ScoreStatus::ok ? Html() : status) +
                   "</span></div>";
    }
    page.html += "</div>\n";
  }
  page.html += "</div>\n";
}

void add_folded_headlines(Page& page, const std::vector<Headline>& headlines) {
  page.html += "<details class=\"numbers\"><summary>All " +
               html_text(std::to_string(headlines.size())) + " numbers as cards</summary>\n";
  add_headlines(page, headlines);
  page.html += "</details>\n";
}

/// A line a label, a column a group, both in the order of first appearance.
void add_limits(Page& page, const std::vector<Headline>& limits) {
  if (limits.empty()) return;
  std::vector<std::string> labels, groups;
  const auto note = [](std::vector<std::string>& names, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  int passed = 0;
  for (const Headline& h : limits) {
    note(labels, h.label);
    note(groups, h.group);
    passed += h.status == ScoreStatus::pass ? 1 : 0;
  }
  open_section(page, "limits", "Held against limits");
  page.html += "<p>" + html_text(std::to_string(passed) + " of " + std::to_string(limits.size())) +
               " numbers keep their limit.</p>\n<div class=\"scroll whole\"><table "
               "id=\"limit-table\"><thead><tr><th></th>";
  for (const std::string& group : groups)
    page.html += "<th class=\"number\">" + html_text(group) + "</th>";
  page.html += "</tr></thead><tbody>\n";
  for (const std::string& label : labels) {
    page.html += "<tr>" + text_cell(label);
    for (const std::string& group : groups) {
      const auto h = std::find_if(limits.begin(), limits.end(), [&](const Headline& l) {
        return l.label == label && l.group == group;
      });
      if (h == limits.end()) {
        page.html += "<td></td>";
        continue;
      }
      const ShownUnit unit = shown_unit(h->unit, h->label);
      const Html status = status_class(h->status);
      page.html += "<td class=\"number\">" +
                   html_text(shown_number(unit.factor * h->value.value) + " " + unit.name) +
                   "<br><span class=\"muted\">" + html_text(h->limit) +
                   "</span> <span class=\"status " + status + "\">" + status + "</span></td>";
    }
    page.html += "</tr>\n";
  }
  page.html += "</tbody></table></div>\n";
}

void add_tables(Page& page, const std::vector<ReportTable>& tables) {
  if (tables.empty()) return;
  open_section(page, "tables", "Tables");
  for (const ReportTable& table : tables) {
    page.html += "<h3>" + html_text(table.title) + "</h3>\n";
    if (!table.caption.empty())
      page.html += "<p class=\"caption\">" + html_text(table.caption) + "</p>\n";
    page.html += "<div class=\"scroll whole\"><table><thead><tr>";
    for (const std::string& column : table.columns)
      page.html += "<th>" + html_text(column) + "</th>";
    page.html += "</tr></thead><tbody>\n";
    for (const auto& line : table.lines) {
      page.html += "<tr>";
      for (const std::string& cell : line) page.html += text_cell(cell);
      page.html += "</tr>\n";
    }
    page.html += "</tbody></table></div>\n";
  }
}

void add_images(Page& page, const std::vector<ReportImage>& images) {
  if (images.empty()) return;
  open_section(page, "images", "Images");
  page.html += "<div class=\"images\">\n";
  for (const ReportImage& image : images) {
    const bool is_jpeg = image.png.size() > 2 && image.png[0] == 0xff && image.png[1] == 0xd8;
    page.html += "<figure><img alt=\"" + html_text(image.name) + "\" src=\"data:image/" +
                 (is_jpeg ? Markup("jpeg") : Markup("png")) + ";base64," + html_base64(image.png) +
                 "\"><figcaption><b>" + html_text(image.name) + "</b> " + html_text(image.caption) +
                 "</figcaption></figure>\n";
  }
  page.html += "</div>\n";
}

void add_shapes(Page& page, const std::vector<ReportShape>& shapes, int max_points) {
  const bool any = std::any_of(shapes.begin(), shapes.end(),
                               [](const auto& s) { return !s.positions_m.empty(); });
  if (!any) return;
  open_section(page, "shapes", "Shapes to turn");
  page.html += "<div class=\"plots\">\n";
  for (const ReportShape& given : shapes) {
    validate(given);
    if (given.positions_m.empty()) continue;
    const ReportShape shape = thinned(given, max_points);
    const std::string id = "shape-" + std::to_string(page.shapes++);
    page.html +=
        "<section><h3>" + html_text(shape.name) + "</h3><div class=\"shape\" data-shape=\"" +
        html_text(id) +
        "\"><div class=\"hint\">drag to turn, wheel to zoom</div></div><p class=\"caption\">" +
        html_text(shape.caption) + "</p></section>\n" + data_script(id, shape_json(shape));
  }
  page.html += "</div>\n";
}

void add_score_table(Page& page, const std::vector<ScoreRow>& rows) {
  if (rows.empty()) return;
  open_section(page, "scores", "Scores");
  page.html +=
      "<input type=\"search\" placeholder=\"Filter: words that a row must have\" "
      "aria-label=\"Filter the scores\" "
      "data-filters=\"score-table\">\n<div class=\"scroll\"><table "
      "id=\"score-table\"><thead><tr><th>suite</th><th>scene</th>"
      "<th>case</th><th>method</th><th>metric</th><th class=\"number\">value</th><th "
      "class=\"number\">95 % interval</th><th>unit</th>"
      "<th class=\"number\">n</th><th class=\"number\">wall s</th><th class=\"number\">peak "
      "MB</th><th>status</th></tr></thead><tbody>\n";
  for (const ScoreRow& row : rows) {
    const ShownUnit unit = shown_unit(row.unit, row.metric);
    const bool has_interval = std::isfinite(row.ci_low) && std::isfinite(row.ci_high);
    const Html status = status_class(row.status);
    page.html += "<tr>" + text_cell(row.suite) + text_cell(row.scene) + text_cell(row.case_name) +
                 text_cell(row.method) + text_cell(row.metric) +
                 number_cell(shown_number(unit.factor * row.value)) +
                 number_cell(has_interval ? shown_number(unit.factor * row.ci_low) + " … " +
                                                shown_number(unit.factor * row.ci_high)
                                          : "") +
                 text_cell(unit.name) + number_cell(std::to_string(row.n)) +
                 number_cell(std::isnan(row.wall_s) ? "" : shown_number(row.wall_s)) +
                 number_cell(std::isnan(row.peak_rss_mb) ? "" : shown_number(row.peak_rss_mb)) +
                 "<td class=\"status " + status + "\">" + status + "</td></tr>\n";
  }
  page.html += "</tbody></table></div>\n";
}

Html download(Markup file, Markup type, std::string_view bytes) {
  return "<a download=\"" + Html(file) + "\" href=\"data:" + type + ";base64," +
         html_base64(bytes) + "\">" + file + "</a>";
}

void add_sources(Page& page, const ReportInput& input) {
  open_section(page, "sources", "How this was made");
  if (!input.commands.empty()) {
    page.html += "<pre>";
    for (const std::string& command : input.commands) page.html += html_text(command) + "\n";
    page.html += "</pre>\n";
  }
  const ScoreHeader& header = input.scores.header;
  std::vector<std::pair<std::string, std::string>> facts = {{"program", header.program_version},
                                                            {"dataset", header.dataset_hash},
                                                            {"configuration", header.config_hash},
                                                            {"machine", header.machine}};
  facts.insert(facts.end(), header.more.begin(), header.more.end());
  page.html += "<dl>";
  for (const auto& [name, text] : facts) {
    if (!text.empty())
      page.html += "<dt>" + html_text(name) + "</dt><dd>" + html_text(text) + "</dd>";
  }
  page.html +=
      "</dl>\n<p>Data: " + download("scores.csv", "text/csv", to_csv(input.scores.scores)) + " · " +
      download("specimens.csv", "text/csv", to_csv(input.scores.specimens)) + " · " +
      download("scores.json", "application/json", to_json(input.scores)) + "</p>\n";
  if (!input.plan.empty())
    page.html += "<details><summary>Plan: what ran, what was left out, and why</summary><pre>" +
                 html_text(input.plan) + "</pre></details>\n";
  if (!input.config_toml.empty()) {
    page.html += "<details><summary>Configuration</summary><pre>" + html_text(input.config_toml) +
                 "</pre></details>\n";
  }
}

Html navigation(const Page& page) {
  Html html("<nav>");
  for (const auto& [id, title] : page.sections)
    html += "<a href=\"#" + html_text(id) + "\">" + html_text(title) + "</a>";
  return html + "</nav>";
}

void validate(const ReportInput& input) {
  for (const ErrorTimeCurve& curve : input.curves) {
    for (const ErrorTimePoint& point : curve.points) {
      if (point.wall_s > 0 && std::isfinite(point.wall_s)) continue;
      throw std::invalid_argument("report: curve \"" + curve.title + "\": time of \"" +
                                  point.setting + "\" is " + std::to_string(point.wall_s) +
                                  " s; it must be positive");
    }
  }
  for (const ReportTable& table : input.tables) {
    for (const auto& line : table.lines) {
      if (line.size() == table.columns.size()) continue;
      throw std::invalid_argument("report: table \"" + table.title + "\": a line has " +
                                  std::to_string(line.size()) + " cells, not " +
                                  std::to_string(table.columns.size()));
    }
  }
  for (const Distribution& distribution : input.distributions) {
    for (const DistributionGroup& group : distribution.groups) {
      if (std::all_of(group.values.begin(), group.values.end(),
                      [](double v) { return std::isfinite(v); }))
        continue;
      throw std::invalid_argument("report: distribution \"" + distribution.title +
                                  "\": a value of \"" + group.name + "\" is not finite");
    }
  }
}

/// A curve or waterfall can be drawn if one of its errors is a number (and, on a logarithmic axis,
/// positive).
bool can_draw(const ErrorTimeCurve& curve) {
  return std::any_of(curve.points.begin(), curve.points.end(),
                     [](const auto& p) { return p.error.value > 0; });
}
bool can_draw(const LinePlot& plot) {
  return std::any_of(plot.series.begin(), plot.series.end(),
                     [](const LineSeries& s) { return !s.is_law && !s.points.empty(); });
}
bool can_draw(const Distribution& distribution) {
  return std::any_of(distribution.groups.begin(), distribution.groups.end(),
                     [](const DistributionGroup& g) { return !g.values.empty(); });
}
bool can_draw(const Attribution& attribution) {
  return !attribution.steps.empty() &&
         std::all_of(attribution.steps.begin(), attribution.steps.end(),
                     [](const auto& s) { return std::isfinite(s.error.value); });
}

/// Sections of plots over one quantity, in the order in which they are first named.
void add_line_plots(Page& page, const std::vector<LinePlot>& lines) {
  std::vector<std::pair<std::string, std::vector<Plot>>> sections;
  for (const LinePlot& plot : lines) {
    if (!can_draw(plot)) continue;
    std::string name = plot.section;
    if (name.empty()) {
      const bool has_law = std::any_of(lines.begin(), lines.end(), [](const LinePlot& other) {
        return other.section.empty() &&
               std::any_of(other.series.begin(), other.series.end(),
                           [](const LineSeries& series) { return series.is_law; });
      });
      name = has_law ? "Against theory" : "Along one quantity";
    }
    auto section = std::find_if(sections.begin(), sections.end(),
                                [&](const auto& known) { return known.first == name; });
    if (section == sections.end()) section = sections.insert(sections.end(), {name, {}});
    section->second.push_back(line_plot(plot));
  }
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const std::string id = i == 0 ? "lines" : "lines-" + std::to_string(i + 1);
    add_plots(page, id, sections[i].first, sections[i].second, false);
  }
}

void add_notes(Page& page, const ReportInput& input, const JavascriptLibraries& libraries) {
  std::vector<std::string> notes = input.notes;
  if (!libraries.missing.empty()) {
    notes.push_back(
        "When this page was made, these files were missing, so plots or turning shapes are "
        "reduced: " +
        libraries.missing);
  }
  for (const std::string& note : notes)
    page.html += "<p class=\"note\">" + html_text(note) + "</p>\n";
}

void add_all_plots(Page& page, const ReportInput& input) {
  add_plots(page, "traits", "Measured against true", scatter_plots(input.plotted), false);
  add_plots(page, "errors", "Distribution of errors", error_histograms(input.plotted), false);
  std::vector<Plot> plots;
  for (const Distribution& distribution : input.distributions) {
    if (can_draw(distribution)) plots.push_back(distribution_plot(distribution));
  }
  add_plots(page, "distributions", "Distributions", plots, true);
  add_line_plots(page, input.lines);
  plots.clear();
  for (const Attribution& attribution : input.attributions) {
    if (can_draw(attribution)) plots.push_back(waterfall_plot(attribution));
  }
  add_plots(page, "attribution", "Where the error comes from", plots, true);
  plots.clear();
  for (const ErrorTimeCurve& curve : input.curves) {
    if (can_draw(curve)) plots.push_back(error_time_plot(curve));
  }
  add_plots(page, "time", "Error against run time", plots, true);
  if (!input.timings.empty())
    add_plots(page, "stages", "Run time", {timing_plot(input.timings)}, true);
}

/// The whole file around the page's body.
std::string whole_page(const Page& page, const ReportInput& input,
                       const JavascriptLibraries& libraries) {
  Html html(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>");
  html += html_text(input.title) + "</title>\n<link rel=\"icon\" href=\"data:,\">\n" +
          html_style(kReportCss) + html_script(kErrorsJs) +
          "</head>\n<body>\n<main>\n<header class=\"page\"><div><h1>" + html_text(input.title) +
          "</h1>";
  if (const std::string first = verdict(input.scores); !first.empty())
    html += "<p class=\"verdict\">" + html_text(first) + "</p>";
  if (!input.summary.empty()) html += "<p>" + html_text(input.summary) + "</p>";
  html += navigation(page) + "</div><button id=\"theme\">Dark</button></header>\n" + page.html +
          "</main>\n";
  for (const std::string& script : {libraries.vega, libraries.three, std::string(kView3dJs),
                                    std::string(kSplats3dJs), std::string(kReportJs)}) {
    if (!script.empty()) html += html_script(script + "\n");
  }
  html += "</body>\n</html>\n";
  return html.str();
}

}  // namespace

std::vector<bool> pareto_front(const std::vector<ErrorTimePoint>& points) {
  std::vector<bool> front(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ErrorTimePoint& p = points[i];
    front[i] = !std::isnan(p.error.value) &&
               std::none_of(points.begin(), points.end(), [&](const ErrorTimePoint& q) {
                 return q.wall_s <= p.wall_s && q.error.value <= p.error.value &&
                        (q.wall_s < p.wall_s || q.error.value < p.error.value);
               });
  }
  return front;
}

std::string make_report(const ReportInput& input, const ReportConfig& config) {
  validate(input);
  const JavascriptLibraries libraries = load_javascript_libraries(config.javascript);

  Page page;
  const bool has_plots = !input.lines.empty() || !input.curves.empty() ||
                         !input.distributions.empty() || !input.plotted.empty();
  const bool folds = has_plots && input.headlines.size() > kOpenTiles;
  std::vector<Headline> first = input.headlines;
  if (folds) std::erase_if(first, [](const Headline& h) { return !failed(h); });
  add_headlines(page, first);
  add_notes(page, input, libraries);
  add_limits(page, input.limits);
  add_tables(page, input.tables);
  add_images(page, input.images);
  add_shapes(page, input.shapes, config.max_points);
  add_all_plots(page, input);
  if (folds) add_folded_headlines(page, input.headlines);
  add_score_table(page, input.scores.scores);
  add_sources(page, input);
  return whole_page(page, input, libraries);
}

}  // namespace cousin
