#include "leeway/robots/prepared_store.h"

#include <algorithm>
#include <utility>

namespace leeway::robots {

/// What was prepared is of the model that this one was before.
PreparedStore& PreparedStore::operator=(const PreparedStore& other) {
  if (this == &other) return *this;
  const std::lock_guard<std::mutex> lock(mutex_);
  entries_.clear();
  return *this;
}

std::shared_ptr<const PreparedStore::Entry> PreparedStore::findLocked(const Fits& fits) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const auto& entry) { return fits(*entry); });
  if (found == entries_.end()) return nullptr;
  std::rotate(entries_.begin(), found, found + 1);
  return entries_.front();
}

std::shared_ptr<const PreparedStore::Entry> PreparedStore::find(const Fits& fits) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return findLocked(fits);
}

std::shared_ptr<const PreparedStore::Entry> PreparedStore::keep(std::shared_ptr<const Entry> entry,
                                                                const Fits& fits) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (auto known = findLocked(fits)) return known;
  entries_.insert(entries_.begin(), std::move(entry));
  if (entries_.size() > kMost) entries_.resize(kMost);
  return entries_.front();
}

}  // namespace leeway::robots
