#pragma once

// Private to planner/: the coarse pass of edge certification, sixteen intervals of an edge at once.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/lanes/lane_sweep.h"
#include "planner/compiled/robot_lanes.h"
#include "planner/edge/edge_frames.h"

namespace leeway::planner {

/// The lanes of a compiled scene: its robot's, and its world's. Constant; shared by certifiers.
struct SceneLanes {
  SceneLanes(const CompiledScene& scene, const EdgeScene& edges);

  const RobotLanes& robot;
  bool usable = true;  ///< false: lanes cannot be trusted with this scene
  double longest = 0;  ///< reach of the chain with the farthest ball [m]
  collision::LaneSweep sweep;

 private:
  /// Adds the pieces of the world that pairs use, and sets what depends on all pieces in use.
  /// Returns one for each of EdgeScene::pieces that is in no place.
  std::vector<RobotLanes::Piece> addPieces(const CompiledScene& scene, const EdgeScene& edges);
  /// The things in places that LaneSweep::needsObstacle() names. Lanes make the others when they
  /// are near.
  void addPlaced(const CompiledScene& scene, const EdgeScene& edges);
  void addPairs(const EdgeScene& edges, std::span<const RobotLanes::Piece> lane_pieces);
  void setWorld(const CompiledScene& scene, const EdgeScene& edges,
                std::span<const RobotLanes::Piece> lane_pieces);
};

/// The intervals of one edge, a lane each, against all pairs, by balls, planes and points: see
/// collision::LaneSweep. Ids in its answers are indices into EdgeFrames::pairs(). Allocates in the
/// constructor only.
class EdgeLanes {
 public:
  explicit EdgeLanes(const EdgeFrames& frames);

  /// Takes the edge that `frames` has begun. False when lanes say nothing about it: reaches without
  /// bound, configurations outside the limits, or turns beyond what single precision is trusted
  /// with. The passes below come after it. O(joints).
  bool begin(const EdgeFrames& frames);
  /// The passes that decide whether an edge is free ask from now on for separations above each
  /// pair's threshold plus `beyond` >= 0 [m].
  void demandBeyond(double beyond) { beyond_ = beyond; }

  /// All intervals [k, k + 1] / kLanes of the pairs that are asked, by balls, by what
  /// EdgeFrames::keepsGap() proves of the whole edge for thresholds of at least `demanded` plus
  /// rounding [m], and by the planes and points that decided a pair last. `frames` as begin() had
  /// it. See LaneSweep::run().
  collision::LaneSweep::Contact sweep(const EdgeFrames& frames, Pairs asked, double demanded);
  /// After a sweep() without contact: closes the lanes in which EdgeFrames::keepsGap() holds for
  /// thresholds of at least `demanded` plus rounding [m].
  void closeGaps(const EdgeFrames& frames, double demanded);
  /// After a sweep() without contact: searches planes between what it left open.
  collision::LaneSweep::Contact searchPlanes();
  /// As sweep(), for separations above each pair's threshold plus `beyond` >= 0 [m].
  collision::LaneSweep::Contact sweepBeyond(const EdgeFrames& frames, Pairs asked, double beyond);

  /// Parts of the edge, one a lane: from + [0, width]. Each `from` is a multiple of `width`, which
  /// is a power of two of at least 2^-16.
  struct Parts {
    double from[collision::kLanes] = {};
    double width = 0;
    int share = 1;  ///< neighbouring lanes that stand for one part of the pass before

    /// From where the first of some lanes begins to where the last of them ends.
    struct Range {
      double from, width;
      double middle() const { return from + width / 2; }
      bool operator==(const Range&) const = default;
    };
    Range rangeOf(std::uint32_t lanes) const;
    double middle(int lane) const { return from[lane] + width / 2; }
  };
  /// The parts of sweep().
  static const Parts& wholeEdge();
  /// After sweep(): planes and points alone, for some pairs in some of the parts.
  collision::LaneSweep::Contact sweepParts(const Parts& parts,
                                           std::span<const collision::LaneSweep::Open> pairs);
  /// A place where a pair is in contact, if one is found at kLanes configurations spread over
  /// [from, from + width]. Where these are whole sixteenths, sweep() has looked at none of them.
  std::optional<double> findContact(int pair, double from, double width);
  /// More was near in the last pass over the whole edge than there is room for: of some pairs
  /// nothing is known.
  bool isFull() const { return scratch_->isFull(); }
  /// What the last pass left open.
  std::span<const collision::LaneSweep::Open> open() const { return scratch_->open(); }

  /// After sweep() or sweepBeyond(): h^2 A / 8, how far points leave their chords within a lane
  /// [m], for one of EdgeModel::motions.
  double growth(int motion) const {
    return static_cast<double>(growth_values_[static_cast<std::size_t>(motion)]);
  }

  /// Single configurations, at t = 1/2 + places.
  collision::LaneSweep::Contact checkStates(const collision::LaneValues& places);

  /// Counts what passes cost into `work` from now on, see LaneSweep::Scratch::countInto().
  void countInto(collision::Work& work);

  std::size_t bytes() const { return lanes_.sweep.bytes(); }

 private:
  using Step = RobotLanes::Step;

  /// Motions of the placed frames over the whole edge, and what they leave their chords by.
  void beginPass(const EdgeFrames& frames, const collision::LaneValues& middles);
  void demandInPass(double beyond);

  void placeFrames(const collision::LaneValues& places, std::vector<collision::LaneFrame>& frames);
  void setStep(const EdgeFrames& frames, std::size_t i);
  void setFloatingStep(const Step& step, const double* q, const double* dq,
                       collision::FrameStep& out) const;

  // Constant.
  std::shared_ptr<const CompiledScene> scene_;
  const SceneLanes& lanes_;  // the scene's
  const RobotLanes& robot_;  // theirs

  // Of the present edge.
  std::unique_ptr<collision::LaneSweep::Scratch> scratch_;
  std::vector<collision::FrameStep> frame_steps_;
  std::vector<collision::LaneFrame> lane_frames_, contact_frames_;
  std::vector<float> joint_motion_, growth_values_;
  std::vector<float> pass_growth_;     ///< of the last pass, with what is demanded beyond
  std::vector<double> middle_, q_;     ///< the edge's middle, as a point and as a configuration
  std::vector<std::uint32_t> closed_;  ///< lanes, one an open pair
  float slack_ = 0;                    ///< rounding of frames [m]
  double beyond_ = 0;                  ///< of demandBeyond() [m]
  collision::Work* work_ = nullptr;
};

}  // namespace leeway::planner
