#include "tests/benchmarks/report/browser.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {

namespace fs = std::filesystem;

bool has_chromium() { return fs::exists(COUSIN_CHROMIUM); }

std::string shown_document(const std::string& html, const std::string& more_flags) {
  const TemporaryFolder folder;
  const fs::path page = folder.path() / "report.html";
  std::ofstream(page, std::ios::binary) << html;
  const std::string command =
      std::string(COUSIN_CHROMIUM) +
      " --headless --no-sandbox --disable-quic --no-first-run --disable-background-networking"
      " --disable-component-update --disable-sync --hide-scrollbars --window-size=1280,1000 "
      "--virtual-time-budget=30000" +
      more_flags + " --user-data-dir='" + (folder.path() / "profile").string() +
      "' --dump-dom 'file://" + page.string() + "' 2>/dev/null";
  std::string document;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return document;
  std::array<char, 65536> buffer{};
  for (std::size_t n; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    document.append(buffer.data(), n);
  pclose(pipe);
  return document;
}

std::string root_tag(const std::string& document) {
  const std::size_t begin = document.find("<html");
  return begin == std::string::npos ? ""
                                    : document.substr(begin, document.find('>', begin) - begin + 1);
}

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++found;
  return found;
}

}  // namespace cousin
