#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>

namespace cousin {

/// Markup as it stands in this program's source. Nothing that is known only when the program runs
/// can become one.
struct Markup {
  std::string_view text;
  consteval Markup(const char* literal) : text(literal) {}
};

/// A piece of a page. It grows by markup of the source and by the functions below, which write what
/// comes from files so that it stays text; a std::string cannot be put into it by accident.
class Html {
 public:
  Html() = default;
  Html(Markup markup) : text_(markup.text) {}
  Html& operator+=(Markup markup);
  Html& operator+=(const Html& other);
  const std::string& str() const { return text_; }

 private:
  friend Html html_text(std::string_view text);
  friend Html html_base64(std::span<const std::uint8_t> bytes);
  friend Html html_json(const nlohmann::ordered_json& json);
  friend Html html_script(std::string_view program);
  friend Html html_style(std::string_view sheet);
  std::string text_;
};
Html operator+(Html a, const Html& b);
Html operator+(Html a, Markup b);
Html operator+(Markup a, const Html& b);

/// Text, as content of an element or between the quotes of an attribute: & < > " ' are escaped;
/// bytes that are not UTF-8 and control characters are shown ("\x1b").
Html html_text(std::string_view text);
/// Digits of base 64, for a data: address.
Html html_base64(std::span<const std::uint8_t> bytes);
Html html_base64(std::string_view bytes);
/// JSON that may stand in a script element of any type: < is escaped, so that nothing in it ends
/// the element or opens a comment, and U+2028 and U+2029, which JavaScript once took for line ends.
Html html_json(const nlohmann::ordered_json& json);
/// A script element around a program of ours or of an installed library, never around what a
/// capture or a result holds: an end tag or a comment opening in its strings does not end it.
Html html_script(std::string_view program);
/// A style element around a sheet of ours.
Html html_style(std::string_view sheet);

std::string base64(std::span<const std::uint8_t> bytes);
std::string base64(std::string_view text);

}  // namespace cousin
