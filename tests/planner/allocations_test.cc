// The counter of tests/collision, for this program too.
#include "tests/collision/allocations_test.cc"
