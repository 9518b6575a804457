#pragma once

#include <stdexcept>

namespace leeway::python {

/// Marks an object as in use by one call. A concurrent call from another thread throws
/// std::runtime_error with `message`.
class Busy {
 public:
  Busy(bool& busy, const char* message) : busy_(busy) {
    if (busy) throw std::runtime_error(message);
    busy = true;
  }
  ~Busy() { busy_ = false; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;

 private:
  bool& busy_;
};

}  // namespace leeway::python
