#pragma once

#include "perception/splats/photometric_band.h"

namespace cousin::photometric {

/// Private to perception/splats: the kernel itself, for vectors `V` of kLanes floats that each
/// translation unit defines for itself (load, store, load_first, store_first, zero, all, add, sub,
/// mul, fma, div, sign, magnitude, keep_where_positive, sum_to). Rows move through two rings: what
/// the windows sum, and the similarity's derivatives at each window's centre. Both are filtered
/// along the row when they enter, and across rows when the ring has what one row needs.
template <class V>
class BandRows {
 public:
  explicit BandRows(const Band& band)
      : band_(band),
        stride_(row_stride(band.width)),
        sums_(band.scratch),
        derivatives_(sums_ + stride_ * kRing * kWindowed),
        line_(derivatives_ + stride_ * kRing * kDerivatives) {
    for (int k = 0; k <= kReach; ++k) taps_[k] = V::all(band.taps[k]);
    const std::size_t count = stride_ * (kWindowed + kDerivatives);
    for (std::size_t i = 0; i < count; ++i) line_[i] = 0;  // margins stay so
  }

  void run() {
    for (int row = band_.begin - 2 * kReach; row < band_.end + 2 * kReach; ++row) {
      const int step = row - (band_.begin - 2 * kReach);
      enter(row, step % kRing);
      if (step < 2 * kReach) continue;
      const int centre = row - kReach;
      differentiate(centre, step, (step - 2 * kReach) % kRing);
      if (step < 4 * kReach) continue;
      write_gradient(row - 2 * kReach, step - 2 * kReach);
    }
  }

 private:
  /// Row `slot` of quantity `q` of a ring of `count` quantities, at the image's first pixel.
  float* ring_row(float* ring, int slot, int q, int count) const {
    return ring + stride_ * static_cast<std::size_t>(slot * count + q) + kLanes;
  }
  float* line(int q) const { return line_ + stride_ * static_cast<std::size_t>(q) + kLanes; }
  bool inside(int row) const { return row >= 0 && row < band_.height; }
  const float* image_row(const float* image, int row) const {
    return image + static_cast<std::size_t>(row) * static_cast<std::size_t>(band_.width);
  }
  /// Values at columns x.. of a row of an image; zeros beyond its end.
  V load(const float* row, int x) const {
    return x + kLanes <= band_.width ? V::load(row + x) : V::load_first(row + x, band_.width - x);
  }
  V weight(int row, int x) const {
    if (band_.weight) return load(image_row(band_.weight, row), x);
    return x + kLanes <= band_.width ? V::all(1) : V::first_ones(band_.width - x);
  }

  V along(const float* at) const {
    V sum = V::mul(taps_[0], V::load(at));
    for (int k = 1; k <= kReach; ++k)
      sum = V::fma(taps_[k], V::add(V::load(at - k), V::load(at + k)), sum);
    return sum;
  }
  /// Filters quantity `q` across the eleven rows of a ring, the last of which entered at `step`.
  V across(float* ring, int step, int q, int count, int x) const {
    const auto at = [&](int age) {
      return V::load(ring_row(ring, (step - age) % kRing, q, count) + x);
    };
    V sum = V::mul(taps_[0], at(kReach));
    for (int k = 1; k <= kReach; ++k)
      sum = V::fma(taps_[k], V::add(at(kReach - k), at(kReach + k)), sum);
    return sum;
  }
  void filter_lines(float* ring, int first_line, int slot, int count) {
    for (int q = 0; q < count; ++q) {
      const float* from = line(first_line + q);
      float* to = ring_row(ring, slot, q, count);
      for (int x = 0; x < band_.width; x += kLanes) V::store(to + x, along(from + x));
    }
  }
  void clear(float* ring, int slot, int count) {
    for (int q = 0; q < count; ++q) {
      float* to = ring_row(ring, slot, q, count);
      for (int x = 0; x < band_.width; x += kLanes) V::store(to + x, V::zero());
    }
  }

  /// A row of the images enters the first ring, filtered along itself.
  void enter(int row, int slot) {
    if (!inside(row)) return clear(sums_, slot, kWindowed);
    const float* rendered = image_row(band_.rendered, row);
    const float* photograph = image_row(band_.photograph, row);
    for (int x = 0; x < band_.width; x += kLanes) {
      V a = load(rendered, x);
      V b = load(photograph, x);
      if (band_.weight) {
        const V w = weight(row, x);
        a = V::keep_where_positive(w, a);
        b = V::keep_where_positive(w, b);
      }
      V::store(line(0) + x, a);
      V::store(line(1) + x, b);
      V::store(line(2) + x, V::fma(a, a, V::mul(b, b)));
      V::store(line(3) + x, V::mul(a, b));
    }
    filter_lines(sums_, 0, slot, kWindowed);
  }

