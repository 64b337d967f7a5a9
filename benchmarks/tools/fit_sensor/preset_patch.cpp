#include "benchmarks/tools/fit_sensor/preset_patch.h"

#include <algorithm>
#include <stdexcept>

namespace cousin {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Brackets that a line opens less those that it closes, outside of strings and comments.
int open_brackets(std::string_view line) {
  int open = 0;
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0) {
      if (c == '\\' && quote == '"')
        ++i;
      else if (c == quote)
        quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '#') {
      break;
    } else if (c == '[' || c == '{') {
      ++open;
    } else if (c == ']' || c == '}') {
      --open;
    }
  }
  return open;
}

enum class LineKind { blank, comment, table, key };

/// Lines of a text, each with what it is; a value over several lines is one.
struct Line {
  LineKind kind = LineKind::blank;
  std::string text;  ///< with its line ends but the last
  std::string key;   ///< dotted, of a key
};

std::vector<Line> lines_of(std::string_view toml) {
  std::vector<Line> lines;
  std::string table;
  while (!toml.empty()) {
    const std::size_t length = std::min(toml.find('\n'), toml.size());
    Line line;
    line.text = std::string(toml.substr(0, length));
    toml.remove_prefix(std::min(length + 1, toml.size()));
    const std::string_view words = trimmed(line.text);
    if (words.starts_with('#')) {
      line.kind = LineKind::comment;
    } else if (words.starts_with('[')) {
      line.kind = LineKind::table;
      table = std::string(words.substr(1, words.find(']') - 1)) + ".";
    } else if (const auto equals = words.find('='); equals != std::string_view::npos) {
      line.kind = LineKind::key;
      line.key = table + std::string(trimmed(words.substr(0, equals)));
      for (int open = open_brackets(line.text); open > 0 && !toml.empty();) {
        const std::size_t more = std::min(toml.find('\n'), toml.size());
        open += open_brackets(toml.substr(0, more));
        line.text += "\n" + std::string(toml.substr(0, more));
        toml.remove_prefix(std::min(more + 1, toml.size()));
      }
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

bool has_key(std::string_view toml, std::string_view key) {
  const std::vector<Line> lines = lines_of(toml);
  return std::any_of(lines.begin(), lines.end(), [&](const Line& l) { return l.key == key; });
}

std::string patched_preset(std::string_view toml, const std::vector<PresetPatch>& patches) {
  for (const PresetPatch& patch : patches) {
    if (!has_key(toml, patch.key))
      throw std::invalid_argument("preset: there is no key " + patch.key);
  }
  const std::vector<Line> lines = lines_of(toml);
  std::string out, pending, theirs, shown;  // comments: read, in force, last written
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Line& line = lines[i];
    if (line.kind == LineKind::comment) {
      pending += line.text + "\n";
      continue;
    }
    if (line.kind != LineKind::key) {
      out += pending + line.text + "\n";
      if (line.kind == LineKind::table) theirs = shown = {};
      pending.clear();
      continue;
    }
    if (!pending.empty()) theirs = pending;
    pending.clear();
    const auto patch = std::find_if(patches.begin(), patches.end(),
                                    [&](const PresetPatch& p) { return p.key == line.key; });
    const bool is_patched = patch != patches.end();
    const std::string comment = is_patched ? "# " + patch->comment + "\n" : theirs;
    if (comment != shown) out += comment;
    shown = comment;
    const auto dot = line.key.rfind('.');
    out += is_patched ? line.key.substr(dot == std::string::npos ? 0 : dot + 1) + " = " +
                            patch->value + "\n"
                      : line.text + "\n";
  }
  return out + pending;
}

}  // namespace cousin
