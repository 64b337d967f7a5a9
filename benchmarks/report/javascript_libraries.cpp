#include "benchmarks/report/javascript_libraries.h"

#include <array>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>

namespace cousin {
namespace {

/// Debian ships Vega as its modules, not as one bundle. In the order of their needs, those that
/// plots use; maps, trees, forces and word clouds are left out.
constexpr std::array<std::string_view, 19> kVegaModules = {
    "vega-util",       "vega-time",       "vega-format",          "vega-loader",
    "vega-dataflow",   "vega-statistics", "vega-transforms",      "vega-scale",
    "vega-canvas",     "vega-scenegraph", "vega-view-transforms", "vega-encode",
    "vega-expression", "vega-selection",  "vega-functions",       "vega-event-selector",
    "vega-runtime",    "vega-view",       "vega-parser"};

/// A loader for CommonJS modules, and what Vega's own bundle does after loading: gather the
/// transforms. One module asks for vega-selection by its old name.
constexpr std::string_view kVegaHead = R"js("use strict";
var vega = (function () {
  const loaded = {};
  const alias = {"vega-selections": "vega-selection"};
  const need = name => {
    const found = loaded[alias[name] || name];
    if (!found) throw new Error("module " + name + " is not part of this page");
    return found;
  };
  const define = (name, body) => { const module = {exports: {}}; body(module.exports, module, need); loaded[name] = module.exports; };
)js";
constexpr std::string_view kVegaTail = R"js(
  Object.assign(need("vega-dataflow").transforms, need("vega-transforms"), need("vega-view-transforms"), need("vega-encode"));
  return {parse: need("vega-parser").parse, View: need("vega-view").View};
})();
)js";

std::optional<std::string> read(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return std::nullopt;
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (text.empty() || stream.bad()) return std::nullopt;
  return text;
}

void note_missing(std::string& missing, const std::filesystem::path& file,
                  std::string_view package) {
  if (!missing.empty()) missing += "; ";
  missing += file.string() + " (Debian package " + std::string(package) + ")";
}

}  // namespace

JavascriptLibraries load_javascript_libraries(const std::filesystem::path& folder) {
  const std::filesystem::path root =
      folder.empty() ? std::filesystem::path(COUSIN_JAVASCRIPT) : folder;
  JavascriptLibraries libraries;

  std::string vega(kVegaHead);
  for (const std::string_view module : kVegaModules) {
    const std::filesystem::path file = root / "vega" / (std::string(module) + ".min.js");
    const std::optional<std::string> text = read(file);
    if (!text) {
      note_missing(libraries.missing, file, "libjs-vega");
      vega.clear();
      break;
    }
    vega += "define(\"" + std::string(module) + "\", function (exports, module, require) {\n" +
            *text + "\n});\n";
  }
  if (!vega.empty()) libraries.vega = vega + std::string(kVegaTail);

  std::string three;
  for (const char* part : {"three/three.min.js", "three/examples/js/controls/OrbitControls.js"}) {
    const std::optional<std::string> text = read(root / part);
    if (!text) {
      note_missing(libraries.missing, root / part, "libjs-three");
      three.clear();
      break;
    }
    three += *text + "\n";
  }
  libraries.three = three;
  return libraries;
}

}  // namespace cousin
