#pragma once

// Private to planner/: the coarse pass of edge certification, sixteen intervals of an edge at once.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collision/lanes/lane_sweep.h"
#include "planner/edge/edge_frames.h"

namespace leeway::planner {

/// Intervals of one edge against all pairs, by balls and planes. Allocates in the constructor only.
class EdgeLanes {
 public:
  explicit EdgeLanes(const EdgeFrames& frames);

  /// False when this pass says nothing about the edge that `frames` has begun: reaches without
  /// bound, configurations outside the limits, or turns beyond what single precision is trusted
  /// with.
  bool begin(const EdgeFrames& frames);
  /// After begin(): all intervals [k, k + 1] / kLanes, by balls, planes and points that are known.
  /// Ids are indices into frames.pairs().
  collision::LaneSweep::Contact sweep();
  /// After a sweep() that found no contact: closes what EdgeFrames::keepsGap() knows to be free.
  void closeGaps(const EdgeFrames& frames);
  /// After a sweep() that found no contact: planes are looked for between what it left open.
  collision::LaneSweep::Contact part();
  /// The same two passes for separations that exceed each pair's threshold by `beyond` >= 0 [m]
  /// besides.
  collision::LaneSweep::Contact sweepBeyond(double beyond);
  /// Parts of the edge, one a lane: from + [0, width]. Each `from` is a multiple of `width`, which
  /// is a power of two of at least 2^-16.
  struct Parts {
    double from[collision::kLanes] = {};
    double width = 0;
    int share = 1;  ///< lanes side by side that stand for one part of the pass before
  };
  /// Those of sweep().
  static Parts wholeEdge();
  /// After sweep(): planes and points alone, for some pairs in some of the parts.
  collision::LaneSweep::Contact sweepParts(const Parts& parts,
                                           std::span<const collision::LaneSweep::Open> pairs);
  /// After begin(): a look for a contact of one pair at kLanes places spread over [from, from +
  /// width] of the edge, none of which sweep() has looked at where these are sixteenths; where
  /// there is one, if found.
  std::optional<double> meet(int pair, double from, double width);
  /// What the last sweep left.
  std::span<const collision::LaneSweep::Open> open() const { return scratch_->open(); }

  /// After sweep() or sweepBeyond(): how far points leave their chords within a lane [m], for one
  /// of the scene's motions.
  double growth(int motion) const {
    return static_cast<double>(growth_values_[static_cast<std::size_t>(motion)]);
  }

  /// After begin(): single configurations at t = 1/2 + places.
  collision::LaneSweep::Contact still(const collision::LaneValues& places);

  /// What passes cost counts into `work` from now on, see LaneSweep::Scratch::countInto().
  void countInto(collision::Work& work);

  std::size_t bytes() const { return sweep_.bytes(); }

 private:
  /// A joint that turns or slides, as a step between frames whose z axis it turns about.
  struct Step {
    int joint;
    Pose X_PJ;                 // from the frame below it to the joint, joint at rest
    Eigen::Matrix3d align;     // turns z onto the axis
    double length = 0;         // of translation and slide together, at most [m]
    bool restores = false;     // turns a floating joint's frame back to its link's axes
    std::size_t variable = 0;  // its own or its master's, by which it turns or slides
    double multiplier = 1, offset = 0;
  };
  struct LinkPlace {
    int frame = -1;
    Pose X_FL;
  };

  void addSteps();
  bool addMotions();
  int addMotion(const robots::RelativeMotion& motion);
  void addPieces(const EdgeFrames& frames);
  int worldMotion(const Piece& piece);
  void placeFrames(const collision::LaneValues& places, std::vector<collision::LaneFrame>& frames);
  void setStep(const EdgeFrames& frames, std::size_t i);

  std::shared_ptr<const CompiledScene> scene_;
  bool usable_ = true;
  std::vector<Step> steps_;
  std::vector<LinkPlace> places_;    // one a link
  std::vector<double> frame_reach_;  // sum of lengths up to a frame [m]
  double longest_ = 0;               // chain with the farthest ball [m]
  int deepest_ = 0;                  // steps of a chain
  collision::LaneGrowth growth_;
  collision::LaneSweep sweep_;
  std::unique_ptr<collision::LaneSweep::Scratch> scratch_;

  std::vector<collision::FrameStep> frame_steps_;
  std::vector<collision::LaneFrame> lane_frames_, look_frames_;
  std::vector<float> joint_motion_, growth_values_;
  std::vector<float> pass_growth_;  // that of the last pass, with what is asked for besides
  std::vector<double> middle_, q_;
  collision::Work* work_ = nullptr;    // what is counted
  std::vector<std::uint32_t> closed_;  // lanes, one an open pair
  float slack_ = 0;
};

}  // namespace leeway::planner
