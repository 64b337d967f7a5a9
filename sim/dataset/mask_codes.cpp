#include "sim/dataset/mask_codes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace cousin {
namespace {

/// Right, down, left, up: each is the right turn of the one before.
const std::array<Eigen::Vector2i, 4> kSteps = {Eigen::Vector2i(1, 0), Eigen::Vector2i(0, 1),
                                               Eigen::Vector2i(-1, 0), Eigen::Vector2i(0, -1)};
/// The mask's pixel on the right of an edge that starts at a corner.
const std::array<Eigen::Vector2i, 4> kRightPixel = {
    Eigen::Vector2i(0, 0), Eigen::Vector2i(-1, 0), Eigen::Vector2i(-1, -1), Eigen::Vector2i(0, -1)};

bool is_inside(const Image<std::uint8_t>& mask, int x, int y) {
  return mask.contains(x, y) && mask(x, y) != 0;
}

/// Edges that leave each corner of the pixels, a bit a direction, with the mask on their right.
Image<std::uint8_t> edges_of(const Image<std::uint8_t>& mask) {
  Image<std::uint8_t> edges(mask.width() + 1, mask.height() + 1);
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!is_inside(mask, x, y)) continue;
      const auto add = [&](int ex, int ey, unsigned direction) {
        edges(ex, ey) = static_cast<std::uint8_t>(edges(ex, ey) | (1U << direction));
      };
      if (!is_inside(mask, x, y - 1)) add(x, y, 0);
      if (!is_inside(mask, x + 1, y)) add(x + 1, y, 1);
      if (!is_inside(mask, x, y + 1)) add(x + 1, y + 1, 2);
      if (!is_inside(mask, x - 1, y)) add(x, y + 1, 3);
    }
  }
  return edges;
}

/// Where a line goes on from a corner: to the right if it can, so that where two pixels touch by a
/// corner it stays with its pixel.
unsigned next_direction(std::uint8_t leaving, unsigned direction) {
  for (const unsigned turn : {1U, 0U, 3U}) {
    const unsigned next = (direction + turn) % 4;
    if ((leaving & (1U << next)) != 0) return next;
  }
  throw std::logic_error("a mask's edges do not close");
}

/// The closed line that starts with an edge; its edges are marked in `used`.
PixelOutline follow(const Image<std::uint8_t>& edges, Image<std::uint8_t>& used,
                    const Eigen::Vector2i& start, unsigned first) {
  PixelOutline line;
  Eigen::Vector2i at = start;
  unsigned direction = first;
  do {
    std::uint8_t& here = used(at.x(), at.y());
    here = static_cast<std::uint8_t>(here | (1U << direction));
    line.push_back(at);
    at += kSteps[direction];
    direction = next_direction(edges(at.x(), at.y()), direction);
  } while (at != start || direction != first);
  return line;
}

PixelOutline corners_of(const PixelOutline& line) {
  PixelOutline corners;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector2i before = line[i] - line[(i + line.size() - 1) % line.size()];
    const Eigen::Vector2i after = line[(i + 1) % line.size()] - line[i];
    if (before != after) corners.push_back(line[i]);
  }
  return corners;
}

std::int64_t doubled_area(const PixelOutline& line) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector2i &a = line[i], &b = line[(i + 1) % line.size()];
    sum += std::int64_t{a.x()} * b.y() - std::int64_t{b.x()} * a.y();
  }
  return sum;
}

/// Number of the part that each pixel belongs to, -1 = none.
Image<int> parts_of(const Image<std::uint8_t>& mask) {
  Image<int> part(mask.width(), mask.height(), -1);
  std::vector<Eigen::Vector2i> todo;
  int count = 0;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!is_inside(mask, x, y) || part(x, y) >= 0) continue;
      part(x, y) = count;
      todo.emplace_back(x, y);
      while (!todo.empty()) {
        const Eigen::Vector2i at = todo.back();
        todo.pop_back();
        for (const Eigen::Vector2i& step : kSteps) {
          const Eigen::Vector2i next = at + step;
          if (!is_inside(mask, next.x(), next.y()) || part(next.x(), next.y()) >= 0) continue;
          part(next.x(), next.y()) = count;
          todo.push_back(next);
        }
      }
      ++count;
    }
  }
  return part;
}

