#pragma once

#include "tools/oracle/quad.h"
