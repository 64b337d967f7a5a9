#include "benchmarks/app/command_line_mistakes.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "sim/config/nearest_word.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

/// "; did you mean --out?" where an option has nearly that name or starts with it, else "".
std::string nearest_option(const std::string& word, const std::vector<const CLI::App*>& apps) {
  std::string nearest;
  std::size_t least = std::string::npos;
  for (const CLI::App* app : apps) {
    for (const CLI::Option* option : app->get_options()) {
      for (const std::string& name : option->get_lnames()) {
        const bool begins = name.starts_with(word);
        const std::size_t distance = begins ? 0 : edit_distance(word, name);
        if ((begins || may_mean(word, name)) && distance < least) {
          least = distance;
          nearest = name;
        }
      }
    }
  }
  return nearest.empty() ? "" : "; did you mean --" + nearest + "?";
}

/// "; `cousin run` and `cousin perceive` have it" of an option that is another verb's, else "".
std::string verbs_that_have(const std::string& word, const CLI::App& app) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands(nullptr)) {
    for (const CLI::Option* option : verb->get_options()) {
      const auto& names = option->get_lnames();
      if (std::find(names.begin(), names.end(), word) != names.end())
        verbs.push_back("`cousin " + verb->get_name() + "`");
    }
  }
  if (verbs.empty()) return {};
  std::string list;
  for (std::size_t i = 0; i < verbs.size(); ++i)
    list += (i == 0 ? "" : i + 1 == verbs.size() ? " and " : ", ") + verbs[i];
  return "; " + list + (verbs.size() == 1 ? " has it" : " have it");
}

/// "; did you mean run?" where a verb has nearly that name, else "".
std::string nearest_verb(const std::string& given, const CLI::App& app) {
  std::string nearest;
  std::size_t least = std::string::npos;
  for (const CLI::App* verb : app.get_subcommands(nullptr)) {
    const std::size_t distance = edit_distance(given, verb->get_name());
    if (!may_mean(given, verb->get_name()) || distance >= least) continue;
    least = distance;
    nearest = verb->get_name();
  }
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

/// The first word that stands where the verb takes none; "" if there is none.
std::string word_too_many(const std::vector<CLI::App*>& verbs) {
  if (verbs.empty()) return {};
  for (const CLI::Option* option : verbs.front()->get_options()) {
    const auto most = static_cast<std::size_t>(option->get_items_expected_max());
    if (option->get_positional() && option->results().size() > most) return option->results()[most];
  }
  return {};
}

}  // namespace

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> verbs = app.get_subcommands();
  const std::string command = verbs.empty() ? "cousin" : "cousin " + verbs.front()->get_name();
  std::vector<const CLI::App*> apps = {&app};
  apps.insert(apps.end(), verbs.begin(), verbs.end());
  std::string what = error.what();
  const std::vector<std::string> unused = app.remaining(true);
  const auto option = std::find_if(unused.begin(), unused.end(), [](const std::string& word) {
    return word.size() > 1 && word.front() == '-' && word.find_first_not_of('-') != word.npos;
  });
  if (option != unused.end()) {
    const std::string name = option->substr(0, option->find('='));
    const std::string word = name.substr(name.find_first_not_of('-'));
    const std::string elsewhere = verbs.empty() ? "" : verbs_that_have(word, app);
    what = "unknown option " + name;
    if (!elsewhere.empty()) what += " of `" + command + "`" + elsewhere;
    if (elsewhere.empty()) what += nearest_option(word, apps);
  } else if (verbs.empty() && !unused.empty()) {
    what = "unknown verb \"" + unused.front() + "\"" + nearest_verb(unused.front(), app);
  } else if (!unused.empty()) {
    what = "\"" + unused.front() + "\" is one word too many";
  } else if (const std::string extra = word_too_many(verbs); !extra.empty()) {
    what = "\"" + extra + "\" is one word too many";
  } else if (const auto missing = what.find(": 1 required"); missing != std::string::npos) {
    what = what.substr(0, missing) + ": its value is missing";
  }
  return "cousin: " + terminal_text(what) + "\nSee `" + command + " --help`.\n";
}

}  // namespace cousin
