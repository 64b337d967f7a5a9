#pragma once

#include <string>
#include <vector>

#include "sim/types/seams.h"

namespace cousin {

/// How much larger a board was printed than it should be, as its ruler tells.
struct PrintScale {
  double factor = 1;  ///< printed over nominal
  double sigma = 0;   ///< standard deviation of `factor`
  std::string from;   ///< what it rests on, a sentence
};

/// "99.7", what a ruler or caliper reads for the printed 100 mm; "149.6/150" of another length.
/// @param reading_sigma_mm  of that reading
/// @throws std::invalid_argument naming the text, or a print off by more than a fifth
PrintScale print_scale_of_ruler(const std::string& text, double reading_sigma_mm);
/// A print that nobody has checked: most are within half a per cent.
PrintScale unchecked_print();
/// A simulated board has the size that it should have.
PrintScale exact_print();

/// What one capture gave.
struct MeasuredSample {
  std::string name;
  std::string source;  ///< name of what the sample is one of, which groups compare
  Traits traits;       ///< as if the board were of its nominal size
  PrintScale scale;
};

/// A number of the table.
struct MeasuredRow {
  std::string sample, source;
  int seed = 0;
  std::string trait;           ///< "" of a seed that is not measured
  std::string unit;            ///< of the trait, SI: m, m2, m3
  double value = kNaN;         ///< in length_unit(unit).millimetres, at the print's true size
  double low = kNaN;           ///< of the 95 % interval; NaN where no deviation is known
  double high = kNaN;          ///< with the deviation of the print's scale
  double own_sigma = kNaN;     ///< likewise, without that of the scale, which seeds share
  std::string status, reason;  ///< "ok", or "not_solved" and why
};

/// A row a trait of each seed; one row with a reason for a seed that is seen and not measured.
std::vector<MeasuredRow> measured_rows(const MeasuredSample& sample);

int count_measured(const Traits& traits);

/// specimens.csv: sample, [group,] seed, trait, unit, value, low, high, status, reason; a tidy
/// table in millimetres, square and cubic ones. @param group  heading of the column that has each
/// sample's source; "" = no such column
std::string to_tidy_csv(const std::vector<MeasuredRow>& rows, const std::string& group);

}  // namespace cousin
