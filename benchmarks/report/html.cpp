#include "benchmarks/report/html.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "sim/types/utf8.h"

namespace cousin {
namespace {

/// Whether the text goes on with this word at `at`, letters large or small.
bool goes_on(std::string_view text, std::size_t at, std::string_view word) {
  return text.size() - at >= word.size() &&
         std::equal(
             word.begin(), word.end(), text.begin() + static_cast<std::ptrdiff_t>(at),
             [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

/// With a backslash behind every < that would end the element of this name or open a comment:
/// "<\/script" and "<\!--" mean the same inside strings and regular expressions.
std::string inside_element(std::string_view text, std::string_view end_tag) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    result += text[i];
    if (text[i] == '<' && (goes_on(text, i + 1, end_tag) || goes_on(text, i + 1, "!--")))
      result += '\\';
  }
  return result;
}

/// What a character is written as in HTML; empty: as it is.
std::string_view escaped(char c) {
  switch (c) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return {};
  }
}

/// Control characters that are no white space; browsers drop or change them.
bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 0x20 && c != '\n' && c != '\t' && c != '\r') || byte == 0x7f;
}

}  // namespace

Html& Html::operator+=(Markup markup) {
  text_ += markup.text;
  return *this;
}

Html& Html::operator+=(const Html& other) {
  text_ += other.text_;
  return *this;
}

Html operator+(Html a, const Html& b) { return a += b; }
Html operator+(Html a, Markup b) { return a += b; }
Html operator+(Markup a, const Html& b) { return Html(a) += b; }

Html html_text(std::string_view text) {
  static constexpr std::string_view kDigits = "0123456789abcdef";
  Html result;
  result.text_.reserve(text.size());
  for (const char c : readable_utf8(text)) {
    const std::string_view as = escaped(c);
    if (!as.empty())
      result.text_ += as;
    else if (is_control(c))
      result.text_ += {'\\', 'x', kDigits[static_cast<unsigned char>(c) >> 4],
                       kDigits[static_cast<unsigned char>(c) & 15U]};
    else
      result.text_ += c;
  }
  return result;
}

Html html_base64(std::span<const std::uint8_t> bytes) {
  Html result;
  result.text_ = base64(bytes);
  return result;
}

Html html_base64(std::string_view bytes) {
  return html_base64(std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
}

Html html_json(const nlohmann::ordered_json& json) {
  const std::string text =
      json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  Html result;
  result.text_.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '<') {
      result.text_ += "\\u003c";
    } else if (text.compare(i, 3, "\xe2\x80\xa8") == 0) {
      result.text_ += "\\u2028";
      i += 2;
    } else if (text.compare(i, 3, "\xe2\x80\xa9") == 0) {
      result.text_ += "\\u2029";
      i += 2;
    } else {
      result.text_ += text[i];
    }
  }
  return result;
}

Html html_script(std::string_view program) {
  Html result("<script>\n");
  result.text_ += inside_element(program, "/script");
  return result += "</script>\n";
}

Html html_style(std::string_view sheet) {
  Html result("<style>\n");
  result.text_ += inside_element(sheet, "/style");
  return result += "</style>\n";
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

}  // namespace cousin
