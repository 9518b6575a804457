#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace leeway::collision {

/// Two geometries that must keep more than `margin` apart.
struct ScenePair {
  std::int32_t body_a, geometry_a;  // geometry index within its body
  std::int32_t body_b, geometry_b;  // a is always moving; b may be
  double margin;                    // [m]
};

/// The pairs of a Scene: a list and a table. The list has the pairs of two moving geometries, and
/// of moving geometries with bodies before firstStill(). The table has a row for each moving
/// geometry and a place for each geometry of the bodies from firstStill() on, which are fixed.
///
/// The number of a listed pair is its index in the list. The number of a pair in the table is
/// listedCount() + row * places() + place. Some numbers of the table have no pair, because the two
/// may touch or a body was removed. A pair takes memory only where it differs from its row.
class ScenePairs {
 public:
  /// The number of pairs.
  std::size_t size() const { return listed_.size() + in_table_; }
  bool empty() const { return size() == 0; }
  /// All pair numbers are below this.
  std::size_t numbers() const { return listed_.size() + rows_.size() * places_; }
  /// Whether there is a pair with this number, which is below numbers(). O(1).
  bool has(std::size_t number) const {
    return number < listed_.size() || find(placeOf(number)).has_pair;
  }
  /// The two geometries and the margin for a number, even if it has no pair. O(1).
  ScenePair operator[](std::size_t number) const {
    return number < listed_.size() ? listed_[number] : inTable(placeOf(number));
  }

  /// Iterates over the pairs in the order of their numbers.
  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = ScenePair;
    using difference_type = std::ptrdiff_t;
    using pointer = const ScenePair*;
    using reference = ScenePair;
    Iterator(const ScenePairs& pairs, std::size_t number) : pairs_(&pairs), number_(number) {
      skip();
    }
    ScenePair operator*() const { return (*pairs_)[number_]; }
    std::size_t number() const { return number_; }
    Iterator& operator++() {
      ++number_;
      skip();
      return *this;
    }
    bool operator==(const Iterator& other) const { return number_ == other.number_; }

   private:
    void skip() {
      while (number_ < pairs_->numbers() && !pairs_->has(number_)) ++number_;
    }
    const ScenePairs* pairs_;
    std::size_t number_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, numbers()}; }

  /// Pairs [0, listedCount()) are listed.
  std::size_t listedCount() const { return listed_.size(); }

  /// The least margin of all pairs that have a body from `first_body` on or, if `with` is false, of
  /// all pairs that have no such body [m]; infinity if there are no such pairs. NaN counts as 0.
  /// O(listed pairs).
  double leastMargin(int first_body = 0, bool with = true) const;
  /// The greatest margin of all pairs, NaN if one is NaN [m]; -infinity if there are no pairs.
  /// O(listed pairs).
  double mostMargin() const;

  // The table.

  struct Row {
    std::int32_t body, geometry;
    double margin;  ///< of pairs without a margin of their own [m]
    // The number of the row's pairs, their least margin (NaN counts as 0), and their greatest
    // margin (NaN if one is NaN) [m].
    std::size_t count = 0;
    double least = std::numeric_limits<double>::infinity();
    double most = -std::numeric_limits<double>::infinity();
    bool is_sparse = false;  ///< only exceptions have pairs
  };
  std::span<const Row> rows() const { return rows_; }
  std::size_t places() const { return places_; }
  int firstStill() const { return first_still_; }
  /// The geometry at a place: a body, and which of its geometries. O(1).
  struct Geometry {
    std::int32_t body, geometry;
  };
  Geometry geometryIn(std::size_t place) const {
    return geometries_.empty() ? Geometry{first_still_ + static_cast<std::int32_t>(place), 0}
                               : geometries_[place];
  }
  struct Place {
    std::size_t row, place;
  };
  /// The row and place of a number, which is at least listedCount(). O(1).
  Place placeOf(std::size_t number) const {
    const auto in_table = static_cast<std::uint32_t>(number - listed_.size());
    const auto places = static_cast<std::uint32_t>(places_);
    return {in_table / places, in_table % places};
  }
  /// The number of a pair by row and place; -1 if there is no such pair. O(1).
  std::int32_t numberOf(std::size_t row, std::size_t place) const {
    return find({row, place}).has_pair
               ? static_cast<std::int32_t>(listed_.size() + row * places_ + place)
               : -1;
  }
  double marginOf(const Place& of) const { return find(of).margin; }

 private:
  friend class Scene;
  friend class SceneBuilder;
  friend class SceneChange;
  friend struct SceneAccess;

  struct Found {
    bool has_pair;
    double margin;  // [m]
  };
  Found find(const Place& of) const {
    const Row& row = rows_[of.row];
    if (exceptions_.empty()) return {true, row.margin};
    return findException(of);
  }
  Found findException(const Place& of) const;
  bool isCleared(std::size_t place) const;
  ScenePair inTable(const Place& of) const;

  // Updates the count and margins of the rows; called after all changes. O(rows + exceptions).
  void count();
  void leaveOut(const Place& of) { exceptions_.of(keyOf(of)).has_pair = false; }
  // Removes a place's pairs from all rows, or gives them back.
  void clearPlace(std::size_t place);
  void restorePlace(std::size_t place);
  // Sets a pair to its margin; without a margin the two may touch. Replaces what was set before.
  void set(const Place& of, std::optional<double> margin);
  // Whether a pair of the row needs no entry for this margin, or for none: it may touch.
  static bool isUsual(const Row& row, std::optional<double> margin) {
    return margin.has_value() != row.is_sparse && (!margin || *margin == row.margin);
  }
  void setMargin(const Place& of, double margin) {
    Exceptions::Entry& entry = exceptions_.of(keyOf(of));
    entry.has_margin = true;
    entry.margin = margin;
  }
  void raise(double margin, int first_body);
  // first_place: the first place of a fixed body.
  void grow(int body, int geometry, double growth, std::size_t first_place);
  void keep(const std::function<bool(const ScenePair&)>& keeps);

  // Rows and places whose pairs differ from their row: a hash table with linear probing.
  class Exceptions {
   public:
    struct Entry {
      std::uint64_t key = kFree;
      double margin = 0;  // [m]
      bool has_margin = false, has_pair = true;
    };
    bool empty() const { return count_ == 0; }
    const Entry* find(std::uint64_t key) const;
    // The entry of a key, added if it is new. O(1) on average.
    Entry& of(std::uint64_t key);
    template <class Visit>
    void forEach(const Visit& visit) {
      for (Entry& entry : entries_)
        if (entry.key != kFree) visit(entry);
    }

   private:
    static constexpr std::uint64_t kFree = ~std::uint64_t{0};
    std::size_t slotOf(std::uint64_t key) const;
    void enlarge();
    std::vector<Entry> entries_;  // a power of two
    std::size_t count_ = 0;
  };
  // Keys stay the same when places are added.
  static std::uint64_t keyOf(const Place& of) {
    return static_cast<std::uint64_t>(of.row) << 32U | static_cast<std::uint64_t>(of.place);
  }
  // The row number in keys of places with which no row has a pair.
  static constexpr std::size_t kAllRows = 0x7fffffff;

  std::vector<ScenePair> listed_;
  std::vector<Row> rows_;
  std::size_t places_ = 0, in_table_ = 0;  // in_table_: number of pairs in the table
  int first_still_ = 0;
  std::vector<Geometry> geometries_;  // one for each place; empty: each body has one
  std::size_t cleared_places_ = 0;
  Exceptions exceptions_;
};

}  // namespace leeway::collision
