#pragma once

#include "oracle/convex.h"
