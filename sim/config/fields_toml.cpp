#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <toml.hpp>

#include "sim/config/field_value.h"
#include "sim/config/fields.h"
#include "sim/config/toml_peek.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxLine = 4096;
constexpr std::ptrdiff_t kMaxBrackets = 1000;

/// toml11 recurses once for each bracket and each part of a dotted key: hostile text must not
/// exhaust the stack.
void check_size(std::string_view text, const std::string& name) {
  if (text.size() > kMaxBytes) {
    throw std::runtime_error(name + ": " + std::to_string(text.size()) + " bytes; the limit is " +
                             std::to_string(kMaxBytes));
  }
  const auto brackets =
      std::count_if(text.begin(), text.end(), [](char c) { return c == '[' || c == '{'; });
  if (brackets > kMaxBrackets) {
    throw std::runtime_error(name + ": " + std::to_string(brackets) +
                             " opening brackets; the limit is " + std::to_string(kMaxBrackets));
  }
  std::size_t line = 1;
  while (!text.empty()) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    if (length > kMaxLine) {
      throw std::runtime_error(name + ":" + std::to_string(line) + ": " + std::to_string(length) +
                               " characters in a line; the limit is " + std::to_string(kMaxLine));
    }
    text.remove_prefix(std::min(length + 1, text.size()));
    ++line;
  }
}

std::string at(const std::string& name, const toml::value& value) {
  return name + ":" + std::to_string(value.location().line()) + ": ";
}

/// The first line of toml11's message, without its own prefixes; the rest repeats the source.
std::string first_line(std::string message) {
  message.erase(std::min(message.find('\n'), message.size()));
  for (const std::string_view prefix : {"[error] ", "toml::"}) {
    if (message.starts_with(prefix)) message.erase(0, prefix.size());
  }
  return message;
}

toml::value parse(std::string_view text, const std::string& name) {
  std::istringstream in{std::string(text)};
  try {
    return toml::parse(in, name);
  } catch (const toml::exception& error) {
    throw std::runtime_error(name + ":" + std::to_string(error.location().line()) + ": " +
                             first_line(error.what()));
  } catch (const std::exception& error) {
    throw std::runtime_error(name + ": " + first_line(error.what()));
  }
}

FieldValue list_value(const toml::value& value, const std::string& key) {
  std::vector<double> numbers;
  for (const toml::value& each : value.as_array()) {
    if (each.is_integer()) {
      numbers.push_back(static_cast<double>(each.as_integer()));
    } else if (each.is_floating()) {
      numbers.push_back(each.as_floating());
    } else {
      throw std::invalid_argument(key + ": must be a list of numbers");
    }
  }
  return numbers;
}

FieldValue field_value(const toml::value& value, const std::string& key) {
  if (value.is_boolean()) return value.as_boolean();
  if (value.is_integer()) return static_cast<std::int64_t>(value.as_integer());
  if (value.is_floating()) return value.as_floating();
  if (value.is_string()) return value.as_string().str;
  if (value.is_array()) return list_value(value, key);
  throw std::invalid_argument(key + ": dates and times are not used here");
}

std::vector<std::pair<std::string, const toml::value*>> rows_in_order(const toml::value& table) {
  std::vector<std::pair<std::string, const toml::value*>> rows;
  for (const auto& [key, value] : table.as_table()) rows.emplace_back(key, &value);
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
    return std::pair(a.second->location().line(), a.first) <
           std::pair(b.second->location().line(), b.first);
  });
  return rows;
}

std::string bytes_of(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw std::runtime_error(file.string() + ": no such file");
  if (!std::filesystem::is_regular_file(file, error))
    throw std::runtime_error(file.string() + ": not a regular file");
  std::ifstream in(file, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in && !in.eof()) throw std::runtime_error(file.string() + ": cannot read");
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

class Reader {
 public:
  Reader(const std::string& name, const Fields& fields) : name_(name), fields_(fields) {}

  void read(const toml::value& table, const std::string& prefix) {
    // In the order of the file, so that the first mistake in it is the one named.
    for (const auto& [key, value] : rows_in_order(table))
      read_row(prefix.empty() ? key : prefix + "." + key, *value);
  }

  void require_all() const {
    std::string missing;
    for (const Field& field : fields_) {
      if (!field.optional && !seen_.contains(field.key))
        missing += (missing.empty() ? "" : ", ") + field.key;
    }
    if (!missing.empty()) throw std::runtime_error(name_ + ": missing keys: " + missing);
  }

 private:
  void read_row(const std::string& key, const toml::value& value) {
    const Field* field = find(fields_, key);
    const bool is_prefix = std::any_of(fields_.begin(), fields_.end(), [&](const Field& f) {
      return f.key.starts_with(key + ".");
    });
    if (!field && value.is_table() && is_prefix) return read(value, key);
    if (!field) throw std::runtime_error(at(name_, value) + unknown_key_message(fields_, key));
    try {
      assign(*field, field_value(value, key));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(at(name_, value) + error.what());
    }
    seen_.insert(key);
  }

  const std::string& name_;
  const Fields& fields_;
  std::set<std::string> seen_;
};

}  // namespace

void read_toml_text(std::string_view text, std::string_view name, const Fields& fields,
                    MissingKeys missing) {
  const std::string file(name);
  check_size(text, file);
  const toml::value root = parse(text, file);
  Reader reader(file, fields);
  reader.read(root, "");
  if (missing == MissingKeys::error) reader.require_all();
}

std::vector<std::string> toml_tables(std::string_view text, std::string_view name) {
  const std::string file(name);
  check_size(text, file);
  const toml::value root = parse(text, file);
  std::vector<std::string> names;
  for (const auto& [key, value] : rows_in_order(root)) {
    if (value->is_table()) names.push_back(key);
  }
  return names;
}

void read_toml(const std::filesystem::path& file, const Fields& fields, MissingKeys missing) {
  read_toml_text(bytes_of(file), file.string(), fields, missing);
}

std::string toml_text_of(const std::filesystem::path& file, std::string_view table,
                         std::string_view key) {
  const std::string text = bytes_of(file), name = file.string();
  check_size(text, name);
  const toml::value root = parse(text, name);
  const std::string table_key(table), own_key(key);
  if (!root.contains(table_key) || !root.at(table_key).is_table()) return {};
  const toml::value& inner = root.at(table_key);
  if (!inner.contains(own_key)) return {};
  const toml::value& value = inner.at(own_key);
  if (!value.is_string())
    throw std::runtime_error(at(name, value) + table_key + "." + own_key + ": must be text");
  return value.as_string().str;
}

std::string to_toml(const Fields& fields) {
  // TOML puts plain keys before tables, and each table once; tables keep the order of their first
  // field.
  std::vector<std::string> tables = {""};
  const auto table_of = [](const Field& field) {
    const auto dot = field.key.rfind('.');
    return dot == std::string::npos ? std::string() : field.key.substr(0, dot);
  };
  for (const Field& field : fields) {
    if (std::find(tables.begin(), tables.end(), table_of(field)) == tables.end())
      tables.push_back(table_of(field));
  }
  std::string out;
  for (const std::string& table : tables) {
    if (!table.empty()) out += (out.empty() ? "[" : "\n[") + table + "]\n";
    for (const Field& field : fields) {
      if (table_of(field) != table) continue;
      out += field.key.substr(table.empty() ? 0 : table.size() + 1) + " = " + value_as_toml(field) +
             "\n";
    }
  }
  return out;
}

}  // namespace cousin
