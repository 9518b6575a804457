#include "collision/base/scratch.h"
#include "collision/base/work.h"
#include "collision/convex/epa/epa.h"
#include "collision/deform/snapshot.h"
#include "collision/mesh/descent/sweep_front.h"
#include "collision/mesh/descent/touching_triangles.h"
#include "collision/sweep/mesh_sweep_scratch.h"

namespace leeway::collision {

namespace {

struct Buffers {
  PolytopeBuffers polytope;
  DeformScratch deform;
  SweepScratch sweep;
  SweepFrontScratch fronts;
  TouchingTriangles touching;
  Work work;
};

/// Buffers is the first base, so that it is constructed before Impl, which refers to it.
struct OwningImpl : private Buffers, public Scratch::Impl {
  OwningImpl()
      : Scratch::Impl(Buffers::polytope, Buffers::deform, Buffers::sweep, Buffers::fronts,
                      Buffers::touching, Buffers::work) {}
};

}  // namespace

Scratch::Scratch() : impl_(std::make_unique<OwningImpl>()) {}
Scratch::~Scratch() = default;
Scratch::Scratch(Scratch&&) noexcept = default;
Scratch& Scratch::operator=(Scratch&&) noexcept = default;

void countInto(Scratch& scratch, Work& work) { scratch.impl().work = &work; }

}  // namespace leeway::collision
