#pragma once

#include "tools/oracle/generate.h"
