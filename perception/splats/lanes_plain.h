#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace cousin {

/// Eight truth values, one a lane: 0 or -1, as wide as the floats that they choose.
struct PlainMask {
  std::int32_t lane[8];
};

/// Eight floats that kernels compute with at once, in plain C++: the portable twin of `Avx2Lanes`.
/// Comparisons are false where a lane is NaN.
struct PlainLanes {
  using Mask = PlainMask;
  float lane[8];

  PlainLanes() = default;
  explicit PlainLanes(double value) {
    for (float& x : lane) x = static_cast<float>(value);
  }
  static PlainLanes load(const float* from) {
    PlainLanes r;
    for (int i = 0; i < 8; ++i) r.lane[i] = from[i];
    return r;
  }
  void store(float* to) const {
    for (int i = 0; i < 8; ++i) to[i] = lane[i];
  }
};

template <class F>
inline PlainLanes plain_map(const PlainLanes& a, F f) {
  PlainLanes r;
  for (int i = 0; i < 8; ++i) r.lane[i] = f(a.lane[i]);
  return r;
}
template <class F>
inline PlainLanes plain_map(const PlainLanes& a, const PlainLanes& b, F f) {
  PlainLanes r;
  for (int i = 0; i < 8; ++i) r.lane[i] = f(a.lane[i], b.lane[i]);
  return r;
}
template <class F>
inline PlainMask plain_mask(F f) {
  PlainMask r;
  for (int i = 0; i < 8; ++i) r.lane[i] = f(i) ? -1 : 0;
  return r;
}

inline PlainLanes operator+(const PlainLanes& a, const PlainLanes& b) {
  return plain_map(a, b, [](float x, float y) { return x + y; });
}
inline PlainLanes operator-(const PlainLanes& a, const PlainLanes& b) {
  return plain_map(a, b, [](float x, float y) { return x - y; });
}
inline PlainLanes operator*(const PlainLanes& a, const PlainLanes& b) {
  return plain_map(a, b, [](float x, float y) { return x * y; });
}
inline PlainLanes operator/(const PlainLanes& a, const PlainLanes& b) {
  return plain_map(a, b, [](float x, float y) { return x / y; });
}
inline PlainLanes operator-(const PlainLanes& a) {
  return plain_map(a, [](float x) { return -x; });
}
/// a b + c
inline PlainLanes multiply_add(const PlainLanes& a, const PlainLanes& b, const PlainLanes& c) {
  return a * b + c;
}
/// c - a b
inline PlainLanes multiply_subtract(const PlainLanes& a, const PlainLanes& b, const PlainLanes& c) {
  return c - a * b;
}
/// The second where one is NaN, as the vector instruction.
inline PlainLanes smaller(const PlainLanes& a, const PlainLanes& b) {
  return plain_map(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline PlainLanes larger(const PlainLanes& a, const PlainLanes& b) {
  return plain_map(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline PlainLanes square_root(const PlainLanes& a) {
  return plain_map(a, [](float x) { return std::sqrt(x); });
}
inline PlainLanes round_down(const PlainLanes& a) {
  return plain_map(a, [](float x) { return std::floor(x); });
}
inline PlainLanes round_up(const PlainLanes& a) {
  return plain_map(a, [](float x) { return std::ceil(x); });
}
inline PlainLanes round_nearest(const PlainLanes& a) {
  return plain_map(a, [](float x) { return std::nearbyint(x); });
}
inline PlainLanes magnitude(const PlainLanes& a) {
  return plain_map(a, [](float x) { return std::fabs(x); });
}
inline PlainLanes with_sign_set(const PlainLanes& a) {
  return plain_map(a, [](float x) { return -std::fabs(x); });
}

inline PlainMask at_least(const PlainLanes& a, const PlainLanes& b) {
  return plain_mask([&](int i) { return a.lane[i] >= b.lane[i]; });
}
inline PlainMask less(const PlainLanes& a, const PlainLanes& b) {
  return plain_mask([&](int i) { return a.lane[i] < b.lane[i]; });
}
inline PlainMask operator&(const PlainMask& a, const PlainMask& b) {
  return plain_mask([&](int i) { return (a.lane[i] & b.lane[i]) != 0; });
}
inline PlainMask operator|(const PlainMask& a, const PlainMask& b) {
  return plain_mask([&](int i) { return (a.lane[i] | b.lane[i]) != 0; });
}
/// Bit i is lane i.
inline unsigned bits(const PlainMask& m) {
  unsigned r = 0;
  for (int i = 0; i < 8; ++i) r |= (m.lane[i] != 0 ? 1u : 0u) << i;
  return r;
}
inline PlainLanes where(const PlainMask& m, const PlainLanes& yes, const PlainLanes& no) {
  PlainLanes r;
  for (int i = 0; i < 8; ++i) r.lane[i] = m.lane[i] != 0 ? yes.lane[i] : no.lane[i];
  return r;
}
inline PlainLanes zero_unless(const PlainMask& m, const PlainLanes& a) {
  return where(m, a, PlainLanes(0));
}

/// a 2^n for a rounded n; a in [0.5, 2), n clamped to [-126, 127].
inline PlainLanes times_power_of_two(const PlainLanes& a, const PlainLanes& n) {
  return plain_map(a, n, [](float x, float e) {
    if (!(e > -126)) e = -126;
    if (e > 127) e = 127;
    const auto shifted = static_cast<std::int32_t>(e) * (1 << 23);
    return std::bit_cast<float>(std::bit_cast<std::int32_t>(x) + shifted);
  });
}
/// The same where n is within its limits, and any number where it is not.
inline PlainLanes times_power_unchecked(const PlainLanes& a, const PlainLanes& n) {
  return times_power_of_two(a, n);
}
/// Splits a > 0, not subnormal, into mantissa [sqrt(1/2), sqrt(2)) and a whole exponent.
inline void split_exponent(const PlainLanes& a, PlainLanes& mantissa, PlainLanes& exponent) {
  for (int i = 0; i < 8; ++i) {
    const auto raw = std::bit_cast<std::int32_t>(a.lane[i]);
    const std::int32_t e = (raw - 0x3f3504f3) >> 23;
    exponent.lane[i] = static_cast<float>(e);
    mantissa.lane[i] = std::bit_cast<float>(raw - (e << 23));
  }
}

/// Sums of the lanes of eight vectors.
inline PlainLanes lane_sums(const PlainLanes* eight) {
  PlainLanes r;
  for (int i = 0; i < 8; ++i) {
    const float* x = eight[i].lane;
    r.lane[i] = ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
  }
  return r;
}
inline float lane_sum(const PlainLanes& a) {
  const float* x = a.lane;
  return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
}

/// Bits 4 i + from .. 4 i + to of each lane i in `valid`; `from` and `to` are whole, 0..3.
inline std::uint32_t nibble_spans(const PlainLanes& from, const PlainLanes& to,
                                  const PlainMask& valid) {
  std::uint32_t r = 0;
  for (int i = 0; i < 8; ++i) {
    if (valid.lane[i] == 0) continue;
    const auto f = static_cast<unsigned>(from.lane[i]);
    const auto t = static_cast<unsigned>(to.lane[i]);
    r |= (((2u << t) - (1u << f)) & 15u) << (4 * i);
  }
  return r;
}

}  // namespace cousin
