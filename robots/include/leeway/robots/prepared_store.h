#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace leeway::robots {

/// What a layer above prepares of a model and keeps with it: all who use the model share it, and it
/// goes with the model. Holds the entries used last, so that it stays small. Thread-safe. A copy of
/// the model begins with none.
class PreparedStore {
 public:
  /// Constant once it is kept. Must not own the model: neither would ever go.
  struct Entry {
    virtual ~Entry() = default;
  };
  using Fits = std::function<bool(const Entry&)>;
  static constexpr std::size_t kMost = 8;  ///< entries [count]

  PreparedStore() = default;
  PreparedStore(const PreparedStore&) : PreparedStore() {}
  PreparedStore& operator=(const PreparedStore& other);
  ~PreparedStore() = default;

  /// The entry that fits(), which counts as used now; null: none. O(kMost) calls.
  std::shared_ptr<const Entry> find(const Fits& fits) const;
  /// Keeps an entry, and gives up the one that was not used for longest beyond kMost. Where another
  /// thread has kept one that fits() in the meantime, that one stays and is returned.
  std::shared_ptr<const Entry> keep(std::shared_ptr<const Entry> entry, const Fits& fits) const;

 private:
  std::shared_ptr<const Entry> findLocked(const Fits& fits) const;
  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const Entry>> entries_;  // the last used first
};

}  // namespace leeway::robots
