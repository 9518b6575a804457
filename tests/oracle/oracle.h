#pragma once

#include "tools/oracle/oracle.h"
