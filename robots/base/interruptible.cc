#include "robots/base/interruptible.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

namespace leeway::robots {

namespace {

constexpr std::chrono::milliseconds kBetweenQuestions(20);

}  // namespace

void workInterruptibly(const Stop& stop, const std::function<void(const Stop& asked)>& work) {
  if (!stop) return work({});
  std::atomic<bool> stopped = false;
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  std::exception_ptr of_work, of_stop;
  std::thread worker;
  try {
    worker = std::thread([&] {
      try {
        work([&] { return stopped.load(); });
      } catch (...) {
        of_work = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      done = true;
      changed.notify_one();
    });
  } catch (const std::system_error&) {  // no thread is available
    return work({});
  }
  const auto isDone = [&] {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, kBetweenQuestions, [&] { return done; });
  };
  do {
    try {
      stopped = stop();
    } catch (...) {
      of_stop = std::current_exception();
      stopped = true;
    }
  } while (!stopped && !isDone());
  worker.join();
  if (of_stop) std::rethrow_exception(of_stop);
  if (of_work) std::rethrow_exception(of_work);
  if (stopped) throw Stopped("stopped while files were read");  // it was not noticed in time
}

}  // namespace leeway::robots
