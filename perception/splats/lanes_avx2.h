#pragma once

#include <immintrin.h>

#include <cstdint>

namespace cousin {

/// Eight truth values, one a lane: all bits of a true one are set.
struct Avx2Mask {
  __m256 v;
};

/// Eight floats in one AVX2 register; FMA is used. Only translation units compiled for both may
/// include this. Each operation does what its namesake of `PlainLanes` says.
struct Avx2Lanes {
  using Mask = Avx2Mask;
  __m256 v;

  Avx2Lanes() = default;
  Avx2Lanes(__m256 value) : v(value) {}  // NOLINT: a wrapped register
  explicit Avx2Lanes(double value) : v(_mm256_set1_ps(static_cast<float>(value))) {}
  static Avx2Lanes load(const float* from) { return _mm256_loadu_ps(from); }
  void store(float* to) const { _mm256_storeu_ps(to, v); }
};

inline Avx2Lanes operator+(Avx2Lanes a, Avx2Lanes b) { return _mm256_add_ps(a.v, b.v); }
inline Avx2Lanes operator-(Avx2Lanes a, Avx2Lanes b) { return _mm256_sub_ps(a.v, b.v); }
inline Avx2Lanes operator*(Avx2Lanes a, Avx2Lanes b) { return _mm256_mul_ps(a.v, b.v); }
inline Avx2Lanes operator/(Avx2Lanes a, Avx2Lanes b) { return _mm256_div_ps(a.v, b.v); }
inline Avx2Lanes operator-(Avx2Lanes a) { return _mm256_xor_ps(a.v, _mm256_set1_ps(-0.0f)); }
inline Avx2Lanes multiply_add(Avx2Lanes a, Avx2Lanes b, Avx2Lanes c) {
  return _mm256_fmadd_ps(a.v, b.v, c.v);
}
inline Avx2Lanes multiply_subtract(Avx2Lanes a, Avx2Lanes b, Avx2Lanes c) {
  return _mm256_fnmadd_ps(a.v, b.v, c.v);
}
inline Avx2Lanes smaller(Avx2Lanes a, Avx2Lanes b) { return _mm256_min_ps(a.v, b.v); }
inline Avx2Lanes larger(Avx2Lanes a, Avx2Lanes b) { return _mm256_max_ps(a.v, b.v); }
inline Avx2Lanes square_root(Avx2Lanes a) { return _mm256_sqrt_ps(a.v); }
inline Avx2Lanes round_down(Avx2Lanes a) { return _mm256_floor_ps(a.v); }
inline Avx2Lanes round_up(Avx2Lanes a) { return _mm256_ceil_ps(a.v); }
inline Avx2Lanes round_nearest(Avx2Lanes a) {
  return _mm256_round_ps(a.v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
}
inline Avx2Lanes magnitude(Avx2Lanes a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v); }
inline Avx2Lanes with_sign_set(Avx2Lanes a) { return _mm256_or_ps(_mm256_set1_ps(-0.0f), a.v); }

inline Avx2Mask at_least(Avx2Lanes a, Avx2Lanes b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)}; }
inline Avx2Mask less(Avx2Lanes a, Avx2Lanes b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)}; }
inline Avx2Mask operator&(Avx2Mask a, Avx2Mask b) { return {_mm256_and_ps(a.v, b.v)}; }
inline Avx2Mask operator|(Avx2Mask a, Avx2Mask b) { return {_mm256_or_ps(a.v, b.v)}; }
inline unsigned bits(Avx2Mask m) { return static_cast<unsigned>(_mm256_movemask_ps(m.v)); }
inline Avx2Lanes where(Avx2Mask m, Avx2Lanes yes, Avx2Lanes no) {
  return _mm256_blendv_ps(no.v, yes.v, m.v);
}
inline Avx2Lanes zero_unless(Avx2Mask m, Avx2Lanes a) { return _mm256_and_ps(m.v, a.v); }

inline Avx2Lanes times_power_of_two(Avx2Lanes a, Avx2Lanes n) {
  const __m256 bounded =
      _mm256_min_ps(_mm256_max_ps(n.v, _mm256_set1_ps(-126)), _mm256_set1_ps(127));
  const __m256i shifted = _mm256_slli_epi32(_mm256_cvtps_epi32(bounded), 23);
  return _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(a.v), shifted));
}
inline Avx2Lanes times_power_unchecked(Avx2Lanes a, Avx2Lanes n) {
  const __m256i shifted = _mm256_slli_epi32(_mm256_cvtps_epi32(n.v), 23);
  return _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(a.v), shifted));
}
inline void split_exponent(Avx2Lanes a, Avx2Lanes& mantissa, Avx2Lanes& exponent) {
  const __m256i raw = _mm256_castps_si256(a.v);
  const __m256i e = _mm256_srai_epi32(_mm256_sub_epi32(raw, _mm256_set1_epi32(0x3f3504f3)), 23);
  exponent = _mm256_cvtepi32_ps(e);
  mantissa = _mm256_castsi256_ps(_mm256_sub_epi32(raw, _mm256_slli_epi32(e, 23)));
}

inline Avx2Lanes lane_sums(const Avx2Lanes* eight) {
  const __m256 a = _mm256_hadd_ps(_mm256_hadd_ps(eight[0].v, eight[1].v),
                                  _mm256_hadd_ps(eight[2].v, eight[3].v));
  const __m256 b = _mm256_hadd_ps(_mm256_hadd_ps(eight[4].v, eight[5].v),
                                  _mm256_hadd_ps(eight[6].v, eight[7].v));
  return _mm256_add_ps(_mm256_permute2f128_ps(a, b, 0x20), _mm256_permute2f128_ps(a, b, 0x31));
}
inline float lane_sum(Avx2Lanes a) {
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
  const __m128 two = _mm_hadd_ps(four, four);
  return _mm_cvtss_f32(_mm_hadd_ps(two, two));
}

inline std::uint32_t nibble_spans(Avx2Lanes from, Avx2Lanes to, Avx2Mask valid) {
  const __m256i f = _mm256_sllv_epi32(_mm256_set1_epi32(1), _mm256_cvtps_epi32(from.v));
  const __m256i t = _mm256_sllv_epi32(_mm256_set1_epi32(2), _mm256_cvtps_epi32(to.v));
  __m256i span = _mm256_and_si256(_mm256_sub_epi32(t, f), _mm256_castps_si256(valid.v));
  span = _mm256_sllv_epi32(_mm256_and_si256(span, _mm256_set1_epi32(15)),
                           _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
  __m128i r = _mm_or_si128(_mm256_castsi256_si128(span), _mm256_extracti128_si256(span, 1));
  r = _mm_or_si128(r, _mm_shuffle_epi32(r, 0x4e));
  r = _mm_or_si128(r, _mm_shuffle_epi32(r, 0xb1));
  return static_cast<std::uint32_t>(_mm_cvtsi128_si32(r));
}

}  // namespace cousin
