#pragma once

#include "oracle/generate.h"
