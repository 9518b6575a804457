#pragma once

// Private to planner/: the coarse pass of edge certification over sixteen intervals of an edge at
// once.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/base/spare_memory.h"
#include "collision/base/work.h"
#include "collision/lanes/lane_sweep.h"
#include "planner/compiled/robot_lanes.h"
#include "planner/edge/edge_frames.h"

namespace leeway::planner {

/// The lanes of a compiled scene: those of its robot and of its world. Constant; shared by
/// certifiers.
struct SceneLanes {
  SceneLanes(const CompiledScene& scene, const EdgeScene& edges);

  const RobotLanes& robot;
  bool usable = true;  ///< false: lanes are not valid for this scene
  double longest = 0;  ///< reach of the chain with the farthest ball [m]
  collision::LaneSweep sweep;

 private:
  /// Adds the world's pieces that have pairs, and sets the data that depends on all pieces in use.
  /// Returns one entry for each of EdgeScene::pieces that is in no place.
  std::vector<RobotLanes::Piece> addPieces(const CompiledScene& scene, const EdgeScene& edges);
  /// Adds the objects in places for which LaneSweep::needsObstacle() holds. Lanes create the others
  /// when they are near.
  void addPlaced(const CompiledScene& scene, const EdgeScene& edges);
  void addPairs(const EdgeScene& edges, std::span<const RobotLanes::Piece> lane_pieces);
  void setWorld(const CompiledScene& scene, const EdgeScene& edges,
                std::span<const RobotLanes::Piece> lane_pieces);
};

/// The intervals of one edge, one per lane, against all pairs, by balls, planes and points; see
/// collision::LaneSweep. Ids in its answers are indices into EdgeFrames::pairs(). Allocates only in
/// the constructor.
class EdgeLanes {
 public:
  /// Counts the cost of passes into `work`; see LaneSweep::Scratch.
  EdgeLanes(const EdgeFrames& frames, collision::Scratch& queries, collision::Work& work);

  /// Takes the edge that `frames` has begun. False if lanes do not apply: another scene than at
  /// first (EdgeFrames::rebind()), whose shapes they do not have, reaches without bound,
  /// configurations outside the limits, or turns too large for single precision. Call it before the
  /// passes below. O(joints).
  bool begin(const EdgeFrames& frames);
  /// From now on, the passes that decide whether an edge is free require separations above each
  /// pair's threshold plus `beyond` >= 0 [m].
  void demandBeyond(double beyond) { beyond_ = beyond; }

  /// Checks all intervals [k, k + 1] / kLanes of the pairs in question. It uses balls, the proofs
  /// of EdgeFrames::keepsGap() over the whole edge, and the planes and points that decided a pair
  /// last. `frames` must be as in begin(). See LaneSweep::run().
  collision::LaneSweep::Contact sweep(const EdgeFrames& frames, const Asked& asked);
  /// Runs after a sweep() without contact. Closes the intervals in which EdgeFrames::keepsGap()
  /// holds.
  void closeGaps(const EdgeFrames& frames, const Asked& asked);
  /// Runs after a sweep() without contact. Searches planes for the pairs that it left open.
  collision::LaneSweep::Contact searchPlanes();
  /// As sweep(), for separations above each pair's threshold plus `beyond` >= 0 [m], in place of
  /// what demandBeyond() set.
  collision::LaneSweep::Contact sweepBeyond(const EdgeFrames& frames, const Asked& asked,
                                            double beyond);

  /// Parts of the edge, one in each lane: from + [0, width]. Each `from` is a multiple of `width`,
  /// which is a power of two of at least 2^-16.
  struct Parts {
    double from[collision::kLanes] = {};
    double width = 0;
    int share = 1;  ///< neighbours that make up one part of the previous pass

    /// From the start of the first of some parts to the end of the last one.
    struct Range {
      double from, width;
      double middle() const { return from + width / 2; }
      bool operator==(const Range&) const = default;
    };
    Range rangeOf(std::uint32_t intervals) const;
    double middle(int interval) const { return from[interval] + width / 2; }
  };
  /// The parts of sweep().
  static const Parts& wholeEdge();
  /// Runs after sweep(): planes and points only, for some pairs in some of the parts.
  collision::LaneSweep::Contact sweepParts(const Parts& parts,
                                           std::span<const collision::LaneSweep::Open> pairs);
  /// A place where a pair is in contact, if one is found at kLanes configurations spread over
  /// [from, from + width]. If these are whole sixteenths, sweep() has not checked any of them.
  std::optional<double> findContact(int pair, double from, double width);
  /// Whether more pairs were near in the last pass over the whole edge than there is room for. Then
  /// some pairs were not checked.
  bool isFull() const { return scratch_.isFull(); }
  /// The pairs that the last pass left open.
  std::span<const collision::LaneSweep::Open> open() const { return scratch_.open(); }

  /// After sweep() or sweepBeyond(): h^2 A / 8, how far points leave their chords within an
  /// interval [m], for one of EdgeModel::motions.
  double growth(int motion) const {
    return static_cast<double>(growth_values_[static_cast<std::size_t>(motion)]);
  }

  /// Checks single configurations, at t = 1/2 + places.
  collision::LaneSweep::Contact checkStates(const collision::LaneValues& places);

  std::size_t bytes() const { return lanes_.sweep.bytes(); }

 private:
  using Step = RobotLanes::Step;

  /// Computes motions of the placed frames over the whole edge, and how far they leave their
  /// chords.
  void beginPass(const EdgeFrames& frames, const collision::LaneValues& middles);
  void demandInPass(double beyond);

  void placeFrames(const collision::LaneValues& places, std::span<collision::LaneFrame> frames);
  void setStep(const EdgeFrames& frames, std::size_t i);
  void setFloatingStep(const Step& step, const double* q, const double* dq,
                       collision::FrameStep& out) const;

  // Constant.
  std::shared_ptr<const CompiledScene> scene_;
  const SceneLanes& lanes_;  // of the scene
  const RobotLanes& robot_;  // the robot's part of lanes_

  collision::Work& work_;

  // The current edge.
  collision::LaneSweep::Scratch scratch_;
  std::vector<collision::FrameStep> frame_steps_;
  // The frames are not initialized: they are placed, and moved, before they are read.
  collision::SpareArray<collision::LaneFrame> frames_;
  std::span<collision::LaneFrame> lane_frames_, contact_frames_;  // in frames_
  std::vector<float> joint_motion_, growth_values_;
  std::vector<float>
      pass_growth_;  ///< of the last pass, including the distance beyond the thresholds
  std::vector<double> middle_, q_;     ///< the edge's middle, as a point and as a configuration
  std::vector<std::uint32_t> closed_;  ///< intervals, one entry per open pair
  float slack_ = 0;                    ///< rounding of frames [m]
  double beyond_ = 0;                  ///< set by demandBeyond() [m]
};

}  // namespace leeway::planner
