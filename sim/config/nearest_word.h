#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

namespace cousin {

/// Least number of letters put in, left out or changed, or of neighbours swapped, between two words
/// (optimal string alignment).
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> two_above, above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({changed, above[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], two_above[j - 2] + 1);
    }
    two_above = above;
    above = row;
  }
  return above[b.size()];
}

/// Edits that a slip of the fingers makes in a word of that many letters: one for each four.
inline std::size_t likely_edits(std::size_t letters) { return (letters + 1) / 4; }

/// Whether who typed `given` may have meant `word`.
inline bool may_mean(std::string_view given, std::string_view word) {
  return edit_distance(given, word) <= likely_edits(std::min(given.size(), word.size()));
}

}  // namespace cousin
