#pragma once

#include <compare>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "leeway/collision/scene.h"
#include "leeway/planner/configuration_space.h"
#include "leeway/planner/problem.h"

namespace leeway::planner {

struct EdgeModel;
struct EdgeScene;
struct SceneLanes;

/// Why a pair of bodies is not checked; the first that holds.
enum class Unchecked : unsigned char {
  kRigid,         ///< no planned joint moves them against each other
  kAdjacent,      ///< a joint joins the two links
  kSrdf,          ///< the SRDF disables them
  kMjcf,          ///< MuJoCo leaves them out, by the MJCF file
  kAllowed,       ///< the problem allows them to touch
  kAttached,      ///< an object, and the link that holds it or another that may touch it
  kTouchAlways,   ///< parts that meet at a joint, proven to touch in every configuration
  kTouchSampled,  ///< parts that meet at a joint and touch at every sampled configuration
  kProvenApart,   ///< links that are proven never to touch
};
const char* toString(Unchecked why);  ///< "adjacent", "allowed by the problem", ...

/// CompiledScene::nothingChecked() of a robot without shapes.
inline constexpr const char* kNothingMoves =
    "no link that moves, and nothing that it holds, has a collision shape";

/// Pairs that are not checked for one reason.
struct UncheckedPairs {
  Unchecked why;
  int count = 0;
  /// The two bodies of each. Of kTouchSampled alone, which is the only reason that is assumed.
  std::vector<std::pair<std::string, std::string>> names = {};
};
/// "7 pairs are not checked: 4 adjacent, ..."; of no pairs "All pairs are checked".
std::string toString(std::span<const UncheckedPairs> unchecked);
/// A problem reduced to what its queries can need. Only links that the planned variables move are
/// moving bodies, the rest is folded into the world; pairs for which Unchecked has a reason are
/// left out. Constant while it is queried.
class CompiledScene {
 public:
  /// Throws robots::InputError as validate() does, for two half-spaces that may not touch, and for
  /// more pairs than an int numbers. O(n log n) in things of the world, and O(pairs) as long as
  /// these are few. What concerns the robot alone is made once for its model and kept with it, for
  /// problems that plan the same variables, from the same values of the others, with the same held
  /// objects and allowed contacts: O(pairs of links * joints), plus milliseconds a pair of links
  /// for proofs where the robot has no SRDF.
  ///
  /// `stop` is asked before each proof, now and then among objects, and before the world's
  /// hierarchy is made, which for a million objects takes a second. Throws robots::Stopped once it
  /// is true.
  explicit CompiledScene(const Problem& problem, const robots::Stop& stop = {});

  const collision::Scene& scene() const { return scene_; }
  const ConfigurationSpace& space() const { return *space_; }
  const robots::Model& model() const { return *model_; }
  /// The link that carries a body of the scene; -1 for a static body.
  int bodyLink(int body) const {
    const auto i = static_cast<std::size_t>(body);
    return i < body_link_.size() ? body_link_[i] : -1;
  }
  /// Whether a body is a link or something that the robot holds; all else is the world.
  bool isOfRobot(int body) const { return body < bodiesOfRobot(); }
  /// They are the first.
  int bodiesOfRobot() const { return static_cast<int>(body_link_.size()); }
  bool isOfRobot(const collision::ScenePair& pair) const {
    return isOfRobot(pair.body_a) && isOfRobot(pair.body_b);
  }
  /// Writes the configuration of the whole model (one number a variable) for a point of the space.
  void expand(std::span<const double> point, std::span<double> q) const;

  /// A pair of bodies that is not checked.
  struct Dropped {
    std::string a, b;
    Unchecked why;
    std::string reason = toString(why);  ///< in words, with the SRDF's own
    auto operator<=>(const Dropped&) const = default;
  };
  const std::vector<Dropped>& dropped() const { return *dropped_; }
  /// Pairs of links that are checked although they touch at the zero configuration of a robot
  /// without SRDF. If the problem has no steps, also its parts without effect: margins of pairs
  /// that are not checked, objects without a shape.
  std::vector<std::string> warnings() const {
    return warnings_ ? *warnings_ : std::vector<std::string>();
  }

  /// How a problem differs from the one that this scene was compiled from, in what compiling reads:
  /// "margins differs"; empty where it does not. Objects may also be those that withObjects() has
  /// left; shapes of deforming obstacles, and margins and pairs of variants, are not compared. What
  /// may differ: the start of planned variables, goals, steps, objective, wishes' numbers, planner,
  /// limits, seed. O(things of the world).
  std::string differenceFrom(const Problem& problem) const;
  /// Throws robots::InputError for a problem that differs, and as validate().
  void requireProblem(const Problem& problem) const;

  /// Why no answer of this scene proves anything, in words: no pair is checked, because nothing
  /// that moves has a shape, or because all pairs with the world are left out. Empty where a pair
  /// is checked, and where a robot with shapes is alone: it meets nothing. O(1) where a pair is
  /// checked.
  std::string nothingChecked() const;

