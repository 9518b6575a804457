// The counter of tests/collision, for this program too.
#include "tests/collision/distance/allocations_test.cc"
