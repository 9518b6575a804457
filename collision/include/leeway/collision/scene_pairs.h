#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <vector>

namespace leeway::collision {

/// Two geometries that must keep more than `margin` apart.
struct ScenePair {
  std::int32_t body_a, geometry_a;  // geometry index within its body
  std::int32_t body_b, geometry_b;  // a is always moving; b may be
  double margin;                    // [m]
};

/// The pairs of a Scene, numbered through. Few are listed. Where pairs with what stands still are
/// many, they are told from their numbers: after those that are listed, each moving geometry has a
/// run of them, one a geometry that stands still, and only what differs from its run is kept.
class ScenePairs {
 public:
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  /// O(1); of a run, O(log of what differs from it).
  ScenePair operator[](std::size_t number) const {
    return number < listed_.size() ? listed_[number] : ofRun(number);
  }

  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = ScenePair;
    using difference_type = std::ptrdiff_t;
    using pointer = const ScenePair*;
    using reference = ScenePair;
    Iterator(const ScenePairs& pairs, std::size_t number) : pairs_(&pairs), number_(number) {}
    ScenePair operator*() const { return (*pairs_)[number_]; }
    Iterator& operator++() {
      ++number_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return number_ == other.number_; }

   private:
    const ScenePairs* pairs_;
    std::size_t number_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size_}; }

  /// The first so many are listed; all others are in runs.
  std::size_t listedCount() const { return listed_.size(); }
  bool hasRuns() const { return !runs_.empty(); }

  /// The least margin of all pairs that have one of these bodies from `first_body` on, or, where
  /// `with` is false, of those that have none [m]; infinity: there are none. NaN counts as 0.
  /// O(listed pairs + runs * differences).
  double leastMargin(int first_body = 0, bool with = true) const;
  /// The greatest of all, NaN where one is NaN [m]; -infinity: there are none.
  double mostMargin() const;

  // Runs: one for each moving geometry of `runs`, over the geometries of bodies from firstStill()
  // on, which have places [0, places).
  struct Run {
    std::int32_t body, geometry;
    double margin;  ///< of all its pairs that have none of their own [m]
  };
  const std::vector<Run>& runs() const { return runs_; }
  std::size_t places() const { return places_; }
  int firstStill() const { return first_still_; }
  /// What stands in a place: a body, and which of its geometries. O(1).
  struct Geometry {
    std::int32_t body, geometry;
  };
  Geometry geometryIn(std::size_t place) const {
    return geometries_.empty() ? Geometry{first_still_ + static_cast<std::int32_t>(place), 0}
                               : geometries_[place];
  }
  /// The number of the first pair of a run; after the last run, size(). O(log left out).
  std::size_t runBegin(std::size_t run) const;
  /// The run and place of a pair that is in one. O(log left out).
  struct Place {
    std::size_t run, place;
  };
  Place placeOf(std::size_t number) const;
  double marginOf(const Place& of) const { return marginAt(of.run * places_ + of.place); }
  /// The greatest of a run's pairs, NaN where one is NaN [m]; -infinity: there are none.
  double mostMarginOfRun(std::size_t run) const;
  /// The number of a pair by run and place; -1: left out. O(log left out).
  std::int32_t numberOf(std::size_t run, std::size_t place) const;

 private:
  friend class Scene;
  friend class SceneBuilder;
  friend class SceneChange;
  friend struct SceneAccess;

  ScenePair ofRun(std::size_t number) const;
  ScenePair at(std::size_t position) const;  // of all runs, left out or not
  double marginAt(std::size_t position) const;
  bool isLeftOut(std::size_t position) const;
  std::size_t leftOutBefore(std::size_t position) const;
  void setLeftOut(const std::vector<std::size_t>& positions);  // ascending
  void listAll();
  // So many places more, with pairs in all runs.
  void addPlaces(std::size_t count);
  struct LeftOut;
  void leaveOut(std::vector<LeftOut> more);  // beside those that are; in any order

  void raise(double margin, int first_body);
  // first_place: of a body that stands still.
  void grow(int body, int geometry, double growth, std::size_t first_place);
  void keep(const std::function<bool(const ScenePair&)>& keeps, std::size_t most_listed);

  std::vector<ScenePair> listed_;
  std::size_t size_ = 0;
  std::vector<Run> runs_;
  std::size_t places_ = 0;
  int first_still_ = 0;
  std::vector<Geometry> geometries_;  // one a place; empty: each body has one
  // Positions number the runs' pairs with those that are left out: run * places + place.
  struct LeftOut {
    std::size_t begin, end, before;  // before: how many are, of the earlier ones
  };
  std::vector<LeftOut> left_out_;
  struct Own {
    std::size_t position;
    double margin;
  };
  void setOwn(const std::vector<Own>& margins);  // ascending; they replace others
  std::vector<Own> own_;  // margins that are not their run's, of pairs that are there; ascending
};

}  // namespace leeway::collision
