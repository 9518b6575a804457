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
#include <variant>
#include <vector>

#include "leeway/collision/scene.h"
#include "leeway/planner/configuration_space.h"
#include "leeway/planner/problem.h"

namespace leeway::planner {

struct EdgeModel;
struct EdgeScene;
struct SceneLanes;

/// The reason why a pair of bodies is not checked. If several hold, the first is given.
enum class Unchecked : unsigned char {
  kRigid,         ///< no planned joint moves one relative to the other
  kAdjacent,      ///< a joint joins the two links
  kSrdf,          ///< the SRDF disables them
  kMjcf,          ///< MuJoCo or Gazebo excludes them, by the robot's file
  kAllowed,       ///< the problem allows them to touch
  kAttached,      ///< an object, and the link that holds it or another link that may touch it
  kTouchAlways,   ///< parts that meet at a joint, proven to touch in every configuration
  kTouchSampled,  ///< parts that meet at a joint and touch at every sampled configuration
};
const char* toString(Unchecked why);  ///< "adjacent", "allowed by the problem", ...

/// CompiledScene::nothingChecked() of a robot without shapes.
inline constexpr const char* kNothingMoves =
    "no link that moves, and nothing that it holds, has a collision shape";

/// Pairs that are not checked for one reason.
struct UncheckedPairs {
  Unchecked why;
  int count = 0;
  /// The two bodies of each pair. Filled only for kTouchSampled, the only reason that is an
  /// assumption.
  std::vector<std::pair<std::string, std::string>> names = {};
};
/// "7 pairs are not checked: 4 adjacent, ..."; without such pairs "All pairs are checked".
std::string toString(std::span<const UncheckedPairs> unchecked);
/// A problem reduced to the data that its queries can need. Only links that the planned variables
/// move are moving bodies; the rest is folded into the world. Pairs with a reason in Unchecked are
/// left out. Constant while it is queried.
class CompiledScene {
 public:
  /// Throws robots::InputError as validate() does, for two half-spaces that may not touch, and for
  /// more pairs than an int can number. O(n log n) in objects of the world, and O(pairs) while
  /// these are few. The data of the robot alone is computed once for its model and kept with it.
  /// Later problems use it if they plan the same variables, with the same values of the others, the
  /// same held objects and the same allowed contacts. It costs O(pairs of links * joints), plus
  /// milliseconds per pair of links for proofs if the robot has no SRDF.
  ///
  /// `stop` is polled before each proof, periodically among objects, and before the world's
  /// hierarchy is built, which takes a second for a million objects. Throws robots::Stopped once it
  /// returns true.
  explicit CompiledScene(const Problem& problem, const robots::Stop& stop = {});

  const collision::Scene& scene() const { return scene_; }
  const ConfigurationSpace& space() const { return *space_; }
  const robots::Model& model() const { return *model_; }
  /// The link that carries a body of the scene; -1 for a static body.
  int bodyLink(int body) const {
    const auto i = static_cast<std::size_t>(body);
    return i < body_link_.size() ? body_link_[i] : -1;
  }
  /// Whether a body is a link or a held object; all other bodies are the world.
  bool isOfRobot(int body) const { return body < bodiesOfRobot(); }
  /// The robot's bodies have the lowest numbers.
  int bodiesOfRobot() const { return static_cast<int>(body_link_.size()); }
  bool isOfRobot(const collision::ScenePair& pair) const {
    return isOfRobot(pair.body_a) && isOfRobot(pair.body_b);
  }
  /// Writes the configuration of the whole model (one number per variable) for a point of the
  /// space.
  void expand(std::span<const double> point, std::span<double> q) const;

  /// A pair of bodies that is not checked.
  struct Dropped {
    std::string a, b;
    Unchecked why;
    std::string reason = toString(why);  ///< in words, with the SRDF's own
    // clang-tidy 14 sees a 0 here: NOLINTNEXTLINE(modernize-use-nullptr)
    auto operator<=>(const Dropped&) const = default;
  };
  const std::vector<Dropped>& dropped() const { return *dropped_; }
  /// Pairs of links that are checked although they touch at the zero configuration of a robot
  /// without SRDF. If the problem has no steps, also parts of the problem without effect: margins
  /// of pairs that are not checked, objects without a shape.
  std::vector<std::string> warnings() const {
    return warnings_ ? *warnings_ : std::vector<std::string>();
  }

