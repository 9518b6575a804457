// This program counts allocations as that of tests/collision does.
#include "tests/collision/distance/allocations_test.cc"
