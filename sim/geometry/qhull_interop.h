#pragma once

#include <Eigen/Core>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace cousin::geometry {

/// Private to sim/geometry: one run of Qhull [Barber, Dobkin & Huhdanpaa 1996], reentrant, its
/// memory freed at the end.
class Qhull {
 public:
  /// @param coordinates  x y z of each point; Qhull may change them
  /// @param options      "qhull Qt", "qhull d Qbb Qz Qt", ...
  Qhull(std::vector<double> coordinates, const std::string& options)
      : coordinates_(std::move(coordinates)), messages_(std::fopen("/dev/null", "w")) {
    QHULL_LIB_CHECK
    qh_zero(&qh_, messages_);
    // Qhull wants a writable option string.
    std::vector<char> text(options.begin(), options.end());
    text.push_back('\0');
    ok_ =
        messages_ && qh_new_qhull(&qh_, 3, static_cast<int>(coordinates_.size() / 3),
                                  coordinates_.data(), False, text.data(), nullptr, messages_) == 0;
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;
  ~Qhull() {
    qh_.NOerrexit = True;
    qh_freeqhull(&qh_, !qh_ALL);
    int left = 0, total = 0;
    qh_memfreeshort(&qh_, &left, &total);
    if (messages_) std::fclose(messages_);
  }
  bool ok() const { return ok_; }
  qhT* operator->() { return &qh_; }
  qhT* get() { return &qh_; }

 private:
  qhT qh_{};
  std::vector<double> coordinates_;
  std::FILE* messages_;
  bool ok_ = false;
};

}  // namespace cousin::geometry
