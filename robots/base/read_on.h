#pragma once

// Private to the project: reading that goes on after an error, so that all that is wrong is told.

#include <cstddef>

#include "leeway/robots/input_error.h"

namespace leeway::robots {

/// The errors that are kept from here on: of a part of a reading, which throws the first of them at
/// its end. `errors` may be null.
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

/// Throws `error`, or keeps it in `errors` where reading is to go on: unless that is null or full.
void throwOrKeep(const InputError& error, InputErrors* errors);

/// Calls read(), whose InputError goes the way of throwOrKeep(). False where read() did not come to
/// its end.
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
