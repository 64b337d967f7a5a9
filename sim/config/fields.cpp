#include "sim/config/fields.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "sim/config/field_value.h"

namespace cousin {
namespace {

std::string toml_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (code < 0x20 || code == 0x7f) {
      static constexpr char kHex[] = "0123456789abcdef";
      out += "\\u00";
      out += kHex[code >> 4];
      out += kHex[code & 15];
    } else {
      out += c;
    }
  }
  return out + '"';
}

template <class T>
std::string join(const std::vector<T>& values, std::string (*text)(T)) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i) out += (i ? ", " : "") + text(values[i]);
  return out + "]";
}

std::string text_of(const FieldValue& value) {
  struct Visitor {
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(std::int64_t v) const { return std::to_string(v); }
    std::string operator()(double v) const { return shortest(v); }
    std::string operator()(const std::string& v) const { return toml_string(v); }
    std::string operator()(const std::vector<double>& v) const { return join(v, shortest); }
  };
  return std::visit(Visitor{}, value);
}

[[noreturn]] void refuse(const Field& field, const FieldValue& value, const std::string& must) {
  throw std::invalid_argument(field.key + " = " + text_of(value) + ": must be " + must);
}

std::string limits(const Field& field) {
  return std::string("[")
      .append(shortest(field.min))
      .append(", ")
      .append(shortest(field.max))
      .append("]");
}

bool within(const Field& field, double value) {
  return std::isfinite(value) && value >= field.min && value <= field.max;
}

std::string in_limits(const Field& field) {
  if (std::isinf(field.min) && std::isinf(field.max)) return "finite";
  return "in " + limits(field);
}

double number(const Field& field, const FieldValue& value) {
  double result = 0;
  if (const auto* real = std::get_if<double>(&value)) {
    result = *real;
  } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    result = static_cast<double>(*integer);
  } else {
    refuse(field, value, "a number");
  }
  if (!within(field, result)) refuse(field, value, in_limits(field));
  return result;
}

int integer(const Field& field, const FieldValue& value) {
  const auto* given = std::get_if<std::int64_t>(&value);
  if (!given) refuse(field, value, "an integer");
  if (!within(field, static_cast<double>(*given))) refuse(field, value, in_limits(field));
  if (*given < std::numeric_limits<int>::min() || *given > std::numeric_limits<int>::max()) {
    refuse(field, value, "an integer of 32 bits");
  }
  return static_cast<int>(*given);
}

/// TOML integers end at 2^63 - 1, so larger seeds are written as text.
std::uint64_t natural(const Field& field, const FieldValue& value) {
  std::uint64_t result = 0;
  if (const auto* given = std::get_if<std::int64_t>(&value)) {
    if (*given < 0) refuse(field, value, "zero or a positive integer");
    result = static_cast<std::uint64_t>(*given);
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), result);
    if (error != std::errc{} || end != text->data() + text->size()) {
      refuse(field, value, "zero or a positive integer of 64 bits");
    }
  } else {
    refuse(field, value, "zero or a positive integer");
  }
  if (!within(field, static_cast<double>(result))) refuse(field, value, in_limits(field));
  return result;
}

/// Edits (insert, drop, replace) between two texts [Levenshtein 1966].
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string_view leaf(std::string_view key) { return key.substr(key.rfind('.') + 1); }

}  // namespace

Fields nested(std::string_view prefix, Fields inner) {
  for (Field& field : inner) field.key = std::string(prefix) + "." + field.key;
  return inner;
}

Fields operator+(Fields a, Fields b) {
  a.insert(a.end(), std::make_move_iterator(b.begin()), std::make_move_iterator(b.end()));
  return a;
}

void assign(const Field& field, const FieldValue& value) {
  struct Visitor {
    const Field& field;
    const FieldValue& value;
    void operator()(double* out) const { *out = number(field, value); }
    void operator()(int* out) const { *out = integer(field, value); }
    void operator()(std::uint64_t* out) const { *out = natural(field, value); }
    void operator()(bool* out) const {
      if (!std::holds_alternative<bool>(value)) refuse(field, value, "true or false");
      *out = std::get<bool>(value);
    }
    void operator()(std::string* out) const {
      if (!std::holds_alternative<std::string>(value)) refuse(field, value, "text");
      *out = std::get<std::string>(value);
    }
    void operator()(std::vector<double>* out) const {
      if (!std::holds_alternative<std::vector<double>>(value))
        refuse(field, value, "a list of numbers");
      for (const double each : std::get<std::vector<double>>(value)) {
        if (!within(field, each)) refuse(field, value, "numbers that are " + in_limits(field));
      }
      *out = std::get<std::vector<double>>(value);
    }
    void operator()(const TextField& text) const {
      if (!std::holds_alternative<std::string>(value)) refuse(field, value, "text");
      try {
        text.set(std::get<std::string>(value));
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(field.key + " = " + text_of(value) + ": " + error.what());
      }
    }
  };
  std::visit(Visitor{field, value}, field.value);
}

const Field* find(const Fields& fields, std::string_view key) {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.key == key; });
  return found == fields.end() ? nullptr : &*found;
}

std::string unknown_key_message(const Fields& fields, std::string_view key) {
  const Field* nearest = nullptr;
  std::size_t best = std::numeric_limits<std::size_t>::max();
  const std::string_view given =
      key.substr(0, 200);  // the distance is quadratic, and keys are short
  for (const Field& field : fields) {
    // A forgotten prefix ("planes" for "mvs.planes") costs one edit, whatever its length.
    const std::size_t distance =
        std::min(edit_distance(given, field.key), 1 + edit_distance(leaf(given), leaf(field.key)));
    if (distance < best) {
      best = distance;
      nearest = &field;
    }
  }
  std::string message = "unknown key '" + std::string(given) + "'";
  return nearest ? message + "; the nearest key is '" + nearest->key + "'"
                 : message + "; there are no keys";
}

std::string shortest(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  return {buffer, end};
}

std::string value_as_toml(const Field& field) {
  struct Visitor {
    static std::string real(double v) {
      std::string text = shortest(v);
      // TOML tells floats from integers by the point or the exponent.
      return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
    }
    std::string operator()(const double* v) const { return real(*v); }
    std::string operator()(const int* v) const { return std::to_string(*v); }
    std::string operator()(const std::uint64_t* v) const {
      const std::string text = std::to_string(*v);
      return *v > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())
                 ? toml_string(text)
                 : text;
    }
    std::string operator()(const bool* v) const { return *v ? "true" : "false"; }
    std::string operator()(const std::string* v) const { return toml_string(*v); }
    std::string operator()(const std::vector<double>* v) const { return join(*v, real); }
    std::string operator()(const TextField& text) const { return toml_string(text.get()); }
  };
  return std::visit(Visitor{}, field.value);
}

std::string describe(const Fields& fields) {
  std::vector<std::array<std::string, 3>> columns;
  std::array<std::size_t, 3> width{};
  for (const Field& field : fields) {
    const bool bounded = std::isfinite(field.min) || std::isfinite(field.max);
    columns.push_back({field.key, value_as_toml(field), bounded ? limits(field) : ""});
    for (std::size_t c = 0; c < 3; ++c) width[c] = std::max(width[c], columns.back()[c].size());
  }
  std::string out;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    std::string line;
    for (std::size_t c = 0; c < 3; ++c) {
      line += columns[i][c];
      line.append(width[c] - columns[i][c].size() + (width[c] > 0 ? 2 : 0), ' ');
    }
    line += fields[i].help;
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace cousin