/// `line` with `other` put in, there and back along a cut between their nearest corners.
void join(PixelOutline& line, const PixelOutline& other) {
  std::size_t best_i = 0, best_j = 0;
  std::int64_t best = std::numeric_limits<std::int64_t>::max();
  for (std::size_t i = 0; i < line.size(); ++i) {
    for (std::size_t j = 0; j < other.size(); ++j) {
      const Eigen::Vector2i d = line[i] - other[j];
      const std::int64_t distance = std::int64_t{d.x()} * d.x() + std::int64_t{d.y()} * d.y();
      if (distance >= best) continue;
      best = distance;
      best_i = i;
      best_j = j;
    }
  }
  const auto at = [](std::size_t i) { return static_cast<std::ptrdiff_t>(i); };
  PixelOutline put(other.begin() + at(best_j), other.end());
  put.insert(put.end(), other.begin(), other.begin() + at(best_j) + 1);
  put.push_back(line[best_i]);
  line.insert(line.begin() + at(best_i) + 1, put.begin(), put.end());
}

/// A run length in characters; `before` = the run two earlier, or 0.
void append(std::string& text, std::int64_t run, std::int64_t before) {
  std::int64_t x = run - before;
  bool more = true;
  while (more) {
    auto bits = static_cast<unsigned>(x & 0x1f);
    x >>= 5;
    more = (bits & 0x10) != 0 ? x != -1 : x != 0;
    if (more) bits |= 0x20;
    text += static_cast<char>(bits + 48);
  }
}

// ---- reading ------------------------------------------------------------------------------------

/// The box of what is inside, as it grows.
struct PixelBox {
  std::int64_t low_x = std::numeric_limits<std::int64_t>::max(), low_y = low_x;
  std::int64_t high_x = -1, high_y = -1;
  void add(std::int64_t x, std::int64_t y) {
    low_x = std::min(low_x, x);
    low_y = std::min(low_y, y);
    high_x = std::max(high_x, x);
    high_y = std::max(high_y, y);
  }
};

/// An empty mask of the box's size in its place.
PlacedMask mask_in(const PixelBox& box) {
  if (box.high_x < 0) return {};
  const std::int64_t width = box.high_x - box.low_x + 1, height = box.high_y - box.low_y + 1;
  if (width * height > kMostMaskPixels) {
    throw std::invalid_argument("covers a box of " + std::to_string(width) + " x " +
                                std::to_string(height) + " pixels; the limit is " +
                                std::to_string(kMostMaskPixels) + " pixels");
  }
  return {static_cast<int>(box.low_x), static_cast<int>(box.low_y),
          Image<std::uint8_t>(static_cast<int>(width), static_cast<int>(height))};
}

void check_mask_image(int width_px, int height_px) {
  if (width_px >= 1 && width_px <= 65535 && height_px >= 1 && height_px <= 65535) return;
  throw std::invalid_argument("is of an image of " + std::to_string(width_px) + " x " +
                              std::to_string(height_px) + " pixels; a side is 1 to 65535");
}

constexpr int kFiner = 5;  ///< pycocotools' points a pixel

int finer(double coordinate) { return static_cast<int>(kFiner * coordinate + 0.5); }

/// Calls visit(u, v) for the points of a closed polygon on the finer grid, both ends of each side.
template <class Visit>
void walk(const std::vector<Eigen::Vector2d>& polygon, const Visit& visit) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const int ax = finer(a.x()), ay = finer(a.y()), bx = finer(b.x()), by = finer(b.y());
    const int dx = std::abs(bx - ax), dy = std::abs(by - ay), steps = std::max(dx, dy);
    // A side is drawn from its lower end along its longer axis, whichever way it is walked.
    const bool turned = dx >= dy ? ax > bx : ay > by;
    const int fx = turned ? bx : ax, fy = turned ? by : ay;
    const int tx = turned ? ax : bx, ty = turned ? ay : by;
    const double slope = steps == 0 ? 0
                         : dx >= dy ? static_cast<double>(ty - fy) / dx
                                    : static_cast<double>(tx - fx) / dy;
    for (int step = 0; step <= steps; ++step) {
      const int t = turned ? steps - step : step;
      if (dx >= dy) {
        visit(fx + t, static_cast<int>(fy + slope * t + 0.5));
      } else {
        visit(static_cast<int>(fx + slope * t + 0.5), fy + t);
      }
    }
  }
}

