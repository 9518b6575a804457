#pragma once

#include <cstddef>
#include <functional>
#include <new>
#include <span>
#include <vector>

namespace leeway::tools::report {

/// How one item of guarded work ended.
enum class Fate : unsigned char {
  kDone,
  kThrew,     ///< an exception
  kDied,      ///< the process ended: abort, segmentation fault, exit()
  kTimedOut,  ///< more processor time than allowed
};

/// Anonymous memory that child processes write and their parent reads. T must be trivial.
class SharedMemory {
 public:
  explicit SharedMemory(std::size_t bytes);  ///< zeros; throws std::bad_alloc
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  void* data() const { return data_; }

 private:
  void* data_;
  std::size_t bytes_;
};

template <typename T>
class SharedArray {
 public:
  explicit SharedArray(std::size_t count) : memory_(count * sizeof(T) + 1), count_(count) {
    for (T& value : span()) new (&value) T{};
  }
  std::span<T> span() const { return {static_cast<T*>(memory_.data()), count_}; }
  T& operator[](std::size_t i) const { return span()[i]; }

 private:
  SharedMemory memory_;
  std::size_t count_;
};

/// Calls work(0) ... work(count - 1) in child processes, so that no item can end this process:
/// after an item that kills its child, a new child continues with the next item. Items return
/// results through shared memory. `seconds`: limit on the processor time of one item, at least
/// 1e-5. Children's stderr is discarded. Returns each item's fate. Throws std::system_error if no
/// child can be made. Not thread-safe.
std::vector<Fate> runGuarded(std::size_t count, double seconds,
                             const std::function<void(std::size_t)>& work);

}  // namespace leeway::tools::report
