#pragma once

#include <cstddef>

#if defined(__SANITIZE_THREAD__)
#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#else
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#endif

namespace livemvs {

/// Calls f(first, last) for consecutive stretches of [begin, end), of about `grain` each, from the
/// threads of the caller's oneTBB arena; returns when all are done. Which thread takes which
/// stretch, and where they are cut, differs from run to run. An exception reaches the caller once
/// no stretch is being worked on any more.
template <typename F>
void ParallelForRange(std::size_t begin, std::size_t end, std::size_t grain, const F& f) {
  if (begin >= end) return;
#if defined(__SANITIZE_THREAD__)
  // Distributions build oneTBB without the thread sanitizer, which then sees races where there are
  // none. It understands threads that are started and joined: they do the same work.
  std::atomic<std::size_t> next = begin;
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    try {
      for (std::size_t first; (first = next.fetch_add(grain)) < end;) {
        f(first, std::min(first + grain, end));
      }
    } catch (...) {
      const std::scoped_lock lock(failure_mutex);
      failure = std::current_exception();
      next = end;
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 3; ++i) threads.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
#else
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(begin, end, grain),
      [&](const tbb::blocked_range<std::size_t>& range) { f(range.begin(), range.end()); });
#endif
}

/// Calls f(i) for every i in [0, count).
template <typename F>
void ParallelFor(std::size_t count, const F& f) {
  ParallelForRange(0, count, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i != last; ++i) f(i);
  });
}

}  // namespace livemvs