  /// Another world, of which most is this one: objects come and go at the cost of what changes. An
  /// object that moves goes, and comes in its new place. Each time begin with one scene, or with
  /// the last; where changes add up to a large part of the world, compile anew.
  ///
  /// `added` get the next numbers of bodies, those without geometries none. What the problem says
  /// of pairs holds for their names, too. `removed` are numbers of bodies (scene().find()), which
  /// they keep, without pairs. Throws robots::InputError for poses and half-spaces as the
  /// constructor does, and for a name that is empty, or of a link or an object that stays;
  /// std::invalid_argument for a body of the robot, or one that is gone, in `removed`, and for a
  /// scene that has other margins or pairs than the problem says. Costs what collision::SceneChange
  /// does; the first change also O(things of the world) for their names.
  std::shared_ptr<const CompiledScene> withObjects(std::span<const Object> added,
                                                   std::span<const int> removed = {}) const;

  /// Whether bodies and pairs are those of `other`, number by number: of one scene and its variants
  /// with other shapes or margins.
  bool hasPairsOf(const CompiledScene& other) const { return pairs_token_ == other.pairs_token_; }

  // Variants. Bodies and their order stay, bounds and meshes are shared: far cheaper than compiling
  // again. They throw std::invalid_argument for a margin of NaN and a growth below 0.

  /// Every pair's margin is at least `margin` [m].
  std::shared_ptr<const CompiledScene> withMarginAtLeast(double margin) const;
  /// Only of pairs with the world.
  std::shared_ptr<const CompiledScene> withWorldMarginAtLeast(double margin) const;

  /// Every pair's margin is greater by `growth` >= 0 [m], and not below it (see
  /// collision::Scene::growMargins()): what is certified here keeps its margins for every motion
  /// that departs from it by up to `growth`.
  std::shared_ptr<const CompiledScene> withMarginsGrown(double growth) const;

  /// Another shape for a geometry of a static body, see collision::Scene::setShape() and
  /// growMargins().
  struct Replacement {
    int body, geometry;
    collision::Shape shape;
    double growth = 0;  ///< of the margins of its pairs [m]
  };
  /// Deforming obstacles take the shapes of another instant. Pairs keep their numbers. Throws
  /// std::invalid_argument for what is not geometry 0 of one of World::deforming, and for a shape
  /// that is not a snapshot of that obstacle's mesh.
  std::shared_ptr<const CompiledScene> withShapes(std::span<const Replacement> shapes) const;

  /// Only the pairs for which keep(pair) is true are checked.
  std::shared_ptr<const CompiledScene> withPairs(
      const std::function<bool(const collision::ScenePair&)>& keep) const;

  /// What certification knows of every edge; private to planner/ (planner/compiled/edge_model.h).
  const EdgeModel& edgeModel() const { return *edge_model_; }
  /// What its certifiers share, made by the first that asks; private to planner/
  /// (planner/edge/edge_frames.h and edge_lanes.h). They borrow from this scene. Thread-safe.
  const EdgeScene& edges() const;
  const SceneLanes& lanes() const;

 private:
  struct Shared;
  /// A copy of a scene has its own, as it may become another scene; and so has what was moved, as
  /// what is shared knows where its scene is.
  struct OwnShared {
    OwnShared();
    OwnShared(const OwnShared&) : OwnShared() {}
    OwnShared& operator=(const OwnShared& other);
    ~OwnShared() = default;
    std::shared_ptr<Shared> made;
  };

  struct NamedRules;
  /// The body that has the name and is not gone; -1: none. O(1), and O(things that changes added).
  int findThing(const std::string& name) const;
  /// Bodies from here on were added by changes.
  int worldEnd() const;
  std::string objectsDifference(const Problem& problem) const;
  /// Adds objects to a change that removes those bodies; returns the new bodies by name.
  std::multimap<std::string_view, int> addTo(collision::SceneChange& change,
                                             std::span<const Object> added,
                                             std::span<const int> removed) const;
  /// A copy, to be given other margins or pairs than the problem says.
  std::shared_ptr<CompiledScene> variant() const;
  /// Gives a change the margins and contacts that the problem has for these objects' names. Returns
  /// the pairs that are not checked then, without those of removed objects.
  std::shared_ptr<const std::vector<Dropped>> applyRules(
      const std::multimap<std::string_view, int>& objects,
      const std::set<std::string>& removed_names, collision::SceneChange& change) const;

  std::shared_ptr<const robots::Model> model_;
  std::shared_ptr<const ConfigurationSpace> space_;
  std::vector<double> base_configuration_;
  collision::Scene scene_;
  std::vector<int> body_link_;  // of the robot's bodies
  std::shared_ptr<const std::vector<Dropped>> dropped_;
  std::shared_ptr<const std::vector<std::string>> warnings_;  // null: none
  std::shared_ptr<const NamedRules> rules_;
  bool is_variant_ = false;  // with other margins or pairs than the rules say
  std::shared_ptr<const int> pairs_token_ = std::make_shared<const int>();  // see hasPairsOf()
  std::shared_ptr<const EdgeModel> edge_model_;
  OwnShared shared_;
};

/// How many pairs there are for each reason, in the order of Unchecked. O(dropped).
std::vector<UncheckedPairs> countUnchecked(std::span<const CompiledScene::Dropped> dropped);

}  // namespace leeway::planner
