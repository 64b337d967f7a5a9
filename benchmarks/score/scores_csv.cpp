#include <charconv>
#include <cmath>
#include <span>
#include <stdexcept>

#include "benchmarks/score/score_columns.h"
#include "benchmarks/score/scores.h"
#include "sim/types/utf8.h"

namespace cousin {

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"') result += '"';
    result += c;
  }
  return result + '"';
}

namespace {

constexpr std::size_t kMaxCell = 64 * 1024;

std::string shortest(double value) {
  if (std::isnan(value)) return "";
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value);
  return {buffer, end.ptr};
}

std::string cell_of(const std::string& value) { return csv_cell(value); }
std::string cell_of(double value) { return shortest(value); }
std::string cell_of(std::int64_t value) { return std::to_string(value); }
std::string cell_of(std::uint64_t value) { return std::to_string(value); }
std::string cell_of(ScoreStatus value) { return std::string(to_string(value)); }

template <class Row>
std::string write(std::span<const Row> rows, const std::vector<Column<Row>>& columns) {
  std::string text;
  for (const auto& column : columns) {
    if (!text.empty()) text += ',';
    text += column.name;
  }
  text += '\n';
  for (const Row& row : rows) {
    bool first = true;
    for (const auto& column : columns) {
      if (!first) text += ',';
      first = false;
      text += std::visit([&](auto member) { return cell_of(row.*member); }, column.member);
    }
    text += '\n';
  }
  return text;
}

template <class Number>
Number number_of(const std::string& cell) {
  Number value{};
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size()) {
    throw std::invalid_argument(std::string("\"") + cut_utf8(cell, 64) +
                                "\" is not a number that fits");
  }
  return value;
}

void read_cell(const std::string& cell, std::string& value) { value = cell; }
void read_cell(const std::string& cell, std::int64_t& value) {
  value = number_of<std::int64_t>(cell);
}
void read_cell(const std::string& cell, std::uint64_t& value) {
  value = number_of<std::uint64_t>(cell);
}
void read_cell(const std::string& cell, ScoreStatus& value) {
  value = score_status_from_string(cell);
}
void read_cell(const std::string& cell, double& value) {
  value = cell.empty() ? ScoreRow::kNone : number_of<double>(cell);
  // NaN has one spelling, the empty cell.
  if (!cell.empty() && std::isnan(value))
    throw std::invalid_argument(std::string("\"") + cell + "\": leave the cell empty instead");
}

/// Splits RFC 4180 text into records. Keeps the line for messages.
class Parser {
 public:
  Parser(std::string_view text, std::string_view name) : text_(text), name_(name) {}

  bool at_end() const { return position_ >= text_.size(); }
  int line() const { return record_line_; }

  std::vector<std::string> record() {
    record_line_ = line_;
    std::vector<std::string> cells;
    for (;;) {
      cells.push_back(cell());
      if (at_end()) return cells;
      const char c = text_[position_++];
      if (c == ',') continue;
      if (c == '\r' && !at_end() && text_[position_] == '\n')
        ++position_;
      else if (c != '\n')
        fail("expected a comma or the end of the line after column " +
             std::to_string(cells.size()));
      ++line_;
      return cells;
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(std::string(name_) + ":" + std::to_string(record_line_) + ": " + what);
  }

 private:
  std::string cell() {
    std::string value;
    const bool is_quoted = !at_end() && text_[position_] == '"';
    if (is_quoted) ++position_;
    for (;; ++position_) {
      if (value.size() > kMaxCell) fail("a cell is longer than 64 KiB");
      if (at_end()) {
        if (is_quoted) fail("a quote is not closed");
        return value;
      }
      const char c = text_[position_];
      if (c == '\0') fail("a NUL byte");
      if (is_quoted && c == '"') {
        if (position_ + 1 >= text_.size() || text_[position_ + 1] != '"') {
          ++position_;
          return value;
        }
        ++position_;
      } else if (!is_quoted && (c == ',' || c == '\n' || c == '\r')) {
        return value;
      } else if (!is_quoted && c == '"') {
        fail("a quote inside a cell that does not begin with one");
      } else if (c == '\n') {
        ++line_;
      }
      value += c;
    }
  }

  std::string_view text_;
  std::string_view name_;
  std::size_t position_ = 0;
  int line_ = 1;
  int record_line_ = 1;
};

template <class Row>
std::vector<Row> read(std::string_view text, std::string_view name,
                      std::span<const Column<Row>> columns) {
  Parser parser(text, name);
  const std::vector<std::string> header = parser.record();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i >= header.size() || header[i] != columns[i].name) {
      parser.fail("column " + std::to_string(i + 1) + " must be \"" + columns[i].name + "\"");
    }
  }
  if (header.size() > columns.size())
    parser.fail("column \"" + cut_utf8(header[columns.size()], 64) + "\" is unknown");

  std::vector<Row> rows;
  while (!parser.at_end()) {
    const std::vector<std::string> cells = parser.record();
    if (cells.size() != columns.size()) {
      parser.fail(std::to_string(cells.size()) + " cells; expected " +
                  std::to_string(columns.size()));
    }
    Row row;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      try {
        std::visit(
            [&](auto member) {
              read_cell(cells[i], row.*member);
              check_number(columns[i], row.*member);
            },
            columns[i].member);
      } catch (const std::invalid_argument& error) {
        parser.fail(std::string("column \"") + columns[i].name + "\": " + error.what());
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

std::string to_csv(std::span<const ScoreRow> rows) { return write(rows, score_columns()); }
std::string to_csv(std::span<const SpecimenRow> rows) { return write(rows, specimen_columns()); }

std::vector<ScoreRow> scores_from_csv(std::string_view text, std::string_view name) {
  const std::span<const Column<ScoreRow>> columns = score_columns();
  const std::string_view header = text.substr(0, text.find('\n'));
  const bool is_old = header.find("limit_low") == std::string_view::npos;
  std::vector<ScoreRow> rows =
      read(text, name, is_old ? columns.first(kColumnsOfSchema1) : columns);
  if (is_old) {
    for (ScoreRow& row : rows) settings_of_schema_1(row);
  }
  return rows;
}
std::vector<SpecimenRow> specimens_from_csv(std::string_view text, std::string_view name) {
  return read(text, name, std::span<const Column<SpecimenRow>>(specimen_columns()));
}

}  // namespace cousin
