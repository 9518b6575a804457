#pragma once

// Private to planner/: things of a problem by name.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leeway/planner/problem.h"

namespace leeway::planner {

/// Numbers by name. Does not store the names: nameOf(number) returns the name of an inserted
/// number. 16 to 32 bytes per name. O(1) per call.
class NameTable {
 public:
  /// Room for `count` names.
  explicit NameTable(std::size_t count) {
    std::size_t size = 16;
    while (size < 2 * count) size *= 2;
    places_.assign(size, {0, -1});
  }

  /// Inserts a number. Returns it, or the number that has the name already.
  template <class NameOf>
  int insert(int number, std::string_view name, const NameOf& nameOf) {
    const std::size_t hash = hashOf(name);
    Place& place = places_[find(name, hash, nameOf)];
    if (place.number < 0) place = {bits(hash), number};
    return place.number;
  }
  /// The number that has the name; -1 if there is none.
  template <class NameOf>
  int numberOf(std::string_view name, const NameOf& nameOf) const {
    return places_[find(name, hashOf(name), nameOf)].number;
  }

 private:
  struct Place {
    std::uint32_t bits;  // of the hash; most names differ in them
    std::int32_t number;
  };
  static std::size_t hashOf(std::string_view name) { return std::hash<std::string_view>()(name); }
  static std::uint32_t bits(std::size_t hash) { return static_cast<std::uint32_t>(hash >> 32U); }
  /// The place of the name, or the empty place where it would be inserted.
  template <class NameOf>
  std::size_t find(std::string_view name, std::size_t hash, const NameOf& nameOf) const {
    const std::size_t mask = places_.size() - 1;
    std::size_t i = hash & mask;
    while (places_[i].number >= 0 &&
           (places_[i].bits != bits(hash) || nameOf(places_[i].number) != name))
      i = (i + 1) & mask;
    return i;
  }

  std::vector<Place> places_;  // a power of two; at most half of them are in use
};

/// The links, attached objects, objects and deforming obstacles of a problem by name. Refers to the
/// problem. O(things).
class Names {
 public:
  explicit Names(const Problem& problem);

  bool isKnown(std::string_view name) const;
  /// Returns the message about an unknown name: "no link or object is named 'psot'; did you mean
  /// 'post'?". `others`: further names that are accepted.
  std::string unknown(std::string_view name, std::vector<std::string> others = {}) const;
  /// Returns the fault of a pair of names; empty if the pair is valid.
  std::string pairFault(const std::string& a, const std::string& b) const;
  /// The same for Contacts::checked, which has links alone that are not in Contacts::allowed.
  std::string checkedFault(const std::string& a, const std::string& b) const;
  /// The same for margins, which also accept kRobotWord and kWorldWord, unless a link with a shape
  /// has that name.
  std::string marginFault(const std::string& a, const std::string& b) const;
  /// The fault of the first name that is empty, reserved or used twice, with its place:
  /// "world.objects[3].name 'a' is the name of another object or link; ..."; empty if there is no
  /// fault.
  const std::string& fault() const { return fault_; }

 private:
  int count() const { return static_cast<int>(deforming_ + problem_.world.deforming.size()); }
  const std::string& name(int thing) const;
  std::string place(int thing) const;

  const Problem& problem_;
  /// Pairs of Contacts::allowed, each in the order of its names; since checkedFault() was called.
  mutable std::set<std::pair<std::string, std::string>> allowed_;
  std::size_t held_, objects_, deforming_;  // numbers of the first ones; links come before
  NameTable table_;
  std::string fault_;
};

/// Adds to `allowed` of the contacts, and takes from `checked`.
void allowPairs(const std::vector<std::pair<std::string, std::string>>& pairs, Contacts& contacts);

/// The message about a pair that has the same name twice.
std::string sameName(const std::string& name);
/// The end of a message about a name that is already in use.
inline constexpr const char* kNameTaken =
    "is the name of another object or link; a name of its own is expected";

/// All links and attached objects; in margins also those attached later. No object or frame has
/// this name.
inline constexpr const char* kRobotWord = "robot";
inline constexpr const char* kNameReserved =
    "stands for all links and what they hold; another name is expected";
/// In margins: all objects and deforming obstacles, including those that are added later. In poses:
/// the world's axes. No object or frame has this name.
inline constexpr const char* kWorldWord = "world";
inline constexpr const char* kWorldReserved =
    "stands for the world and for all objects; another name is expected";
/// Whether the robot has a link of this name without shapes. Many URDFs have one named "world".
bool isBareLink(const robots::Model& model, std::string_view name);
/// Whether kRobotWord and kWorldWord stand for all bodies of their kind in the margins of a
/// problem. They do if the margins use the word and no link with shapes has it as its name, or that
/// link is the whole robot. O(pairs + links).
struct MarginWords {
  explicit MarginWords(const Problem& problem);
  bool robot, world;
};

/// Returns the end of a message about an object's name; empty if the name is valid.
std::string objectNameFault(std::string_view name, bool is_taken);

/// Returns the message about a frame's name; empty if the name is valid.
std::string frameNameFault(const Names& names, std::string_view name);

}  // namespace leeway::planner
