#include "benchmarks/report/html.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>

namespace cousin {

std::string html_escaped(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string base64(std::span<const std::uint8_t> bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string result;
  result.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      result += k <= count ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return result;
}

std::string base64(std::string_view text) {
  return base64(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::string inside_script(std::string_view script) {
  static constexpr std::string_view kEnd = "/script";
  static constexpr std::string_view kComment = "!--";
  const auto follows = [&](std::size_t at, std::string_view word) {
    return script.size() - at >= word.size() &&
           std::equal(
               word.begin(), word.end(), script.begin() + static_cast<std::ptrdiff_t>(at),
               [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
  };
  std::string result;
  result.reserve(script.size());
  for (std::size_t i = 0; i < script.size(); ++i) {
    result += script[i];
    // "<\/script" and "<\!--" mean the same inside JavaScript strings and regular expressions.
    if (script[i] == '<' && (follows(i + 1, kEnd) || follows(i + 1, kComment))) result += '\\';
  }
  return result;
}

ShownUnit shown_unit(std::string_view unit, std::string_view metric) {
  if (unit == "m") return {"mm", 1e3};
  if (unit == "m2") return {"mm²", 1e6};
  if (unit == "m3") return {"mm³", 1e9};
  if (unit == "kg") return {"g", 1e3};
  if (unit == "rad") return {"°", 57.29577951308232};
  if (unit == "%") return {"%", 100};
  if (unit == "1") {
    for (const std::string_view ratio : {"mape", "coverage_68", "coverage_95", "share"}) {
      if (metric.ends_with(ratio)) return {"%", 100};
    }
    return {"", 1};
  }
  return {std::string(unit), 1};
}

std::string shown_number(double value) {
  if (std::isnan(value)) return "–";
  std::array<char, 64> buffer{};
  const double size = std::abs(value);
  if (size != 0 && std::isfinite(value) && size >= 1e-4 && size < 1e7) {
    const int digits = std::max(0, 2 - static_cast<int>(std::floor(std::log10(size))));
    std::snprintf(buffer.data(), buffer.size(), "%.*f", digits, value);
  } else {
    std::snprintf(buffer.data(), buffer.size(), "%.3g", value);
  }
  return buffer.data();
}

std::string shown_precisely(double value) {
  const double size = std::abs(value);
  if (!(size >= 10 && size < 1e4) || size == std::floor(size)) return shown_number(value);
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.2f", value);
  return buffer.data();
}

std::string shown_interval(const WithInterval& value, double factor) {
  std::string text = shown_number(factor * value.value);
  if (std::isfinite(value.low) && std::isfinite(value.high)) {
    text +=
        " [" + shown_number(factor * value.low) + ", " + shown_number(factor * value.high) + "]";
  }
  return text;
}

}  // namespace cousin
