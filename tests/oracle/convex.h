#pragma once

#include "tools/oracle/convex.h"
