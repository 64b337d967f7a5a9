#pragma once

#include <stdexcept>
#include <string>

namespace cousin {

/// The first lines of the files.
inline constexpr const char* kPdfHead = "%PDF-1.4\n% a page of Cousin\n";
inline constexpr const char* kSvgHead = "<!-- a page of Cousin -->\n";

/// @throws std::invalid_argument if it is not printable ASCII
inline const std::string& checked_text(const std::string& words) {
  for (const char c : words) {
    if (c < ' ' || c > '~')
      throw std::invalid_argument("page: text \"" + words + "\" is not printable ASCII");
  }
  return words;
}

}  // namespace cousin
