#include "sim/config/fields.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sim/config/field_value.h"
#include "sim/config/nearest_word.h"

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

/// A hint where a decimal is written with a comma, as in "0,5".
std::string point_for_comma(const FieldValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr || std::count(text->begin(), text->end(), ',') != 1 ||
      text->find_first_not_of("+-0123456789,") != std::string::npos)
    return {};
  std::string with_point = *text;
  with_point[with_point.find(',')] = '.';
  return "; decimals take a point: " + with_point;
}

double number(const Field& field, const FieldValue& value) {
  double result = 0;
  if (const auto* real = std::get_if<double>(&value)) {
    result = *real;
  } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    result = static_cast<double>(*integer);
  } else {
    refuse(field, value, "a number" + point_for_comma(value));
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

std::string_view leaf(std::string_view key) { return key.substr(key.rfind('.') + 1); }

/// "mvs" of "mvs.planes"; "" of a key that stands alone.
std::string_view section(std::string_view key) {
  const auto dot = key.rfind('.');
  return dot == std::string_view::npos ? std::string_view{} : key.substr(0, dot);
}

constexpr std::size_t kNotMeant = std::numeric_limits<std::size_t>::max();

/// Edits between what was typed and a key that it may stand for: of the same section, of one whose
/// name or beginning was left out, or of one that is misspelt as a whole. kNotMeant for others.
std::size_t edits_to(std::string_view given, std::string_view key) {
  const std::string_view given_section = section(given), key_section = section(key);
  const std::string inside = std::string(given_section) + ".";
  const bool left_out =
      key_section != given_section && (given_section.empty() || key_section.starts_with(inside) ||
                                       key_section.ends_with("." + std::string(given_section)));
  if (key_section == given_section || left_out) {
    if (!may_mean(leaf(given), leaf(key))) return kNotMeant;
    return edit_distance(leaf(given), leaf(key)) + (left_out ? 1 : 0);
  }
  return may_mean(given_section, key_section) && may_mean(given, key) ? edit_distance(given, key)
                                                                      : kNotMeant;
}

/// Where no key is near: what the section has, or that there is no such section.
std::string what_there_is(const Fields& fields, std::string_view key) {
  constexpr int kListed = 12;
  const std::string_view given = section(key);
  const auto is_inside = [&](const Field& field) {
    return section(field.key) == given || field.key.starts_with(std::string(given) + ".");
  };
  const auto inside = std::count_if(fields.begin(), fields.end(), is_inside);
  if (inside == 0) {
    const Field* alone = find(fields, leaf(key));
    return "there is no section '" + std::string(given) + "'" +
           (alone != nullptr ? "; '" + alone->key + "' stands alone" : "");
  }
  if (given.empty()) return "no key has a name like it";
  if (inside > kListed) return "no key of '" + std::string(given) + "' has a name like it";
  std::string keys;
  for (const Field& field : fields) {
    if (is_inside(field)) keys += (keys.empty() ? "" : ", ") + field.key;
  }
  return "there are " + keys;
}

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
  std::size_t best = kNotMeant;
  const std::string_view given =
      key.substr(0, 200);  // the distance is quadratic, and keys are short
  for (const Field& field : fields) {
    const std::size_t distance = edits_to(given, field.key);
    if (distance < best) {
      best = distance;
      nearest = &field;
    }
  }
  const std::string message = "unknown key '" + std::string(given) + "'; ";
  if (fields.empty()) return message + "there are no keys";
  return message + (nearest != nullptr ? "the nearest key is '" + nearest->key + "'"
                                       : what_there_is(fields, given));
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
