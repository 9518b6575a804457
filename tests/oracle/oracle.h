#pragma once

#include "oracle/oracle.h"