/// Calls cross(x, y) where the polygon's line crosses the middle of column x: pixels from y on are
/// on its other side.
template <class Cross>
void for_each_crossing(const std::vector<Eigen::Vector2d>& polygon, int width_px, int height_px,
                       const Cross& cross) {
  bool has_last = false;
  int last_u = 0, last_v = 0;
  walk(polygon, [&](int u, int v) {
    if (has_last && u != last_u) {
      const double column = (static_cast<double>(u < last_u ? u : u - 1) + 0.5) / kFiner - 0.5;
      if (column == std::floor(column) && column >= 0 && column <= width_px - 1) {
        const double row = (static_cast<double>(std::min(v, last_v)) + 0.5) / kFiner - 0.5;
        cross(static_cast<int>(column),
              static_cast<int>(std::ceil(std::clamp<double>(row, 0, height_px))));
      }
    }
    has_last = true;
    last_u = u;
    last_v = v;
  });
}

void check_length(const std::vector<std::vector<Eigen::Vector2d>>& polygons) {
  constexpr double kMost_px = 2e7, kMostCoordinate = 1e6;
  double length_px = 0;
  for (const auto& polygon : polygons) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Eigen::Vector2d& a = polygon[i];
      if (!(a.cwiseAbs().maxCoeff() <= kMostCoordinate))
        throw std::invalid_argument("has a coordinate outside [-1e6, 1e6]");
      length_px += (polygon[(i + 1) % polygon.size()] - a).cwiseAbs().maxCoeff() + 1;
    }
  }
  if (length_px > kMost_px) throw std::invalid_argument("is longer than 2e7 pixels around");
}

}  // namespace

std::string coco_run_lengths(const Image<std::uint8_t>& mask, int x, int y, int width_px,
                             int height_px) {
  if (x < 0 || y < 0 || x + mask.width() > width_px || y + mask.height() > height_px)
    throw std::invalid_argument("a mask does not lie inside its image");
  std::vector<std::int64_t> runs;
  bool value = false;
  std::int64_t done = 0;  // pixels before the run that is being counted
  for (int u = 0; u < mask.width(); ++u) {
    const std::int64_t column = std::int64_t{x + u} * height_px + y;
    for (int v = 0; v <= mask.height(); ++v) {
      const bool inside = v < mask.height() && mask(u, v) != 0;
      // Below the box is outside, but where the next column of the box follows at once.
      if (v == mask.height() && v == height_px && u + 1 < mask.width()) continue;
      if (inside == value) continue;
      runs.push_back(column + v - done);
      done = column + v;
      value = inside;
    }
  }
  const std::int64_t all = std::int64_t{width_px} * height_px;
  if (runs.empty() || done < all) runs.push_back(all - done);
  std::string text;
  for (std::size_t i = 0; i < runs.size(); ++i) append(text, runs[i], i > 2 ? runs[i - 2] : 0);
  return text;
}

std::vector<std::int64_t> runs_of_coco(std::string_view text) {
  constexpr unsigned kMostCharacters = 12;  // 60 bits
  std::vector<std::int64_t> runs;
  std::int64_t value = 0;
  unsigned digit = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const int code = text[at] - '0';
    if (code < 0 || code > 63 || digit >= kMostCharacters) {
      throw std::invalid_argument("is no compressed run lengths from character " +
                                  std::to_string(at) + " on");
    }
    const auto bits = static_cast<std::int64_t>(code);
    value |= (bits & 0x1f) << (5 * digit++);
    if ((bits & 0x20) != 0) continue;  // more follows
    if ((bits & 0x10) != 0) value -= std::int64_t{1} << (5 * digit);
    if (runs.size() > 2) value += runs[runs.size() - 2];
    if (value < 0 || value > std::int64_t{65535} * 65535) {
      throw std::invalid_argument("has the run " + std::to_string(value) + " before character " +
                                  std::to_string(at + 1) + "; a run is 0 to 65535 x 65535");
    }
    runs.push_back(value);
    value = 0;
    digit = 0;
  }
  if (digit > 0) throw std::invalid_argument("ends within a run length");
  return runs;
}

PlacedMask mask_of_runs(const std::vector<std::int64_t>& runs, int width_px, int height_px) {
  check_mask_image(width_px, height_px);
  const std::int64_t all = std::int64_t{width_px} * height_px;
  PixelBox box;
  std::int64_t done = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i] < 0 || runs[i] > all - done) {
      throw std::invalid_argument("run " + std::to_string(i) + " is " + std::to_string(runs[i]) +
                                  "; the image has " + std::to_string(all - done) +
                                  " pixels from there on");
    }
    if (i % 2 == 1 && runs[i] > 0) {
      const std::int64_t last = done + runs[i] - 1;
      box.add(done / height_px, done % height_px);
      box.add(last / height_px, last % height_px);
      if (last / height_px > done / height_px) {  // into the next column, over the image's border
        box.add(done / height_px, height_px - 1);
        box.add(last / height_px, 0);
      }
    }
    done += runs[i];
  }
  if (done != all) {
    throw std::invalid_argument("the runs cover " + std::to_string(done) +
                                " pixels; the image has " + std::to_string(all));
  }
  PlacedMask placed = mask_in(box);
  done = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    // A run goes on in the next column where it reaches the image's lower border.
    for (std::int64_t at = done, end = done + (i % 2 == 1 ? runs[i] : 0); at < end;) {
      const std::int64_t column = at / height_px;
      const std::int64_t stop = std::min(end, (column + 1) * height_px);
      for (; at < stop; ++at) {
        placed.mask(static_cast<int>(column) - placed.x,
                    static_cast<int>(at - column * height_px) - placed.y) = 255;
      }
    }
    done += runs[i];
  }
  return placed;
}

