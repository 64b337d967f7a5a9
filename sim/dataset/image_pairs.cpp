#include "sim/dataset/image_pairs.h"

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/picture_list.h"
#include "sim/dataset/time_stamps.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The digits at the start, without leading zeros.
std::string_view leading_number(std::string_view text) {
  std::size_t end = 0;
  while (end < text.size() && is_digit(text[end])) ++end;
  text = text.substr(0, end);
  while (text.size() > 1 && text.front() == '0') text.remove_prefix(1);
  return text;
}

std::string_view after_digits(std::string_view text) {
  while (!text.empty() && is_digit(text.front())) text.remove_prefix(1);
  return text;
}

/// One half where it was found.
struct Half {
  std::string name;
  FilesByKey files;
};

void add_file(const fs::path& file, const std::string& key, FilesByKey& files) {
  const auto [at, is_new] = files.emplace(key, file);
  if (!is_new)
    throw std::runtime_error(file.string() + " and " + at->second.string() +
                             ": two pictures of one name; keep one of them");
}

/// The key of a picture in the folder of its half: the half's word may be in its name.
std::string key_in_folder(const fs::path& file, const std::vector<std::string_view>& words) {
  const std::string stem = file.stem().string();
  for (const std::string_view word : words) {
    const std::optional<std::string> key = without_word(stem, word);
    if (key && !key->empty()) return *key;
  }
  return stem;
}

/// The one of the names that is a folder in `folder`, whatever its case; "" if none is.
std::string subfolder_of(const fs::path& folder, const std::vector<std::string>& folders,
                         const std::vector<std::string_view>& names) {
  std::string found;
  for (const std::string& name : folders) {
    if (std::find(names.begin(), names.end(), lower_case(name)) == names.end()) continue;
    if (!found.empty())
      throw std::runtime_error((folder / found).string() + " and " + (folder / name).string() +
                               ": two folders for the same pictures; keep one of them");
    found = name;
  }
  return found;
}

Half half_in_folder(const fs::path& folder, const std::string& name,
                    const std::vector<std::string_view>& words,
                    const std::vector<std::string_view>& endings,
                    std::vector<std::string>& warnings) {
  fs::path inside = resolve_inside(folder, name);
  PictureList list = list_pictures(inside, endings);
  if (list.files.empty() && fs::is_directory(inside / "data")) {
    inside = resolve_inside(folder, fs::path(name) / "data");
    list = list_pictures(inside, endings);
  }
  if (list.files.empty())
    throw std::runtime_error(inside.string() + ": no picture in this folder" +
                             (list.not_read.empty() ? "" : "; " + list.not_read));
  if (!list.not_read.empty()) warnings.push_back(inside.string() + ": " + list.not_read);
  Half half{name, {}};
  for (const fs::path& file : list.files) add_file(file, key_in_folder(file, words), half.files);
  return half;
}

/// The files that have a word of a half in their names.
Half half_among(const std::vector<fs::path>& files, const std::vector<std::string_view>& words) {
  Half half;
  for (const fs::path& file : files) {
    for (const std::string_view word : words) {
      const std::optional<std::string> key = without_word(file.stem().string(), word);
      if (!key) continue;
      add_file(file, *key, half.files);
      half.name = word;
      break;
    }
  }
  return half;
}

std::vector<fs::path> with_endings(const std::vector<fs::path>& files,
                                   const std::vector<std::string_view>& endings) {
  std::vector<fs::path> result;
  for (const fs::path& file : files) {
    const std::string ending = lower_case(file.extension().string());
    if (std::find(endings.begin(), endings.end(), ending) != endings.end()) result.push_back(file);
  }
  return result;
}

