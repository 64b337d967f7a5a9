#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace cousin {

/// One value of a factor.
struct Level {
  std::string word;                    ///< of the level, in names of jobs
  std::vector<std::string> sets = {};  ///< key=value; {FACTOR} in them is the word of its level
};

/// What a grid varies: a configuration key, or something else that the suite knows by name.
struct Factor {
  std::string name;
  std::vector<Level> levels;
};
/// Values of a configuration key; one value fixes it.
Factor key_factor(const std::string& key, const std::vector<std::string>& values);
/// Levels that set no key.
Factor named_factor(const std::string& name, const std::vector<std::string>& words);
/// Numbers from `first` up to and without `end`; they set no key.
Factor number_factor(const std::string& name, int first, int end);

/// One place of a grid.
struct GridJob {
  /// The level of a factor that the job has.
  struct Place {
    std::string factor, word;
    std::size_t level = 0;  ///< from 0, in the factor's list
  };
  std::string name;               ///< letters, digits, . _ -
  std::vector<std::string> sets;  ///< key=value of all levels, in the order of the factors
  std::vector<Place> places;      ///< one a factor
  std::size_t block = 0;          ///< of the grid, from 0

  bool has(const std::string& factor) const;
  /// @throws std::invalid_argument naming the job and the factor, if it has none of that name
  const Place& at(const std::string& factor) const;
  /// The word at the factor as a whole number. @throws as at(), or if it is none
  int number(const std::string& factor) const;
};

/// The product of some factors; the last one changes fastest. Without factors: one job.
struct GridBlock {
  std::string name;  ///< of the jobs: {FACTOR} is the word of its level, as "{cultivar}_run{run}"
  std::vector<Factor> factors;
  std::function<bool(const GridJob&)> where = {};  ///< places that are jobs; empty: all
};
/// Blocks one after another.
using Grid = std::vector<GridBlock>;

/// The jobs of a grid in order. What a file name may not hold is "_" in a job's name.
/// @throws std::invalid_argument naming the pattern and the factor that the block does not have, or
/// the name that two jobs have
std::vector<GridJob> jobs_of(const Grid& grid);

}  // namespace cousin
