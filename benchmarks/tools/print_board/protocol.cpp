#include <string>

#include "benchmarks/tools/print_board/board_page.h"

namespace cousin {
namespace {

struct Line {
  enum class Kind { title, head, text } kind;
  std::string words;
};

std::vector<Line> printing(const BoardPage& board) {
  const std::string length = std::to_string(static_cast<int>(board.ruler_mm));
  return {
      {Line::Kind::title, "How to use this board"},
      {Line::Kind::head, "1. Print"},
      {Line::Kind::text, "Print page 1 on " + board.paper + " paper at 100 % (\"actual size\")."},
      {Line::Kind::text, "Use a laser printer and matt paper: gloss hides what is below it."},
      {Line::Kind::head, "2. Check the ruler"},
      {Line::Kind::text, "Measure the ruler below the board with a caliper or a steel ruler."},
      {Line::Kind::text, "It must be " + length + ".0 mm long. A ruler of " + length +
                             ".0 x (1 + e) makes all sizes wrong by e."},
      {Line::Kind::text, "Measure it along the paper and, on a turned sheet, across it."},
      {Line::Kind::head, "3. Make it flat"},
      {Line::Kind::text, "Glue the sheet to glass, acrylic or a tile. Paper alone is not flat:"},
      {Line::Kind::text, "a sag of 0.5 mm over 100 mm is seen in the results."},
      {Line::Kind::text, "Leave the white border: detection needs it."}};
}

std::vector<Line> seeds_lines() {
  return {
      {Line::Kind::title, "How to photograph seeds"},
      {Line::Kind::head, "4. Lay out the seeds"},
      {Line::Kind::text, "Cut the plate at its marks. Put the seeds on the squares, each apart:"},
      {Line::Kind::text, "none on a marker in a corner, none closer than a seed to another."},
      {Line::Kind::head, "5. Light"},
      {Line::Kind::text, "Even light: a window in the shade or two lamps from both sides."},
      {Line::Kind::text, "No flash, no sun: hard shadows and mirrors of light move outlines."},
      {Line::Kind::head, "6. Photographs"},
      {Line::Kind::text, "Lock focus and exposure. Do not zoom. Keep the phone's 1x lens."},
      {Line::Kind::text, "Walk round the board three times, about 20 photographs a ring:"},
      {Line::Kind::text, "  0.75 m away, looking down by 15 degrees; 0.55 m, 35; 0.33 m, 60."},
      {Line::Kind::text, "The whole board is in every picture. A slow video does as well."},
      {Line::Kind::head, "7. Measure"},
      {Line::Kind::text,
       "cousin import photos --format folder --intrinsics camera.yaml --out real"},
      {Line::Kind::text, "cousin perceive real --pipeline seeds --out measured"}};
}

std::vector<Line> camera_lines(const std::string& board) {
  return {
      {Line::Kind::title, "How to photograph the board"},
      {Line::Kind::head, "4. Light"},
      {Line::Kind::text, "Even light, no mirror of a lamp on the print, no flash."},
      {Line::Kind::head, "5. Photographs"},
      {Line::Kind::text, "Lock focus and exposure. Do not zoom."},
      {Line::Kind::text, "20 to 40 photographs, board or camera at rest in each of them:"},
      {Line::Kind::text, "  the board in the middle, in every corner and at every edge;"},
      {Line::Kind::text, "  tilted by 20 to 45 degrees to all four sides; turned by 90 degrees;"},
      {Line::Kind::text, "  from so near that it fills the picture to twice that distance."},
      {Line::Kind::head, "6. Calibrate"},
      {Line::Kind::text, "cousin calibrate photos --board " + board + " --out calibration"},
      {Line::Kind::text, "Its page says what the calibration is worth and which view to add."}};
}

PrintPage laid_out(const std::vector<Line>& lines, const PrintPage& paper) {
  PrintPage page;
  page.width_mm = paper.width_mm;
  page.height_mm = paper.height_mm;
  const double scale = paper.width_mm < 200 ? 0.7 : 1;
  double base_mm = 22 * scale;
  for (const Line& line : lines) {
    const bool is_title = line.kind == Line::Kind::title, is_head = line.kind == Line::Kind::head;
    if (is_head) base_mm += 5 * scale;
    page.texts.push_back({20 * scale, base_mm,
                          (is_title  ? 7
                           : is_head ? 5
                                     : 4.2) *
                              scale,
                          line.words});
    base_mm += (is_title ? 10 : 7) * scale;
  }
  return page;
}

}  // namespace

std::vector<PrintPage> protocol_pages(const CalibrationTarget& target, const BoardPage& board) {
  const bool for_seeds = target.kind == TargetKind::seed_board;
  return {laid_out(printing(board), board.page),
          laid_out(for_seeds ? seeds_lines() : camera_lines(board.name), board.page)};
}

}  // namespace cousin
