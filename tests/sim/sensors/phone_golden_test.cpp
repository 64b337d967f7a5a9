#include <gtest/gtest.h>

#include <cstring>

#include "sim/sensors/phone.h"

namespace cousin {
namespace {

/// FNV-1a, 64 bits.
template <class T>
std::uint64_t hash_of(const Image<T>& image, std::uint64_t hash = 14695981039346656037ULL) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(image.data());
  for (std::size_t i = 0; i < image.size() * sizeof(T); ++i) {
    hash = (hash ^ bytes[i]) * 1099511628211ULL;
  }
  return hash;
}

// Datasets of phones are named by their bytes: what makes them may move, what it makes may not.
TEST(PhoneBytes, AreWhatTheyAlwaysWere) {
  PhoneConfig config = phone_preset("phone_video_720p");
  config.width_px = 320;
  config.height_px = 180;
  Image<Rgbf> radiance(320, 180);
  for (int y = 0; y < 180; ++y) {
    for (int x = 0; x < 320; ++x) {
      radiance(x, y) = {0.0001F * static_cast<float>(x * y % 971),
                        0.004F * static_cast<float>(y) + 0.001F,
                        0.3F + 0.001F * static_cast<float>(x % 31)};
    }
  }
  const PhoneUnit unit = make_phone(config, Rng(5));
  Scene scene;
  View seen;
  seen.rig_from_world = seen.rig_from_world_end = look_at({0.3, -0.2, 0.25}, {0, 0, 0});
  scene.views = {seen};
  const TrueView view = true_view(config, unit, scene, 0, Rng(6));
  EXPECT_EQ(hash_of(unit.prnu_gain), 8080283119290648985U);
  EXPECT_EQ(hash_of(unit.dsnu_e), 14807499890983411141U);
  EXPECT_EQ(hash_of(expose(radiance, config, unit, view, Rng(7))), 7499072005829891401U);
  EXPECT_EQ(hash_of(sense(radiance, config, unit, view, Rng(7)).color), 6844678118640012477U);
  config.jpeg_quality = 90;
  config.electrons_at_unit_radiance = 90;  // counts of Poisson and of normal noise
  EXPECT_EQ(hash_of(expose(radiance, config, unit, view, Rng(8))), 5170091902960993368U);
  EXPECT_EQ(hash_of(sense(radiance, config, unit, view, Rng(8)).color), 14926245782319131013U);
}

}  // namespace
}  // namespace cousin
