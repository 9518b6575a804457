#pragma once

#include "leeway/collision/query.h"

namespace leeway::collision {

struct DeformScratch;      // deform/snapshot.h
struct PolytopeBuffers;    // convex/epa/polytope_surface.h
struct SweepFrontScratch;  // mesh/descent/sweep_front.h
struct SweepScratch;       // sweep/mesh_sweep_scratch.h
class TouchingTriangles;   // mesh/descent/touching_triangles.h
struct Work;               // base/work.h

/// The contents of a Scratch: one member for each folder of the engine that stores some. They are
/// references to incomplete types, so that no folder depends on another's;
/// distance/scratch_buffers.cc owns the objects.
struct Scratch::Impl {
  PolytopeBuffers& polytope;
  DeformScratch& deform;
  SweepScratch& sweep;
  SweepFrontScratch& fronts;
  TouchingTriangles& touching;
  Work* work;  ///< the counter of work; the scratch's own until countInto()

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  virtual ~Impl() = default;

 protected:
  Impl(PolytopeBuffers& polytope_buffers, DeformScratch& deform_scratch,
       SweepScratch& sweep_scratch, SweepFrontScratch& sweep_fronts,
       TouchingTriangles& touching_triangles, Work& own_work)
      : polytope(polytope_buffers),
        deform(deform_scratch),
        sweep(sweep_scratch),
        fronts(sweep_fronts),
        touching(touching_triangles),
        work(&own_work) {}
};

}  // namespace leeway::collision
