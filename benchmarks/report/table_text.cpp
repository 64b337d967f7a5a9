#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "benchmarks/report/report.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

/// Characters of a text in UTF-8.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

std::string line_text(const std::vector<std::string>& cells,
                      const std::vector<std::size_t>& widths) {
  std::string text;
  for (std::size_t i = 0; i < cells.size() && i < widths.size(); ++i) {
    if (i > 0) text += "  ";
    text += cells[i];
    if (i + 1 < cells.size()) text += std::string(widths[i] - width_of(cells[i]), ' ');
  }
  return text + "\n";
}

}  // namespace

std::string table_cell(double value, double factor, int decimals) {
  if (!std::isfinite(value)) return {};
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, factor * value);
  return text;
}

std::string table_cell(const ScoreRow* row, double factor, int decimals) {
  return row == nullptr ? std::string() : table_cell(row->value, factor, decimals);
}

std::string table_text(const ReportTable& given) {
  ReportTable table = given;
  for (auto& line : table.lines) {
    for (std::string& cell : line) cell = terminal_text(cell);
  }
  std::vector<std::size_t> widths;
  for (const std::string& column : table.columns) widths.push_back(width_of(column));
  for (const auto& line : table.lines) {
    for (std::size_t i = 0; i < line.size() && i < widths.size(); ++i)
      widths[i] = std::max(widths[i], width_of(line[i]));
  }
  std::string text = table.title + "\n";
  if (!table.caption.empty()) text += table.caption + "\n";
  text += line_text(table.columns, widths);
  for (const auto& line : table.lines) text += line_text(line, widths);
  return text;
}

}  // namespace cousin
