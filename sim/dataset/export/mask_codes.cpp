#include "sim/dataset/export/mask_codes.h"

#include <array>
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

std::vector<PixelOutline> outlines_of(const Image<std::uint8_t>& mask, int x, int y) {
  const Image<std::uint8_t> edges = edges_of(mask);
  Image<std::uint8_t> used(edges.width(), edges.height());
  const Image<int> part = parts_of(mask);
  std::vector<PixelOutline> outlines;
  std::vector<int> part_of_outline;
  std::vector<std::pair<int, PixelOutline>> holes;
  for (int cy = 0; cy < edges.height(); ++cy) {
    for (int cx = 0; cx < edges.width(); ++cx) {
      for (unsigned direction = 0; direction < 4; ++direction) {
        if (((edges(cx, cy) & ~used(cx, cy)) & (1U << direction)) == 0) continue;
        const Eigen::Vector2i pixel = Eigen::Vector2i(cx, cy) + kRightPixel[direction];
        PixelOutline line = corners_of(follow(edges, used, {cx, cy}, direction));
        if (doubled_area(line) > 0) {
          outlines.push_back(std::move(line));
          part_of_outline.push_back(part(pixel.x(), pixel.y()));
        } else {
          holes.emplace_back(part(pixel.x(), pixel.y()), std::move(line));
        }
      }
    }
  }
  for (const auto& [number, hole] : holes) {
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      if (part_of_outline[i] == number) join(outlines[i], hole);
    }
  }
  for (PixelOutline& line : outlines) {
    for (Eigen::Vector2i& corner : line) corner += Eigen::Vector2i(x, y);
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
