#include "benchmarks/loop/results_index.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "benchmarks/report/html.h"
#include "benchmarks/score/scores.h"
#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr const char* kAbout = "about.md";
constexpr const char* kTable = "scores.csv";

constexpr std::size_t kMostCharacters = 160;  ///< of a cell

/// Up to the first empty line, as one line. A long one is cut between words.
std::string first_paragraph(const std::string& text) {
  std::string paragraph = text.substr(0, text.find("\n\n"));
  std::replace(paragraph.begin(), paragraph.end(), '\n', ' ');
  while (!paragraph.empty() && paragraph.back() == ' ') paragraph.pop_back();
  if (paragraph.size() <= kMostCharacters) return paragraph;
  paragraph.erase(paragraph.find_last_of(" ,", kMostCharacters));
  const bool is_code_open = std::count(paragraph.begin(), paragraph.end(), '`') % 2 == 1;
  return paragraph + (is_code_open ? " …`" : " …");
}

KeptResults read_results(const fs::path& folder) {
  KeptResults results;
  results.name = folder.filename().string();
  if (fs::exists(folder / kAbout)) results.made_by = first_paragraph(read_file(folder / kAbout));
  const fs::path table = folder / kTable;
  for (const ScoreRow& row : scores_from_csv(read_file(table), table.string())) {
    ++results.rows;
    if (row.status == ScoreStatus::pass) ++results.kept;
    if (row.status == ScoreStatus::fail) ++results.broken;
    if (row.status == ScoreStatus::not_solved || row.status == ScoreStatus::not_built ||
        row.status == ScoreStatus::error)
      ++results.unsolved;
  }
  return results;
}

/// In a cell of a table: no bar ends it.
std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2))
    text.insert(at, "\\");
  return text;
}

std::string limits_text(const KeptResults& results) {
  const std::int64_t all = results.kept + results.broken;
  return all == 0 ? "none" : std::to_string(results.kept) + " of " + std::to_string(all);
}

}  // namespace

std::vector<KeptResults> kept_results(const fs::path& folder) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && fs::is_regular_file(entry.path() / kTable))
      folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  std::vector<KeptResults> results;
  for (const fs::path& each : folders) results.push_back(read_results(each));
  return results;
}

std::string results_index(const std::vector<KeptResults>& results) {
  std::int64_t kept = 0, broken = 0;
  for (const KeptResults& each : results) {
    kept += each.kept;
    broken += each.broken;
  }
  std::string text = "# Results kept\n\n" + std::to_string(kept) + " of " +
                     std::to_string(kept + broken) + " limits are kept in " +
                     std::to_string(results.size()) +
                     " folders. `cousin report` makes this page of their `scores.csv` and "
                     "`about.md`; what was found is in each `about.md`.\n\n"
                     "![Limits kept and not kept, a bar a folder](limits.svg)\n\n"
                     "| folder | made by | numbers | limits kept | not solved |\n"
                     "|---|---|---|---|---|\n";
  for (const KeptResults& each : results) {
    const std::string file = each.made_by.empty() ? kTable : kAbout;
    text += "| [" + cell(each.name) + "](" + each.name + "/" + file + ") | " + cell(each.made_by) +
            " | " + std::to_string(each.rows) + " | " + limits_text(each) + " | " +
            std::to_string(each.unsolved) + " |\n";
  }
  return text;
}

std::string results_plot(const std::vector<KeptResults>& results) {
  constexpr int kLine_px = 18, kNames_px = 170, kBars_px = 430, kTop_px = 26;
  std::int64_t most = 1;
  std::vector<const KeptResults*> shown;
  for (const KeptResults& each : results) {
    if (each.kept + each.broken == 0) continue;
    shown.push_back(&each);
    most = std::max(most, each.kept + each.broken);
  }
  // Suites have from three to hundreds of limits: bars grow with the logarithm.
  const auto width_px = [&](std::int64_t count) {
    return std::to_string(
        static_cast<int>(std::lround(kBars_px * std::log1p(static_cast<double>(count)) /
                                     std::log1p(static_cast<double>(most)))));
  };
  const int height_px = kTop_px + kLine_px * static_cast<int>(shown.size()) + 8;
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" +
                    std::to_string(kNames_px + kBars_px + 90) + "\" height=\"" +
                    std::to_string(height_px) +
                    "\" font-family=\"sans-serif\" font-size=\"12\">\n"
                    "<text x=\"" +
                    std::to_string(kNames_px) +
                    "\" y=\"16\">limits (logarithm of their number): kept, and in red not "
                    "kept</text>\n";
  int y_px = kTop_px;
  for (const KeptResults* const each : shown) {
    const std::string y = std::to_string(y_px), text_y = std::to_string(y_px + 12);
    const std::int64_t all = each->kept + each->broken;
    svg += "<text x=\"" + std::to_string(kNames_px - 6) + "\" y=\"" + text_y +
           "\" text-anchor=\"end\">" + html_text(each->name).str() + "</text>\n";
    const auto bar = [&](std::int64_t count, const char* color) {
      svg += "<rect x=\"" + std::to_string(kNames_px) + "\" y=\"" + y + "\" width=\"" +
             width_px(count) + "\" height=\"14\" fill=\"" + color + "\"/>\n";
    };
    bar(all, each->broken > 0 ? "#c0392b" : "#4a8f5d");
    if (each->broken > 0 && each->kept > 0) bar(each->kept, "#4a8f5d");
    svg += "<text x=\"" + std::to_string(kNames_px + std::stoi(width_px(all)) + 6) + "\" y=\"" +
           text_y + "\">" + limits_text(*each) + "</text>\n";
    y_px += kLine_px;
  }
  return svg + "</svg>\n";
}

}  // namespace cousin