  /// How a problem differs, in the data that compiling reads, from the one that this scene was
  /// compiled from: "margins differs"; empty if it does not. Objects may also be those after
  /// withObjects(). Shapes of deforming obstacles, and margins and pairs of variants, are not
  /// compared. These may differ: the start of planned variables, goals, steps, objective, wishes'
  /// numbers, planner, limits, seed. O(objects of the world).
  std::string differenceFrom(const Problem& problem) const;
  /// Throws robots::InputError for a problem that differs, and as validate() does.
  void requireProblem(const Problem& problem) const;
  /// The same for what the problem's constraints depend on alone: robot, start, held objects, and
  /// the objects that constraints are relative to. O(joints + constraints * objects).
  void requireConstraints(const Problem& problem) const;
  /// Those of the problem.
  const Margins& margins() const;

  /// The reason why no answer of this scene proves anything, in words: no pair is checked, because
  /// no moving body has a shape, or because all pairs with the world are left out. Empty if a pair
  /// is checked, and for a robot with shapes that is alone. O(1) if a pair is checked.
  std::string nothingChecked() const;

  /// The scene with objects added and removed, at the cost of the change. To move an object, remove
  /// it and add it at its new pose. Start from the same scene each time, or from the last result.
  /// If the changes add up to a large part of the world, compile again.
  ///
  /// `added` objects get the next body numbers, or those of removed bodies that an earlier call had
  /// added; objects without geometries get none. The problem's rules for pairs also hold for their
  /// names. `removed` are body numbers (scene().find()); these bodies have no pairs any more.
  /// Throws robots::InputError for poses and half-spaces as the constructor does, for an object
  /// with a motion, and for a name that is empty or belongs to a link or a remaining object. Throws
  /// std::invalid_argument for a body of the robot, or a removed one, in `removed`, and for a
  /// variant with other margins or pairs than the problem's. The cost is that of
  /// collision::SceneChange; the first change also costs O(objects of the world) for their names.
  std::shared_ptr<const CompiledScene> withObjects(std::span<const Object> added,
                                                   std::span<const int> removed = {}) const;

  /// The same world with one of its objects elsewhere: withObjects() that removes it, and adds it
  /// at X_WO. Thousands of such moves cost as much each, because numbers of bodies are used again.
  /// Throws std::invalid_argument for a name that no object of the world has, an obstacle that
  /// deforms or has a motion (withShapes() is for these), or a cloud that was cropped or carved,
  /// and as withObjects().
  std::shared_ptr<const CompiledScene> withObjectAt(const std::string& name,
                                                    const robots::Pose& X_WO) const;

  /// The same world after a sensor saw a region of a cloud again: answers are those for renewed()
  /// (point_cloud.h) of its cloud, at the cost of the region's balls and those that earlier changes
  /// added, plus a comparison with each ball. `region` and `seen` are in the cloud's frame. `seen`
  /// is a body of its own, with the cloud's name; removed balls stay in memory. So start from the
  /// scene that was compiled where regions are the same, and compile again when most of a cloud was
  /// renewed. Throws std::invalid_argument for a name that no cloud of the world has, a cloud with
  /// a motion, what regionFault() and cloudFault() find, a `seen` that was carved at another pose,
  /// and a variant.
  std::shared_ptr<const CompiledScene> withRegion(const std::string& name,
                                                  const CloudRegion& region,
                                                  const PointCloud& seen) const;

  /// Whether bodies and pairs have the same numbers as in `other`. This holds for a scene and its
  /// variants with other shapes or margins.
  bool hasPairsOf(const CompiledScene& other) const { return pairs_token_ == other.pairs_token_; }

  // Variants. Bodies and their order stay the same, and bounds and meshes are shared, so a variant
  // is far cheaper than compiling again. These functions throw std::invalid_argument for a margin
  // of NaN and a growth below 0.

  /// Every pair's margin is at least `margin` [m].
  std::shared_ptr<const CompiledScene> withMarginAtLeast(double margin) const;
  /// The same for pairs with the world only.
  std::shared_ptr<const CompiledScene> withWorldMarginAtLeast(double margin) const;

