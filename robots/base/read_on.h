#pragma once

// Private to the project: reading that continues after an error, so that all errors are reported.

#include <cstddef>

#include "leeway/robots/input_error.h"

namespace leeway::robots {

/// The errors that are stored from now on, for one part of a reading; the part throws the first of
/// them at its end. `errors` may be null.
class ErrorsSince {
 public:
  explicit ErrorsSince(const InputErrors* errors)
      : errors_(errors), before_(errors == nullptr ? 0 : errors->count()) {}
  bool any() const { return errors_ != nullptr && errors_->count() > before_; }
  void throwFirst() const {
    if (any()) throw InputError(errors_->kept(before_));
  }

 private:
  const InputErrors* errors_;
  std::size_t before_;
};

/// Throws `error` if `errors` is null or full; otherwise stores it there, and reading continues.
void throwOrKeep(const InputError& error, InputErrors* errors);

/// Calls read(), and passes its InputError to throwOrKeep(). False if read() did not finish.
template <class Read>
bool readOn(InputErrors* errors, const Read& read) {
  try {
    read();
    return true;
  } catch (const InputError& error) {
    throwOrKeep(error, errors);
    return false;
  }
}

}  // namespace leeway::robots
