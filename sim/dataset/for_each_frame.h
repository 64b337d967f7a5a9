#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>
#include <exception>
#include <vector>

namespace cousin {

/// Calls `work(i)` for i in [0, count) on all threads; every call runs, then the error of the
/// lowest index is thrown, so that the message does not depend on the threads.
template <class Work>
void for_each_frame(std::size_t count, const Work& work) {
  std::vector<std::exception_ptr> errors(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    try {
      work(i);
    } catch (...) {
      errors[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace cousin
