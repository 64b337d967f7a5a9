#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

namespace cousin {

/// Private to sim/dataset: times of pictures and poses, which other programs write as seconds or as
/// nanoseconds since 1970.

/// Seconds since 1970 are known to 0.24 microseconds by a double, so that no time is compared
/// exactly.
inline constexpr double kTimeRounding_s = 1e-6;
/// A depth image so near to a colour image is its own, as in TUM's associate.py.
inline constexpr double kMostApart_s = 0.02;
inline constexpr double kMostSeconds = 1e11;       ///< since 1970: the year 5138
inline constexpr double kLeastNanoseconds = 1e17;  ///< since 1970: the year 1973

/// Nothing for a number that is neither seconds nor nanoseconds.
inline std::optional<double> seconds_of_stamp(double stamp) {
  if (std::abs(stamp) < kMostSeconds) return stamp;
  if (stamp >= kLeastNanoseconds && stamp < 1e19) return 1e-9 * stamp;
  return std::nullopt;
}

/// The first record not before the time. Records have a `time_s` that increases.
template <class Record>
auto first_from(const std::vector<Record>& records, double time_s) {
  return std::lower_bound(records.begin(), records.end(), time_s,
                          [](const Record& record, double t) { return record.time_s < t; });
}

/// The record nearest in time; the end of `records` if there is none within `most_apart_s`.
template <class Record>
auto nearest(const std::vector<Record>& records, double time_s, double most_apart_s) {
  const auto after = first_from(records, time_s);
  auto best = records.end();
  const auto consider = [&](auto record) {
    const double apart_s = std::abs(record->time_s - time_s);
    if (apart_s > most_apart_s + kTimeRounding_s) return;
    if (best == records.end() || apart_s < std::abs(best->time_s - time_s)) best = record;
  };
  if (after != records.begin()) consider(std::prev(after));
  if (after != records.end()) consider(after);
  return best;
}

}  // namespace cousin
