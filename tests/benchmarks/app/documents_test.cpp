// Every command of README.md and docs/ is one that the program takes. Long ones are asked for their
// plan or their list of jobs. Files of a reader's own are absent here, and that is all that may be
// said of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// The words of a shell line up to a comment or a pipe; quotes are single.
Words words_of(const std::string& line) {
  Words words;
  std::string word;
  bool is_quoted = false, has_word = false;
  for (const char c : line) {
    if (c == '\'') {
      is_quoted = !is_quoted;
      has_word = true;
    } else if (!is_quoted && c == ' ') {
      if (has_word) words.push_back(word);
      word.clear();
      has_word = false;
    } else if (!is_quoted && !has_word && (c == '#' || c == '|')) {
      return words;
    } else {
      word += c;
      has_word = true;
    }
  }
  if (has_word) words.push_back(word);
  return words;
}

struct DocumentedCommand {
  std::string where;  ///< "README.md:42"
  Words words;        ///< without "cousin"
};

/// The lines that begin with "cousin " in blocks of ```sh.
std::vector<DocumentedCommand> commands_of(const fs::path& file) {
  std::vector<DocumentedCommand> commands;
  std::istringstream lines(read_file(file));
  bool is_shell = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const int first = number;
    if (line.starts_with("```")) is_shell = line == "```sh";
    if (!is_shell || !line.starts_with("cousin ")) continue;
    for (std::string more; line.ends_with('\\') && std::getline(lines, more); ++number) {
      line.pop_back();
      line += more;
    }
    Words words = words_of(line);
    words.erase(words.begin());
    commands.push_back({file.filename().string() + ":" + std::to_string(first), std::move(words)});
  }
  return commands;
}

bool is_of_an_absent_file(const std::string& message) {
  for (const char* words : {"not a folder", "no such folder", "no such file", "there is no file",
                            "is no file", "does not exist", "No such file", "no file or folder"}) {
    if (message.find(words) != std::string::npos) return true;
  }
  return false;
}

TEST(AppDocuments, EveryCommandIsOneThatTheProgramTakes) {
  std::vector<fs::path> files = {source_folder() / "README.md"};
  for (const auto& entry : fs::directory_iterator(source_folder() / "docs")) {
    if (entry.path().extension() == ".md") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  const Program program;
  int tried = 0;
  for (const fs::path& file : files) {
    for (DocumentedCommand& command : commands_of(file)) {
      SCOPED_TRACE(command.where);
      Words& words = command.words;
      const auto has = [&](const char* word) {
        return std::find(words.begin(), words.end(), word) != words.end();
      };
      if ((words[0] == "run" || words[0] == "render") && !has("--plan") && !has("--keys"))
        words.emplace_back("--plan");
      if (words[0] == "bench" && !has("--list")) words.emplace_back("--list");
      const Outcome outcome = program.run(words);
      ++tried;
      const bool is_plain_suite = outcome.err.find("takes no --list") != std::string::npos;
      const bool is_absent_part = outcome.err.find("not built in") != std::string::npos;
      EXPECT_TRUE(outcome.code == 0 || is_plain_suite || is_absent_part ||
                  is_of_an_absent_file(outcome.err))
          << outcome.err;
    }
  }
  EXPECT_GT(tried, 100);
}

}  // namespace
}  // namespace cousin
