#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "benchmarks/score/score_columns.h"
#include "benchmarks/score/scores.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kSchema = 2, kOldSchema = 1;

Json json_of(const std::string& value) { return value; }
Json json_of(std::int64_t value) { return value; }
Json json_of(std::uint64_t value) { return value; }
Json json_of(ScoreStatus value) { return std::string(to_string(value)); }
Json json_of(double value) {
  // JSON has no infinity: it is written as text.
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return std::isnan(value) ? Json(nullptr) : Json(value);
}

/// Catches what the JSON library would convert in silence.
void expect(bool good, const char* what) {
  if (!good) throw std::invalid_argument(std::string("expected ") + what);
}
void read_value(const Json& json, std::string& value) {
  constexpr std::size_t kMostBytes = 64 * 1024;  // as a cell of scores.csv
  expect(json.is_string(), "a text");
  const auto& text = json.get_ref<const std::string&>();
  expect(text.size() <= kMostBytes, "a text of at most 64 KiB");
  expect(text.find('\0') == std::string::npos, "a text without NUL bytes");
  value = text;
}
void read_value(const Json& json, std::int64_t& value) {
  expect(json.is_number_integer() &&
             (!json.is_number_unsigned() || json.get<std::uint64_t>() <= INT64_MAX),
         "a whole number");
  value = json.get<std::int64_t>();
}
void read_value(const Json& json, std::uint64_t& value) {
  expect(json.is_number_unsigned(), "a whole number that is not negative");
  value = json.get<std::uint64_t>();
}
void read_value(const Json& json, ScoreStatus& value) {
  expect(json.is_string(), "a status");
  value = score_status_from_string(json.get<std::string>());
}
void read_value(const Json& json, double& value) {
  if (json.is_null()) {
    value = ScoreRow::kNone;
  } else if (json == "inf" || json == "-inf") {
    value = json == "inf" ? INFINITY : -INFINITY;
  } else {
    expect(json.is_number(), "a number or null");
    value = json.get<double>();
  }
}

template <class Row>
Json rows_to_json(std::span<const Row> rows, const std::vector<Column<Row>>& columns) {
  Json list = Json::array();
  for (const Row& row : rows) {
    Json object = Json::object();
    for (const auto& column : columns) {
      object[column.name] =
          std::visit([&](auto member) { return json_of(row.*member); }, column.member);
    }
    list.push_back(std::move(object));
  }
  return list;
}

[[noreturn]] void fail(std::string_view name, const std::string& where, const std::string& what) {
  throw std::runtime_error(std::string(name) + ": " + where + ": " + what);
}

const Json& member(const Json& object, const char* key, std::string_view name,
                   const std::string& where) {
  if (!object.is_object() || !object.contains(key))
    fail(name, where, std::string("\"") + key + "\" is missing");
  return object[key];
}

void reject_unknown(const Json& object, std::size_t known, const auto& is_known,
                    std::string_view name, const std::string& where) {
  if (object.size() == known) return;
  for (const auto& item : object.items()) {
    if (!is_known(item.key()))
      fail(name, where, std::string("\"") + cut_utf8(item.key(), 64) + "\" is unknown");
  }
}

template <class Row>
std::vector<Row> rows_from_json(const Json& root, const char* key,
                                std::span<const Column<Row>> columns, std::string_view name) {
  const Json& list = member(root, key, name, "top level");
  if (!list.is_array()) fail(name, key, "expected a list");
  std::vector<Row> rows;
  for (const Json& object : list) {
    const std::string where = std::string(key) + "[" + std::to_string(rows.size()) + "]";
    Row row;
    for (const auto& column : columns) {
      const Json& value = member(object, column.name, name, where);
      try {
        std::visit(
            [&](auto field) {
              read_value(value, row.*field);
              check_number(column, row.*field);
            },
            column.member);
      } catch (const std::invalid_argument& error) {
        fail(name, where + "." + column.name, error.what());
      }
    }
    const auto is_known = [&](const std::string& text) {
      return std::any_of(columns.begin(), columns.end(),
                         [&](const auto& c) { return text == c.name; });
    };
    reject_unknown(object, columns.size(), is_known, name, where);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

std::string to_json(const ScoreFile& file) {
  Json root;
  root["schema"] = kSchema;
  Json header = {{"program_version", file.header.program_version},
                 {"dataset_hash", file.header.dataset_hash},
                 {"config_hash", file.header.config_hash},
                 {"machine", file.header.machine},
                 {"more", Json::object()}};
  for (const auto& [key, value] : file.header.more) header["more"][key] = value;
  root["header"] = std::move(header);
  root["scores"] = rows_to_json(std::span<const ScoreRow>(file.scores), score_columns());
  root["specimens"] =
      rows_to_json(std::span<const SpecimenRow>(file.specimens), specimen_columns());
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

ScoreFile scores_from_json(std::string_view text, std::string_view name) {
  Json root;
  try {
    // Depth is bounded: this file nests three deep, and a deep one would exhaust the stack.
    const Json::parser_callback_t limit = [](int depth, Json::parse_event_t, Json&) {
      if (depth > 16) throw std::runtime_error("nested deeper than 16");
      return true;
    };
    root = Json::parse(text, limit);
  } catch (const std::exception& error) {
    fail(name, "not JSON", error.what());
  }
  const Json& schema = member(root, "schema", name, "top level");
  const bool is_old = schema == kOldSchema;
  if (schema != kSchema && !is_old)
    fail(name, "schema",
         "expected " + std::to_string(kSchema) + " or " + std::to_string(kOldSchema));

  ScoreFile file;
  const Json& header = member(root, "header", name, "top level");
  const auto read_text = [&](const char* key, std::string& value) {
    const Json& text_value = member(header, key, name, "header");
    if (!text_value.is_string()) fail(name, std::string("header.") + key, "expected a text");
    value = text_value.get<std::string>();
  };
  read_text("program_version", file.header.program_version);
  read_text("dataset_hash", file.header.dataset_hash);
  read_text("config_hash", file.header.config_hash);
  read_text("machine", file.header.machine);
  const Json& more = member(header, "more", name, "header");
  if (!more.is_object()) fail(name, "header.more", "expected an object");
  for (const auto& item : more.items()) {
    if (!item.value().is_string())
      fail(name, "header.more", std::string("\"") + cut_utf8(item.key(), 64) + "\" is not a text");
    file.header.more[item.key()] = item.value().get<std::string>();
  }
  reject_unknown(
      header, 5,
      [](const std::string& k) {
        return k == "program_version" || k == "dataset_hash" || k == "config_hash" ||
               k == "machine" || k == "more";
      },
      name, "header");

  const std::span<const Column<ScoreRow>> columns = score_columns();
  file.scores =
      rows_from_json(root, "scores", is_old ? columns.first(kColumnsOfSchema1) : columns, name);
  if (is_old) {
    for (ScoreRow& row : file.scores) settings_of_schema_1(row);
  }
  file.specimens = rows_from_json(root, "specimens",
                                  std::span<const Column<SpecimenRow>>(specimen_columns()), name);
  reject_unknown(
      root, 4,
      [](const std::string& k) {
        return k == "schema" || k == "header" || k == "scores" || k == "specimens";
      },
      name, "top level");
  return file;
}

}  // namespace cousin
