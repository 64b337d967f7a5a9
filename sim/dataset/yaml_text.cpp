#include "sim/dataset/yaml_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <stdexcept>

#include "sim/dataset/text_fields.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

std::uint32_t code_point(std::string_view character) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(character[i]); };
  if (character.size() == 1) return byte(0);
  std::uint32_t code = byte(0) & (0xffU >> (character.size() + 1));
  for (std::size_t i = 1; i < character.size(); ++i) code = code << 6 | (byte(i) & 0x3fU);
  return code;
}

/// Printed as it is between double quotes: not what breaks a line or marks the order of bytes.
bool is_plain_in_quotes(std::uint32_t code) {
  if (code < 0x20 || code == 0x22 || code == 0x5c) return false;
  if (code < 0x7f) return true;
  return code >= 0xa0 && code != 0x2028 && code != 0x2029 && code != 0xfeff && code < 0xfffe;
}

std::string escaped(std::uint32_t code) {
  if (code == 0x22) return "\\\"";
  if (code == 0x5c) return "\\\\";
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(),
                code < 0x100     ? "\\x%02x"
                : code < 0x10000 ? "\\u%04x"
                                 : "\\U%08x",
                code);
  return text.data();
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Words that YAML 1.1 or 1.2 takes for a truth value or for nothing, in any case.
bool is_word_of_yaml(std::string_view text) {
  std::string low(text);
  std::transform(low.begin(), low.end(), low.begin(),
                 [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c); });
  constexpr std::array<std::string_view, 9> kWords = {"y",  "n",   "yes",   "no",  "true",
                                                      "on", "off", "false", "null"};
  return std::find(kWords.begin(), kWords.end(), low) != kWords.end();
}

}  // namespace

std::string yaml_number(double value) {
  if (!std::isfinite(value))
    throw std::invalid_argument("YAML: " + std::to_string(value) + " is not finite");
  std::string text = exact_text(value);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos)
    text.insert(exponent, ".0");
  return text;
}

std::string yaml_numbers(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + yaml_number(value);
  return text;
}

std::string yaml_quoted(std::string_view text) {
  std::string result = "\"";
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t bytes = utf8_character_bytes(rest);
    if (bytes == 0) {
      throw std::runtime_error("YAML: \"" + readable_utf8(cut_utf8(text, 200)) +
                               "\" is not UTF-8 text");
    }
    const std::string_view character = rest.substr(0, bytes);
    const std::uint32_t code = code_point(character);
    result += is_plain_in_quotes(code) ? std::string(character) : escaped(code);
    rest.remove_prefix(bytes);
  }
  return result + '"';
}

std::string yaml_name(std::string_view text) {
  // It starts with a letter, so it is no number, date or mark of YAML's; hex and the like start
  // with a digit.
  const bool is_simple = !text.empty() && is_letter(text.front()) && !is_word_of_yaml(text) &&
                         std::all_of(text.begin(), text.end(), [](char c) {
                           return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-';
                         });
  return is_simple ? std::string(text) : yaml_quoted(text);
}

}  // namespace cousin
