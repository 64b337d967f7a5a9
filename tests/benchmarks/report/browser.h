#pragma once

#include <string>

namespace cousin {

/// Whether Chromium is here to show pages.
bool has_chromium();

inline constexpr const char* kWithWebgl =
    " --use-angle=swiftshader --enable-unsafe-swiftshader";  ///< without a graphics card
inline constexpr const char* kWithoutWebgl = " --disable-gpu --disable-3d-apis";

/// The document of a page after its scripts have run in headless Chromium; empty if that could not
/// start.
std::string shown_document(const std::string& html, const std::string& more_flags);

/// The root element's tag, which carries what the page says of itself.
std::string root_tag(const std::string& document);

/// How often `part` stands in `text`.
int count(const std::string& text, const std::string& part);

}  // namespace cousin
