#include <immintrin.h>

#include "perception/splats/photometric_band_body.h"

namespace cousin::photometric {
namespace {

/// Eight floats in one register.
struct Avx {
  __m256 v;

  struct Sum {
    __m256d low = _mm256_setzero_pd(), high = _mm256_setzero_pd();
  };
  static Avx load(const float* at) { return {_mm256_loadu_ps(at)}; }
  static void store(float* at, Avx a) { _mm256_storeu_ps(at, a.v); }
  static __m256i first(int count) {
    return _mm256_cmpgt_epi32(_mm256_set1_epi32(count), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
  }
  static Avx load_first(const float* at, int count) {
    return {_mm256_maskload_ps(at, first(count))};
  }
  static void store_first(float* at, int count, Avx a) {
    _mm256_maskstore_ps(at, first(count), a.v);
  }
  static Avx first_ones(int count) {
    return {_mm256_and_ps(_mm256_castsi256_ps(first(count)), _mm256_set1_ps(1))};
  }
  static Avx zero() { return {_mm256_setzero_ps()}; }
  static Avx all(float a) { return {_mm256_set1_ps(a)}; }
  static Avx add(Avx a, Avx b) { return {_mm256_add_ps(a.v, b.v)}; }
  static Avx sub(Avx a, Avx b) { return {_mm256_sub_ps(a.v, b.v)}; }
  static Avx mul(Avx a, Avx b) { return {_mm256_mul_ps(a.v, b.v)}; }
  static Avx div(Avx a, Avx b) { return {_mm256_div_ps(a.v, b.v)}; }
  static Avx fma(Avx a, Avx b, Avx c) { return {_mm256_fmadd_ps(a.v, b.v, c.v)}; }
  static Avx magnitude(Avx a) { return {_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v)}; }
  /// -1, 0 or 1; 0 for NaN.
  static Avx sign(Avx a) {
    const __m256 nonzero = _mm256_cmp_ps(a.v, _mm256_setzero_ps(), _CMP_NEQ_OQ);
    const __m256 one = _mm256_or_ps(_mm256_and_ps(a.v, _mm256_set1_ps(-0.0f)), _mm256_set1_ps(1));
    return {_mm256_and_ps(nonzero, one)};
  }
  static Avx keep_where_positive(Avx where, Avx a) {
    return {_mm256_and_ps(_mm256_cmp_ps(where.v, _mm256_setzero_ps(), _CMP_GT_OQ), a.v)};
  }
  static void sum_to(Sum& sum, Avx a) {
    sum.low = _mm256_add_pd(sum.low, _mm256_cvtps_pd(_mm256_castps256_ps128(a.v)));
    sum.high = _mm256_add_pd(sum.high, _mm256_cvtps_pd(_mm256_extractf128_ps(a.v, 1)));
  }
  static double total(const Sum& sum) {
    alignas(32) double parts[4];
    _mm256_store_pd(parts, _mm256_add_pd(sum.low, sum.high));
    return (parts[0] + parts[1]) + (parts[2] + parts[3]);
  }
};

void run(const Band& band) { BandRows<Avx>(band).run(); }

}  // namespace

BandKernel loss_band_avx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? run : nullptr;
}

}  // namespace cousin::photometric