std::vector<std::string> folders_in(const fs::path& folder) {
  constexpr std::size_t kMostEntries = 10'000'000;
  std::vector<std::string> names;
  std::size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (++count > kMostEntries)
      throw std::runtime_error(folder.string() + ": more than 10000000 files in one folder");
    std::error_code ignored;
    if (entry.is_directory(ignored)) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<PictureHalves> halves_in_folders(const fs::path& folder,
                                               std::span<const PairNames> names) {
  const std::vector<std::string> folders = folders_in(folder);
  std::optional<PictureHalves> result;
  for (const PairNames& row : names) {
    const std::string first = subfolder_of(folder, folders, row.first_folders);
    const std::string second = subfolder_of(folder, folders, row.second_folders);
    if (first.empty() || second.empty()) continue;
    if (result) {
      result->warnings.push_back(folder.string() + ": " + first + "/ and " + second +
                                 "/ are not used: " + result->first_name + "/ and " +
                                 result->second_name + "/ are");
      continue;
    }
    result.emplace();
    Half a = half_in_folder(folder, first, row.first_words, row.first_endings, result->warnings);
    Half b = half_in_folder(folder, second, row.second_words, row.second_endings, result->warnings);
    result->first_name = a.name;
    result->second_name = b.name;
    result->first = std::move(a.files);
    result->second = std::move(b.files);
  }
  return result;
}

std::optional<PictureHalves> halves_among_files(const fs::path& folder,
                                                std::span<const PairNames> names) {
  for (const PairNames& row : names) {
    std::vector<std::string_view> endings = row.first_endings;
    endings.insert(endings.end(), row.second_endings.begin(), row.second_endings.end());
    const PictureList list = list_pictures(folder, endings);
    Half first = half_among(with_endings(list.files, row.first_endings), row.first_words);
    Half second = half_among(with_endings(list.files, row.second_endings), row.second_words);
    if (first.files.empty() || second.files.empty()) continue;
    return PictureHalves{
        first.name, second.name, std::move(first.files), std::move(second.files), {}};
  }
  return std::nullopt;
}

}  // namespace

bool NumberOrder::operator()(const std::string& a, const std::string& b) const {
  std::string_view left = a, right = b;
  while (!left.empty() && !right.empty()) {
    if (is_digit(left.front()) && is_digit(right.front())) {
      const std::string_view x = leading_number(left), y = leading_number(right);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
      left = after_digits(left);
      right = after_digits(right);
    } else {
      if (left.front() != right.front()) return left.front() < right.front();
      left.remove_prefix(1);
      right.remove_prefix(1);
    }
  }
  if (left.empty() != right.empty()) return left.empty();
  return a < b;  // the same numbers with other zeros before them
}

std::optional<std::string> without_word(std::string_view stem, std::string_view word) {
  const auto is_separator = [](char c) { return c == '.' || c == '_' || c == '-'; };
  const std::string lower = lower_case(stem);
  if (lower == word) return std::string();
  if (lower.ends_with(word)) {
    std::string_view rest = stem.substr(0, stem.size() - word.size());
    if (is_separator(rest.back())) return std::string(rest.substr(0, rest.size() - 1));
  }
  if (lower.starts_with(word)) {
    const std::string_view rest = stem.substr(word.size());
    if (is_separator(rest.front())) return std::string(rest.substr(1));
    if (is_digit(rest.front()) && !is_digit(word.back())) return std::string(rest);
  }
  return std::nullopt;
}

std::optional<double> time_of_name(const std::string& key) {
  double value = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), value);
  if (error != std::errc{} || end != key.data() + key.size() || key.starts_with('-'))
    return std::nullopt;
  if (key.find('.') == std::string::npos && value < kLeastNanoseconds) return std::nullopt;
  return seconds_of_stamp(value);
}

std::vector<double> times_of_names(const std::vector<std::string>& keys) {
  std::vector<double> times, places;
  for (const std::string& key : keys) {
    if (const std::optional<double> time = time_of_name(key)) times.push_back(*time);
    places.push_back(static_cast<double>(places.size()));
  }
  return times.size() == keys.size() ? times : places;
}

PictureHalves find_halves(const fs::path& folder, std::span<const PairNames> names,
                          const std::string& what) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": not a folder");
  if (std::optional<PictureHalves> found = halves_in_folders(folder, names)) return *found;
  if (std::optional<PictureHalves> found = halves_among_files(folder, names)) return *found;
  throw std::runtime_error(folder.string() + ": holds no " + what);
}

}  // namespace cousin
