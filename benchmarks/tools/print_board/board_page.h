#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "benchmarks/tools/print_board/page.h"
#include "sim/types/calibration_target.h"

namespace cousin {

struct Paper {
  std::string_view name;
  double width_mm = 0, height_mm = 0;  ///< upright
};
/// From the smallest to the largest: those of ISO 216 from A5 to A0, and of ANSI.
const std::vector<Paper>& papers();
/// @throws std::invalid_argument listing the names that exist
const Paper& paper_of(std::string_view name);

/// A board on a sheet.
struct BoardPage {
  PrintPage page;
  std::string name;  ///< of the board, as `calibrate --board` takes it
  std::string paper;
  double left_mm = 0, top_mm = 0;  ///< of the print on the page
  double ruler_mm = 0;             ///< length of the ruler beside it
};

/// The print in its true size in the middle of the sheet, upright or lying, as it fits; below it a
/// ruler, what the board is as text, and its name. Marks where a seed board is cut stand outside of
/// it. A margin of 5 mm stays free, which printers do not reach.
/// @param paper  "" is the smallest that it fits on
/// @throws std::invalid_argument naming the sizes, and the smallest paper that is large enough
BoardPage board_page(const CalibrationTarget& target, const std::string& name,
                     const std::string& paper);

/// Two pages: how to print the board, check it, light it and photograph it. On the same paper.
std::vector<PrintPage> protocol_pages(const CalibrationTarget& target, const BoardPage& board);

}  // namespace cousin