  /// The similarity at the windows centred on a row, and its derivatives into the second ring.
  void differentiate(int row, int step, int slot) {
    if (!inside(row)) return clear(derivatives_, slot, kDerivatives);
    const bool counted = row >= band_.begin && row < band_.end;
    const V two = V::all(2);
    const V scale = V::all(band_.ssim_scale);
    typename V::Sum similarities{};
    for (int x = 0; x < band_.width; x += kLanes) {
      const V mean_a = across(sums_, step, 0, kWindowed, x);
      const V mean_b = across(sums_, step, 1, kWindowed, x);
      const V squares = across(sums_, step, 2, kWindowed, x);
      const V product = across(sums_, step, 3, kWindowed, x);
      const V mean_product = V::mul(mean_a, mean_b);
      const V mean_squares = V::fma(mean_a, mean_a, V::mul(mean_b, mean_b));
      // S = (a1 a2) / (b1 b2): means above and below, covariance above variances.
      const V a1 = V::fma(two, mean_product, V::all(kC1));
      const V a2 = V::fma(two, V::sub(product, mean_product), V::all(kC2));
      const V b1 = V::add(mean_squares, V::all(kC1));
      const V b2 = V::add(V::sub(squares, mean_squares), V::all(kC2));
      const V inverse = V::div(V::all(1), V::mul(b1, b2));
      const V similarity = V::mul(V::mul(a1, a2), inverse);
      const V w = weight(row, x);
      if (counted) V::sum_to(similarities, V::mul(w, similarity));

      const V w_scale = V::mul(w, scale);
      const V by_b2 = V::mul(similarity, V::mul(b1, inverse));  // S / b2
      const V by_b1 = V::mul(similarity, V::mul(b2, inverse));  // S / b1
      const V d_mean =
          V::fma(V::mul(mean_b, inverse), V::sub(a2, a1), V::mul(mean_a, V::sub(by_b2, by_b1)));
      V::store(line(kWindowed) + x, V::mul(w_scale, V::mul(two, d_mean)));
      V::store(line(kWindowed + 1) + x, V::mul(w_scale, V::sub(V::zero(), by_b2)));
      V::store(line(kWindowed + 2) + x, V::mul(w_scale, V::mul(two, V::mul(a1, inverse))));
    }
    if (counted) band_.row_ssim[row] = V::total(similarities);
    filter_lines(derivatives_, kWindowed, slot, kDerivatives);
  }

  void write_gradient(int row, int step) {
    const float* rendered = image_row(band_.rendered, row);
    const float* photograph = image_row(band_.photograph, row);
    float* gradient = band_.gradient + (image_row(band_.photograph, row) - band_.photograph);
    typename V::Sum differences{};
    for (int x = 0; x < band_.width; x += kLanes) {
      const V a = load(rendered, x);
      const V b = load(photograph, x);
      const V w = weight(row, x);
      const V mean = across(derivatives_, step, 0, kDerivatives, x);
      const V squares = across(derivatives_, step, 1, kDerivatives, x);
      const V product = across(derivatives_, step, 2, kDerivatives, x);
      const V of_ssim = V::fma(V::mul(V::all(2), a), squares, V::fma(b, product, mean));
      const V difference = V::sub(a, b);
      V::sum_to(differences, V::keep_where_positive(w, V::mul(w, V::magnitude(difference))));
      const V of_l1 = V::mul(V::mul(w, V::all(band_.l1_scale)), V::sign(difference));
      const V total = V::keep_where_positive(w, V::add(of_l1, of_ssim));
      if (x + kLanes <= band_.width)
        V::store(gradient + x, total);
      else
        V::store_first(gradient + x, band_.width - x, total);
    }
    band_.row_l1[row] = V::total(differences);
  }

  static constexpr float kC1 = 0.01f * 0.01f;
  static constexpr float kC2 = 0.03f * 0.03f;

  const Band& band_;
  std::size_t stride_;
  float* sums_;
  float* derivatives_;
  float* line_;
  V taps_[kReach + 1];
};

}  // namespace cousin::photometric