PlacedMask mask_of_polygons(const std::vector<std::vector<Eigen::Vector2d>>& polygons, int width_px,
                            int height_px) {
  check_mask_image(width_px, height_px);
  check_length(polygons);
  PixelBox box;
  for (const auto& polygon : polygons) {
    for_each_crossing(polygon, width_px, height_px, [&](int x, int y) {
      box.add(x, y);
      box.add(x, std::max(0, y - 1));
    });
  }
  if (box.high_x >= 0) box.high_y = std::min<std::int64_t>(box.high_y, height_px - 1);
  if (box.high_x >= 0) box.low_y = std::min<std::int64_t>(box.low_y, height_px - 1);
  PlacedMask placed = mask_in(box);
  std::vector<std::vector<int>> crossings(static_cast<std::size_t>(placed.mask.width()));
  for (const auto& polygon : polygons) {
    for (std::vector<int>& column : crossings) column.clear();
    for_each_crossing(polygon, width_px, height_px, [&](int x, int y) {
      crossings[static_cast<std::size_t>(x - placed.x)].push_back(y - placed.y);
    });
    for (int x = 0; x < placed.mask.width(); ++x) {
      std::vector<int>& column = crossings[static_cast<std::size_t>(x)];
      std::sort(column.begin(), column.end());
      for (std::size_t i = 0; i + 1 < column.size(); i += 2) {
        for (int y = column[i]; y < std::min(column[i + 1], placed.mask.height()); ++y)
          placed.mask(x, y) = 255;
      }
    }
  }
  return placed;
}

std::vector<PixelRing> rings_of(const Image<std::uint8_t>& mask, int x, int y,
                                std::size_t most_edges) {
  const Image<std::uint8_t> edges = edges_of(mask);
  Image<std::uint8_t> used(edges.width(), edges.height());
  const Image<int> part = parts_of(mask);
  std::vector<PixelRing> rings;
  std::size_t edge_count = 0;
  for (int cy = 0; cy < edges.height(); ++cy) {
    for (int cx = 0; cx < edges.width(); ++cx) {
      for (unsigned direction = 0; direction < 4; ++direction) {
        if (((edges(cx, cy) & ~used(cx, cy)) & (1U << direction)) == 0) continue;
        const Eigen::Vector2i pixel = Eigen::Vector2i(cx, cy) + kRightPixel[direction];
        const PixelOutline line = follow(edges, used, {cx, cy}, direction);
        if (line.size() > most_edges - edge_count) {
          throw std::invalid_argument("has an outline of more than " + std::to_string(most_edges) +
                                      " pixel edges, which is the limit");
        }
        edge_count += line.size();
        PixelRing ring{corners_of(line), part(pixel.x(), pixel.y())};
        ring.is_hole = doubled_area(ring.line) < 0;
        for (Eigen::Vector2i& corner : ring.line) corner += Eigen::Vector2i(x, y);
        rings.push_back(std::move(ring));
      }
    }
  }
  return rings;
}

std::vector<PixelOutline> outlines_of(const Image<std::uint8_t>& mask, int x, int y) {
  const std::vector<PixelRing> rings = rings_of(mask, x, y);
  std::vector<PixelOutline> outlines;
  for (const PixelRing& ring : rings) {
    if (ring.is_hole) continue;
    PixelOutline& outline = outlines.emplace_back(ring.line);
    for (const PixelRing& hole : rings) {
      if (hole.is_hole && hole.part == ring.part) join(outline, hole.line);
    }
  }
  return outlines;
}

PixelOutline joined(const std::vector<PixelOutline>& outlines) {
  PixelOutline line;
  for (const PixelOutline& outline : outlines) {
    if (line.empty()) {
      line = outline;
    } else {
      join(line, outline);
    }
  }
  return line;
}

}  // namespace cousin
