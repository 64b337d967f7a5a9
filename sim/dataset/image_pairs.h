#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// Private to sim/dataset: pictures that belong together, such as colour and depth, left and right.

/// What the halves of pairs are called: names of folders, or words that a file's name begins or
/// ends with. All in lower case.
struct PairNames {
  std::vector<std::string_view> first_folders, second_folders;
  std::vector<std::string_view> first_words, second_words;
  std::vector<std::string_view> first_endings, second_endings;  ///< ".png", ...
};

/// Numbers within names count as numbers: "2" is before "10".
struct NumberOrder {
  bool operator()(const std::string& a, const std::string& b) const;
};
/// A half's files by what their names share with the other half's: "000012" of 000012.png,
/// "frame-000012" of frame-000012.color.png.
using FilesByKey = std::map<std::string, std::filesystem::path, NumberOrder>;

struct PictureHalves {
  std::string first_name, second_name;  ///< folder or word, as "left" or "image_2"
  FilesByKey first, second;
  std::vector<std::string> warnings;  ///< pictures that are not read, halves that are not taken
};

/// The halves in subfolders of `folder` (their pictures may lie in a folder data/ there), else
/// among its own files. Of several rows of `names` that are there the first is taken.
/// @param what  "a folder rgb/ ... beside depth/", for the message where there are none.
/// @throws std::runtime_error naming the folder; two folders or two files of the same half;
/// a link that leads out.
PictureHalves find_halves(const std::filesystem::path& folder, std::span<const PairNames> names,
                          const std::string& what);

/// The part of a stem that is not `word` and what parts it from the rest: "frame-000012" of
/// "frame-000012.color", "01" of "left01"; nothing where the stem neither begins nor ends with it.
std::optional<std::string> without_word(std::string_view stem, std::string_view word);

/// Seconds of a name that is a time stamp: a number with a dot, or nanoseconds since 1970.
std::optional<double> time_of_name(const std::string& key);
/// Seconds of all names where each is a time stamp; else 0, 1, 2, ...
std::vector<double> times_of_names(const std::vector<std::string>& keys);

}  // namespace cousin
