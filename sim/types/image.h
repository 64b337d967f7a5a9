#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace cousin {

/// Row-major image that owns its pixels. Pixel (0, 0) is the centre of the top-left pixel.
template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, const T& fill = T{}) : width_(width), height_(height) {
    if (width < 0 || height < 0) {
      throw std::invalid_argument("image size " + std::to_string(width) + " x " +
                                  std::to_string(height) + " is negative");
    }
    pixels_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill);
  }

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t size() const { return pixels_.size(); }
  bool empty() const { return pixels_.empty(); }
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

  T& operator()(int x, int y) { return pixels_[index(x, y)]; }
  const T& operator()(int x, int y) const { return pixels_[index(x, y)]; }
  std::span<T> row(int y) {
    return {pixels_.data() + index(0, y), static_cast<std::size_t>(width_)};
  }
  std::span<const T> row(int y) const {
    return {pixels_.data() + index(0, y), static_cast<std::size_t>(width_)};
  }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  auto begin() { return pixels_.begin(); }
  auto end() { return pixels_.end(); }
  auto begin() const { return pixels_.begin(); }
  auto end() const { return pixels_.end(); }

  bool operator==(const Image&) const = default;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  int width_ = 0;
  int height_ = 0;
  std::vector<T> pixels_;
};

struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Rgb8&) const = default;
};

/// Linear colour, sRGB primaries, unless a comment says otherwise.
struct Rgbf {
  float r = 0, g = 0, b = 0;
  bool operator==(const Rgbf&) const = default;
};

}  // namespace cousin