  /// Every pair's margin is greater by at least `growth` >= 0 [m] (see
  /// collision::Scene::growMargins()). A motion that is certified here keeps its margins for every
  /// motion that departs from it by up to `growth`.
  std::shared_ptr<const CompiledScene> withMarginsGrown(double growth) const;

  /// The state of an obstacle that moves at another instant: the shape of a deforming one, the pose
  /// X_WB of a rigid one; see collision::Scene::setShape(), setPoses() and growMargins().
  struct Replacement {
    int body, geometry;
    std::variant<collision::Shape, robots::Pose> now;
    double growth = 0;  ///< of the margins of its pairs [m]
  };
  /// Obstacles that move are as at another instant. Pairs keep their numbers. Throws
  /// std::invalid_argument for anything but the shape of geometry 0 of one of World::deforming,
  /// which must be a snapshot of that obstacle's mesh, or the pose of an object that has a motion.
  std::shared_ptr<const CompiledScene> withShapes(std::span<const Replacement> shapes) const;

  /// Only the pairs for which keep(pair) is true are checked.
  std::shared_ptr<const CompiledScene> withPairs(
      const std::function<bool(const collision::ScenePair&)>& keep) const;

  /// Data for certifying every edge; private to planner/ (planner/compiled/edge_model.h).
  const EdgeModel& edgeModel() const { return *edge_model_; }
  /// The least distance of all crops of clouds [m]; infinite: none. What was cropped is farther
  /// than that from the robot within the joints' limits; configurations outside them are then
  /// undecided.
  double completeWithin() const;
  /// Data that the scene's certifiers share, created at the first use; private to planner/
  /// (planner/edge/edge_frames.h and edge_lanes.h). It refers to this scene. Thread-safe.
  const EdgeScene& edges() const;
  const SceneLanes& lanes() const;

 private:
  struct Shared;
  /// A copy of a scene has its own shared data, because it may become another scene. So has a moved
  /// scene, because the shared data refers to the address of its scene.
  struct OwnShared {
    OwnShared();
    OwnShared(const OwnShared&) : OwnShared() {}
    OwnShared& operator=(const OwnShared& other);
    ~OwnShared() = default;
    std::shared_ptr<Shared> made;
  };

  struct NamedRules;
  /// The body with the name that is not removed; -1: none. O(1), and O(objects that changes added).
  int findThing(const std::string& name) const;
  /// Bodies from this number on were added by changes.
  int worldEnd() const;
  /// A body of an object; an object has more of them if regions of its cloud were renewed.
  struct Part {
    int body;
    std::shared_ptr<const std::vector<char>> is_gone;  ///< of each ball; null: none is
    bool has(std::size_t ball) const { return !is_gone || (*is_gone)[ball] == 0; }
  };
  /// The bodies of the object that a body is of, in the order in which their balls were seen.
  std::vector<Part> partsOf(int body) const;
  /// The balls that these bodies still have.
  std::vector<collision::Ball> ballsOf(std::span<const Part> parts) const;
  std::string objectsDifference(const Problem& problem) const;
  std::string robotDifference(const Problem& problem) const;
  /// Adds objects to a change that removes the given bodies; returns the new bodies by name.
  std::multimap<std::string_view, int> addTo(collision::SceneChange& change,
                                             std::span<const Object> added,
                                             std::span<const int> removed) const;
  /// A copy with objects added and removed.
  std::shared_ptr<CompiledScene> changed(std::span<const Object> added,
                                         std::span<const int> removed) const;
  /// A copy whose margins or pairs may be changed from the problem's.
  std::shared_ptr<CompiledScene> variant() const;
  /// Applies the problem's margins and contacts for these objects' names to a change. Returns the
  /// pairs that are then not checked, without those of removed objects.
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
  bool is_variant_ = false;   // with other margins or pairs than the rules
  bool lacks_pairs_ = false;  // withPairs()
  std::shared_ptr<const int> pairs_token_ = std::make_shared<const int>();  // see hasPairsOf()
  std::shared_ptr<const EdgeModel> edge_model_;
  OwnShared shared_;
};

/// The number of pairs for each reason, in the order of Unchecked. O(dropped).
std::vector<UncheckedPairs> countUnchecked(std::span<const CompiledScene::Dropped> dropped);

}  // namespace leeway::planner
