#pragma once

#include <filesystem>
#include <string>

namespace cousin {

/// JavaScript to inline; empty where a file is missing.
struct JavascriptLibraries {
  std::string vega;     ///< defines the global `vega` with parse and View
  std::string three;    ///< defines the global `THREE` with OrbitControls
  std::string missing;  ///< what was not found, for the page's notes; empty if all was
};

/// @param folder  as ReportConfig::javascript
JavascriptLibraries load_javascript_libraries(const std::filesystem::path& folder);

}  // namespace cousin
