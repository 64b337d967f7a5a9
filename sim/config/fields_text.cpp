// Values from the command line: "key=value" without TOML's quotes.

#include <charconv>
#include <optional>
#include <stdexcept>

#include "sim/config/field_value.h"
#include "sim/config/fields.h"

namespace cousin {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

template <class T>
std::optional<T> parse(std::string_view text) {
  T value{};
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// A number if it reads as one; text otherwise, which `assign` then refuses by name.
FieldValue number_or_text(std::string_view text) {
  if (const auto integer = parse<std::int64_t>(text)) return *integer;
  if (const auto real = parse<double>(text)) return *real;
  return std::string(text);
}

/// "1, 2" or "[1, 2]".
FieldValue list_or_text(std::string_view text) {
  std::string_view rest = text;
  if (rest.starts_with('[') && rest.ends_with(']') && rest.size() >= 2)
    rest = rest.substr(1, rest.size() - 2);
  std::vector<double> values;
  if (trimmed(rest).empty()) return values;
  while (true) {
    const auto comma = rest.find(',');
    const auto value = parse<double>(trimmed(rest.substr(0, comma)));
    if (!value) return std::string(text);
    values.push_back(*value);
    if (comma == std::string_view::npos) return values;
    rest.remove_prefix(comma + 1);
  }
}

std::string unquoted(std::string_view text) {
  const bool both = text.size() >= 2 && (text.front() == '"' || text.front() == '\'') &&
                    text.back() == text.front();
  return std::string(both ? text.substr(1, text.size() - 2) : text);
}

struct ReadText {
  std::string_view text;
  FieldValue operator()(const double*) const { return number_or_text(text); }
  FieldValue operator()(const int*) const { return number_or_text(text); }
  FieldValue operator()(const std::uint64_t*) const { return unquoted(text); }
  FieldValue operator()(const bool*) const {
    if (text == "true") return true;
    if (text == "false") return false;
    return std::string(text);
  }
  FieldValue operator()(const std::string*) const { return unquoted(text); }
  FieldValue operator()(const std::vector<double>*) const { return list_or_text(text); }
  FieldValue operator()(const TextField&) const { return unquoted(text); }
};

}  // namespace

void set_field(const Fields& fields, std::string_view assignment) {
  const auto equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    throw std::invalid_argument("'" + std::string(assignment) + "': must be key=value");
  }
  const std::string_view key = trimmed(assignment.substr(0, equals));
  const Field* field = find(fields, key);
  if (!field) throw std::invalid_argument(unknown_key_message(fields, key));
  assign(*field, std::visit(ReadText{trimmed(assignment.substr(equals + 1))}, field->value));
}

}  // namespace cousin
